#include "identify/symptoms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "identify/frequency_method_bias.h"
#include "identify/reading_limits.h"
#include "identify/residual_patterns.h"
#include "identify/residual_spectrum.h"
#include "identify/swing_symptoms.h"

namespace uiclink {
namespace {

void Check(const SymptomInput& input) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("FindSymptoms: " + what); };
  if (input.record == nullptr) fail("record is missing");
  const Record& record = *input.record;
  if (input.first + input.size > record.t.size() || input.modelled.size() != input.size)
    fail(fmt::format("{}: samples {} to {} and {} modelled readings of {} samples", record.file, input.first,
                     input.first + input.size, input.modelled.size(), record.t.size()));
  if (input.size < kMinSamples)
    fail(fmt::format("{}: {} samples, must be {} at least", record.file, input.size, kMinSamples));
  if (!(input.sigma > 0)) fail(fmt::format("{}: sigma = {} m, must be > 0", record.file, input.sigma));
  for (const Eigen::MatrixXd* columns : {input.own, input.common})
    if (columns != nullptr && columns->rows() != static_cast<Eigen::Index>(input.size))
      fail(fmt::format("{}: derivatives have {} rows, must be {}", record.file, columns->rows(), input.size));
}

}  // namespace

bool Symptom::IsSignificant() const { return std::abs(z) >= kSymptomThreshold; }

Symptoms FindSymptoms(std::span<const SymptomInput> records, Direction direction) {
  Symptoms symptoms;
  if (records.empty()) return symptoms;
  for (const SymptomInput& input : records) Check(input);
  FindSwingSymptoms(records, &symptoms);
  FindSpectralSymptoms(records, direction, &symptoms);
  FindResidualPatterns(records, &symptoms);
  FindReadingLimits(records, &symptoms);
  FindFrequencyMethodBias(records, &symptoms);
  std::stable_sort(symptoms.list.begin(), symptoms.list.end(),
                   [](const Symptom& a, const Symptom& b) { return std::abs(a.z) > std::abs(b.z); });
  return symptoms;
}

}  // namespace uiclink
