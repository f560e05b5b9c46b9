#include <cmath>
#include <numbers>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Sensed displacement = y + q,  q'' + 2 zeta w q' + w^2 q = 0,  w = 2 pi f:
///   q = exp(-zeta w s) (A_cos cos w_d s + A_sin sin w_d s),  w_d = w sqrt(1 - zeta^2),  s = t - fit_start.
template <typename T>
struct RigMode {
  static T Read(std::span<const T> p, double t, double fit_start, const T& input) {
    using std::cos;
    using std::exp;
    using std::sin;
    using std::sqrt;
    const T ws = p[2] * (2 * std::numbers::pi * (t - fit_start));
    const T phase = ws * sqrt(1.0 - p[3] * p[3]);
    return input + exp(-p[3] * ws) * (p[0] * cos(phase) + p[1] * sin(phase));
  }
};

}  // namespace

const Effect& RigModeEffect() {
  static const Effect effect{
      .id = "rig_mode",
      .title = "a mode of beam or frame, excited at release",
      .equation =
          "reading of y + q,  q'' + 2 zeta w q' + w^2 q = 0,  w = 2 pi f,  q of amplitude A where the fit begins",
      .acts_on = ActsOn::kMeasurement,
      .parameters = {{.symbol = "A_cos",
                      .unit = "m",
                      .meaning = "cosine part where the fit begins",
                      .low = -0.01,
                      .high = 0.01,
                      .scope = Scope::kRecord,
                      .starts = {2e-4}},
                     {.symbol = "A_sin",
                      .unit = "m",
                      .meaning = "sine part where the fit begins",
                      .low = -0.01,
                      .high = 0.01,
                      .scope = Scope::kRecord,
                      .starts = {0}},
                     {.symbol = "f",
                      .unit = "Hz",
                      .meaning = "natural frequency",
                      .low = 3,    // below are the link's own motions
                      .high = 95,  // up to the Nyquist frequency of records of 200 Hz
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSpectrum},
                     {.symbol = "zeta",
                      .unit = "-",
                      .meaning = "damping ratio",
                      .low = 1e-4,
                      .high = 0.3,
                      .coordinate = Coordinate::kLog,
                      .starts = {0.003, 0.01, 0.03}}},
      .quadrature = true,
      .signature = {.text = "a line that decays by itself, at one frequency whatever the amplitude of the link"},
      .confused_with = "mains_hum, cross_axis_motion",
      .separated_by = "a tap on the frame, recorded by itself; another mass moves the line",
      .repairs = {"residual_spectrum"},
      .stage = ReadingStage::kSensed,
      .reading = MakeReading<RigMode>()};
  return effect;
}

}  // namespace uiclink
