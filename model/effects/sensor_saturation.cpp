#include <limits>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Reading = clip(reading, +-level). Beyond the level the reading is the level: its derivative by the input is 0.
template <typename T>
struct SensorSaturation {
  static T Read(std::span<const T> p, double /*t*/, double /*fit_start*/, const T& input) {
    if (Value(input) > Value(p[0])) return p[0];
    if (Value(input) < -Value(p[0])) return -p[0];
    return input;
  }
};

}  // namespace

const Effect& SensorSaturationEffect() {
  static const Effect effect{
      .id = "sensor_saturation",
      .title = "readings clipped at a level",
      .equation = "clip(reading, +-level), zero offset included",
      .acts_on = ActsOn::kMeasurement,
      // `starts` are shares of the largest reading: what is clipped is the reading, not the displacement.
      .parameters = {{.symbol = "level",
                      .unit = "m",
                      .meaning = "largest reading that the converter gives",
                      .low = 1e-3,
                      .high = std::numeric_limits<double>::infinity(),
                      .start_scale = StartScale::kSwing,
                      .starts = {0.97, 0.9, 0.8, 0.7}}},
      .neutral = std::numeric_limits<double>::infinity(),
      .signature = {.text = "extrema are flat, on both sides at the same reading; all is well below"},
      .confused_with = "end_stop",
      .separated_by = "a smaller release, or another range of the converter",
      .repairs = {"odd_harmonics", "residual_against_displacement", "loss_per_half_cycle", "even_harmonics",
                  "readings_clipped"},
      .stage = ReadingStage::kClipped,
      .reading = MakeReading<SensorSaturation>()};
  return effect;
}

}  // namespace uiclink
