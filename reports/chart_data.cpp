#include "reports/chart_data.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace uiclink {
namespace {

constexpr double kSteps = 65534;
constexpr std::uint16_t kGap = 65535;

}  // namespace

PackedValues PackValues(const std::vector<double>& values, bool log) {
  const auto bend = [log](double value) {
    if (!std::isfinite(value) || (log && value <= 0)) return std::numeric_limits<double>::quiet_NaN();
    return log ? std::log10(value) : value;
  };
  double from = INFINITY, to = -INFINITY;
  for (const double value : values) {
    const double bent = bend(value);
    if (std::isnan(bent)) continue;
    from = std::min(from, bent);
    to = std::max(to, bent);
  }
  if (!(from <= to)) from = to = 0;       // gaps only
  const double half = to / 2 - from / 2;  // of the range: that could be beyond the largest number
  std::string bytes;
  bytes.reserve(2 * values.size());
  for (const double value : values) {
    const double bent = bend(value);
    std::uint16_t n = kGap;
    if (!std::isnan(bent))
      n = half > 0 ? static_cast<std::uint16_t>(std::lround(kSteps * ((bent / 2 - from / 2) / half))) : 0;
    bytes += static_cast<char>(n & 0xff);
    bytes += static_cast<char>(n >> 8);
  }
  return {from, to, EncodeBase64(bytes)};
}

std::string EncodeBase64(const std::string& bytes) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string letters;
  letters.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j) bits = bits << 8 | (j < count ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) letters += j <= count ? kLetters[bits >> (18 - 6 * j) & 63] : '=';
  }
  return letters;
}

}  // namespace uiclink
