#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Reading = y (1 + e y), y the displacement at the sensor.
template <typename T>
struct SensorNonlinearity {
  static T Read(std::span<const T> p, double /*t*/, double /*fit_start*/, const T& input) {
    return input * (1.0 + p[0] * input);
  }
};

}  // namespace

const Effect& SensorNonlinearityEffect() {
  static const Effect effect{
      .id = "sensor_nonlinearity",
      .title = "the sensor's curve is not straight",
      .equation = "reading = y (1 + e y)",
      .acts_on = ActsOn::kMeasurement,
      .parameters = {{.symbol = "e",
                      .unit = "1/m",
                      .meaning = "curvature",
                      .low = -10,  // 25 % of the reading at 25 mm
                      .high = 10,
                      .starts = {1}}},
      .signature = {.text = "a second harmonic and a mid-line that moves with the square of the amplitude; the "
                            "frequency does not move",
                    .even_harmonics = true},
      .confused_with = "quadratic_stiffness",
      .separated_by = "gauge blocks, or the sensor moved by some millimetres: its curve moves with it",
      .repairs = {"even_harmonics", "mid_line", "residual_against_displacement"},
      .stage = ReadingStage::kCurve,
      .reading = MakeReading<SensorNonlinearity>()};
  return effect;
}

}  // namespace uiclink
