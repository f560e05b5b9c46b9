#include "vehicle/bench_check.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace uiclink {

void CheckPositive(const char* function, const char* name, double value, const char* unit) {
  if (value > 0 && std::isfinite(value)) return;
  throw std::invalid_argument(fmt::format("{}: {} = {} {}, must be positive", function, name, value, unit));
}

void CheckAtLeast(const char* function, const char* name, int value, int least) {
  if (value >= least) return;
  throw std::invalid_argument(fmt::format("{}: {} = {}, must be at least {}", function, name, value, least));
}

void CheckLeaf(const char* function, const LeafSpring& spring) {
  CheckPositive(function, "spring.c", spring.c, "N/m");
  CheckPositive(function, "spring.beta", spring.beta, "m");
  if (!(spring.F_r >= 0) || !std::isfinite(spring.F_r))
    throw std::invalid_argument(fmt::format("{}: spring.F_r = {} N, must be >= 0", function, spring.F_r));
  if (!(spring.mu0 >= 0 && spring.mu0 < 1))
    throw std::invalid_argument(fmt::format("{}: spring.mu0 = {}, must be from 0 to below 1", function, spring.mu0));
}

std::size_t CountSamples(const char* function, double duration, double step) {
  CheckPositive(function, "duration", duration, "s");
  CheckPositive(function, "step", step, "s");
  const double samples = std::floor(duration / step * (1 + 1e-12)) + 1;  // rounding of a ratio meant to be whole
  if (!(samples <= 1e7))
    throw std::invalid_argument(
        fmt::format("{}: {} samples of {} s in {} s, must be at most 1e7", function, samples, step, duration));
  return static_cast<std::size_t>(samples);
}

}  // namespace uiclink
