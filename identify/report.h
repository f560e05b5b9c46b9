#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/diagnosis.h"
#include "identify/identification.h"
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
};

/// Tables and sentences for the terminal.
std::string FormatReport(const RunResult& run);

/// The diagnosis of one direction: what the plain model gets wrong, why, and what the extended model gains.
std::string FormatDiagnosis(const Identification& identification, const Diagnosis& diagnosis);

/// JSON of schema "identify/1".
std::string FormatJson(const RunResult& run);

/// What the wagon reads: the identified link in both directions, with covariance and provenance.
ParameterSet MakeParameterSet(const RunResult& run);

/// Comma-separated values, a line per sample of every used record: file, time_s, measured_mm, modelled_mm, residual_mm.
/// measured and modelled are readings (the sensor's zero is kept); residual = measured - modelled.
std::string FormatResiduals(const RunResult& run);

/// Share by which the published frequency method is expected to read k too high, from the closed form, for one arc.
double CalcExpectedBias(const Identification& identification, const SineFit& sine, const SlidingArc& arc);

}  // namespace uiclink
