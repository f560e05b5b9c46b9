#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Reading + rate (t - fit_start). The zero offset of the record is that of fit_start.
template <typename T>
struct SensorDrift {
  static T Read(std::span<const T> p, double t, double fit_start, const T& input) {
    return input + p[0] * (t - fit_start);
  }
};

}  // namespace

const Effect& SensorDriftEffect() {
  static const Effect effect{
      .id = "sensor_drift",
      .title = "the sensor's zero moves",
      .equation = "reading + rate t",
      .acts_on = ActsOn::kMeasurement,
      .parameters = {{.symbol = "rate",
                      .unit = "m/s",
                      .meaning = "drift of the zero",
                      .low = -1e-3,  // 15 mm in a record
                      .high = 1e-3,
                      .scope = Scope::kRecord,
                      .starts = {2e-5}}},
      .signature = {.text = "the mid-line moves linearly in time, also where the link only rolls"},
      .confused_with = "a slow creep of the rest position",
      .separated_by = "some minutes of the sensor's reading with the link at rest",
      .repairs = {"mid_line", "residual_against_time", "rest_off_centre"},
      .stage = ReadingStage::kAdded,
      .reading = MakeReading<SensorDrift>()};
  return effect;
}

}  // namespace uiclink
