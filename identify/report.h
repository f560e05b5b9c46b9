#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/diagnosis.h"
#include "identify/identification.h"
#include "identify/validate.h"
#include "model/parameter_set.h"

namespace uiclink {

/// A record that never became one: the file and what is wrong with it ("file:line: expected ..., found ...").
struct Rejected {
  std::string file;
  std::string message;
};

/// Everything that a run of `identify` found, for one or both directions.
struct RunResult {
  std::vector<Identification> directions;
  std::vector<Diagnosis> diagnoses;  ///< one per direction; empty when none was asked for
  std::vector<Rejected> rejected;    ///< files that could not be read
  std::optional<Validation> wagon;   ///< what the identified link does on the wagon, where that was asked for
};

/// Tables and sentences for the terminal.
std::string FormatReport(const RunResult& run);

/// The diagnosis of one direction: what the plain model gets wrong, why, and what the extended model gains. At most 110
/// columns.
std::string FormatDiagnosis(const Identification& identification, const Diagnosis& diagnosis);

/// What is not trustworthy because a diagnosis left structure unexplained, a line per direction; for standard error.
std::vector<std::string> FormatDiagnosisWarnings(const RunResult& run);

/// JSON of schema "identify/1".
std::string FormatJson(const RunResult& run);

/// What the wagon reads: the identified link in both directions, with covariance and provenance. Where causes were
/// named it is the extended link, with the parameters of the effects that belong to it.
ParameterSet MakeParameterSet(const RunResult& run);
/// The plain model's link, whatever was named.
ParameterSet MakePlainParameterSet(const RunResult& run);
/// Was a cause named in any direction, so that the two sets differ?
bool HasCauses(const RunResult& run);

/// Comma-separated values, a line per sample of every used record: file, time_s, measured_mm, modelled_mm, residual_mm,
/// and where there is a diagnosis extended_mm, extended_residual_mm (the plain model's where no cause was named).
/// measured, modelled and extended are readings (the sensor's zero is kept); residual = measured - modelled.
std::string FormatResiduals(const RunResult& run);

/// What the models leave of the fitted samples of the used records of a direction, model - reading [m], by record.
struct ReadingResiduals {
  std::vector<std::vector<double>> plain;
  std::vector<std::vector<double>> extended;  ///< those of the plain model where no cause was named
};
/// One per direction.
std::vector<ReadingResiduals> CalcReadingResiduals(const RunResult& run);
/// The same as FormatResiduals(run), from what CalcReadingResiduals(run) gave.
std::string FormatResiduals(const RunResult& run, std::span<const ReadingResiduals> residuals);

/// Share by which the published frequency method is expected to read k too high, from the closed form, for one arc.
double CalcExpectedBias(const Identification& identification, const SineFit& sine, const SlidingArc& arc);

}  // namespace uiclink
