#include <cmath>
#include <numbers>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Reading + A_cos cos 2 pi f s + A_sin sin 2 pi f s,  s = t - fit_start.
template <typename T>
struct MainsHum {
  static T Read(std::span<const T> p, double t, double fit_start, const T& input) {
    using std::cos;
    using std::sin;
    const T phase = p[2] * (2 * std::numbers::pi * (t - fit_start));
    return input + p[0] * cos(phase) + p[1] * sin(phase);
  }
};

}  // namespace

const Effect& MainsHumEffect() {
  static const Effect effect{
      .id = "mains_hum",
      .title = "a steady tone in the reading: mains, or its alias",
      .equation = "reading + A cos(2 pi f t + phase)",
      .acts_on = ActsOn::kMeasurement,
      .parameters = {{.symbol = "A_cos",
                      .unit = "m",
                      .meaning = "cosine part where the fit begins",
                      .low = -0.005,
                      .high = 0.005,
                      .scope = Scope::kRecord,
                      .starts = {5e-5}},
                     {.symbol = "A_sin",
                      .unit = "m",
                      .meaning = "sine part where the fit begins",
                      .low = -0.005,
                      .high = 0.005,
                      .scope = Scope::kRecord,
                      .starts = {0}},
                     {.symbol = "f",
                      .unit = "Hz",
                      .meaning = "frequency as it stands in the record",
                      .low = 3,     // below are the link's own motions
                      .high = 500,  // a record sees no more than its own Nyquist frequency
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSpectrum}},
      .quadrature = true,
      .signature = {.text = "a line that does not decay; at 16 2/3 or 50 Hz, or where decimation puts them"},
      .confused_with = "rig_mode",
      .separated_by = "the sensor's reading with the link at rest; records at another sampling rate move an alias",
      .repairs = {"residual_spectrum"},
      .stage = ReadingStage::kAdded,
      .reading = MakeReading<MainsHum>()};
  return effect;
}

}  // namespace uiclink
