#pragma once

#include <string>
#include <vector>

namespace uiclink {

/// Numbers at the resolution of a drawing: of 16 bits each, in steps of 1/65534 of their range, so that a value is off
/// by less than a pixel of a chart magnified a hundred times.
///
///   value = from + (to - from) n / 65534,     n = 65535: a gap;      on a logarithmic axis: its exponent of ten
struct PackedValues {
  double from = 0;
  double to = 0;
  std::string numbers;  ///< n of each value, low byte first, in base 64 (RFC 4648)
};

/// @param log  values <= 0 become gaps, as those do that are not finite.
PackedValues PackValues(const std::vector<double>& values, bool log);

/// Bytes in base 64 with padding (RFC 4648).
std::string EncodeBase64(const std::string& bytes);

}  // namespace uiclink
