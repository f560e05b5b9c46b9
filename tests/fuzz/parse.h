#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "data/input_error.h"
#include "identify/noise.h"
#include "identify/record.h"

namespace uiclink::fuzz {

/// Options as a user might give them, chosen by a byte: none, a rate, a column, both.
inline ReadOptions OptionsFor(unsigned char byte) {
  ReadOptions options;
  if (byte & 1) options.rate_hz = 200;
  if (byte & 2) options.column = 1 + (byte >> 2) % 4;
  return options;
}

inline void Require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

/// What the contract of a record promises, whatever the text was.
inline void RequireContract(const Record& record) {
  Require(record.t.size() == record.y.size(), "as many times as readings");
  Require(record.y.size() >= kMinSamples, "enough samples");
  Require(record.sampling_hz > 0, "a rate");
  for (const double y : record.y) Require(y >= -kMaxDisplacement && y <= kMaxDisplacement, "believable readings");
  for (std::size_t i = 1; i < record.t.size(); ++i) Require(record.t[i] > record.t[i - 1], "increasing times");
}

/// Reads `text`, which may be anything. True if it was a record. Throws nothing but std::logic_error, for a broken
/// promise.
inline bool Parse(std::string_view text, const ReadOptions& options) {
  std::optional<Record> record;
  try {
    record = ParseRecord(text, "fuzz.txt", options);
  } catch (const InputError&) {
    return false;
  }
  RequireContract(*record);
  const Noise noise = EstimateNoise(record->t, record->y);
  Require(noise.sigma >= 0 && noise.quantum >= 0, "a noise level");  // false for NaN
  return true;
}

}  // namespace uiclink::fuzz
