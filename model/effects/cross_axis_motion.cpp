#include <cmath>
#include <numbers>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Sensed displacement = y + exp(-decay s) (A_cos cos 2 pi f s + A_sin sin 2 pi f s),  s = t - fit_start.
template <typename T>
struct CrossAxisMotion {
  static T Read(std::span<const T> p, double t, double fit_start, const T& input) {
    using std::cos;
    using std::exp;
    using std::sin;
    const double s = t - fit_start;
    const T phase = p[2] * (2 * std::numbers::pi * s);
    return input + exp(p[3] * -s) * (p[0] * cos(phase) + p[1] * sin(phase));
  }
};

}  // namespace

const Effect& CrossAxisMotionEffect() {
  static const Effect effect{
      .id = "cross_axis_motion",
      .title = "the other direction's oscillation in the reading",
      .equation = "reading of y + A exp(-decay t) cos(2 pi f t + phase)",
      .acts_on = ActsOn::kMeasurement,
      .parameters = {{.symbol = "A_cos",
                      .unit = "m",
                      .meaning = "cosine part where the fit begins",
                      .low = -0.02,
                      .high = 0.02,
                      .scope = Scope::kRecord,
                      .starts = {5e-4}},
                     {.symbol = "A_sin",
                      .unit = "m",
                      .meaning = "sine part where the fit begins",
                      .low = -0.02,
                      .high = 0.02,
                      .scope = Scope::kRecord,
                      .starts = {0}},
                     {.symbol = "f",
                      .unit = "Hz",
                      .meaning = "frequency",
                      .low = 0.3,
                      .high = 3,
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSpectrum},
                     {.symbol = "decay",
                      .unit = "1/s",
                      .meaning = "decay rate",
                      .low = 1e-3,
                      .high = 3,
                      .coordinate = Coordinate::kLog,
                      .starts = {0.1, 0.4}}},
      .quadrature = true,
      .signature = {.text = "a decaying line at the other direction's frequency, no harmonic of this one"},
      .confused_with = "rig_mode",
      .separated_by = "the other channel recorded at the same time",
      .repairs = {"residual_spectrum"},
      .stage = ReadingStage::kSensed,
      .reading = MakeReading<CrossAxisMotion>()};
  return effect;
}

}  // namespace uiclink
