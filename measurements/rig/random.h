#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace uiclink::rig {

/// Normal deviates that are the same on every compiler.
///
/// The engine and std::seed_seq are fixed bit by bit by the C++ standard, std::normal_distribution is not. So: uniforms
/// u = (engine >> 11) 2^-53 in [0, 1), and Box-Muller  sqrt(-2 ln(1 - u1)) {cos, sin}(2 pi u2),  cosine first. What is
/// left to the platform is the last bit of log, cos and sin.
class NormalGenerator {
 public:
  /// What the deviates are for. Each stream is independent, so that another noise level keeps the same links.
  enum class Stream : std::uint32_t { kLink = 1, kPush = 2, kSensor = 3 };

  NormalGenerator(std::uint64_t seed, int index, Stream stream) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                           static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(stream)};
    engine_.seed(sequence);
  }

  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  double operator()() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log1p(-Uniform()));
    const double angle = 2 * std::numbers::pi * Uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace uiclink::rig
