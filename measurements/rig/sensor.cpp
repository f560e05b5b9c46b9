#include "measurements/rig/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uiclink::rig {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// What moves at the sensor besides the link: the other direction's oscillation and a mode of beam or frame.
double OtherMotion(const EffectSizes& e, double t, double since_release) {
  double q = 0;
  if (e.cross_A != 0) q += e.cross_A * std::exp(-e.cross_decay * t) * std::cos(kTwoPi * e.cross_f * t + e.cross_phase);
  if (e.mode_A != 0 && since_release > 0) {
    const double w = kTwoPi * e.mode_f;
    const double damped = std::sqrt(1 - e.mode_zeta * e.mode_zeta);
    q += e.mode_A / damped * std::exp(-e.mode_zeta * w * since_release) * std::sin(w * damped * since_release);
  }
  return q;
}

/// The converter: the nearest code of the range, the end codes beyond it [mm].
double Convert(double reading, const Sensor& sensor) {
  const double half = std::ldexp(1.0, sensor.bits - 1);
  const double code = std::clamp(std::floor(reading / sensor.range * half + 0.5), -half, half - 1);
  return code * (1e3 * sensor.range / half);
}

}  // namespace

std::vector<double> Measure(const std::vector<double>& y, const Truth& truth, const Sensor& sensor,
                            NormalGenerator& normal) {
  const EffectSizes& e = truth.link.effects;
  std::vector<double> kept;
  kept.reserve(y.size() / static_cast<std::size_t>(sensor.keep_every) + 1);
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double noise = sensor.noise * normal();  // drawn for every sample: keep_every changes which ones are seen
    if (i % static_cast<std::size_t>(sensor.keep_every) != 0) continue;
    const double t = static_cast<double>(i) / sensor.sampling_hz;
    const double at_sensor = y[i] + OtherMotion(e, t, t - truth.release_s);
    double reading = at_sensor * (1 + e.nonlinearity_e * at_sensor) + truth.zero_offset + e.drift_rate * t + noise;
    if (e.hum_A != 0) reading += e.hum_A * std::sin(kTwoPi * e.hum_f * t + e.hum_phase);
    reading = std::clamp(reading, -e.saturation_level, e.saturation_level);
    kept.push_back(Convert(reading, sensor));
  }
  return kept;
}

}  // namespace uiclink::rig
