#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// One further joint: T' = -k y' until |T| = T0 = k y_c.
template <typename T>
struct ExtraSlider {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->sliders.Add({.k = p[0], .y_c = p[1], .joint = true});
  }
};

/// W = 4 T0 (A - y_c) for A > y_c, T0 = k y_c.
double LossPerCycle(std::span<const double> p, double A, double /*w*/) {
  return A > p[1] ? 4 * p[0] * p[1] * (A - p[1]) : 0;
}

}  // namespace

const Effect& ExtraSliderEffect() {
  static const Effect effect{
      .id = "extra_slider",
      .title = "one further joint",
      .equation = "y''/g = ... + T,  T' = -k y' until |T| = T0 = k y_c",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "k",
                      .unit = "1/m",
                      .meaning = "stiffness",
                      .low = 0,
                      .high = 30,  // three times the stiffest joint of the thesis (10.5, set 2)
                      .starts = {0.3}},
                     {.symbol = "y_c",
                      .unit = "m",
                      .meaning = "displacement at which it slides",
                      .low = 1e-5,
                      .high = 0.05,
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSwing,
                      .starts = {0.03, 0.1, 0.25, 0.5}}},
      .signature = {.text = "the backbone has a second step; losses start at a second amplitude", .loss_exponent = 1},
      .confused_with = "micro_slip, rolling_friction",
      .separated_by = "a longer tail, or more releases: frequency and loss over the whole range of amplitudes",
      .repairs = {"loss_per_half_cycle", "rolling_decay", "backbone", "T0_from_lock", "T0_from_decrement"},
      .loss_per_cycle = &LossPerCycle,
      .law = MakeLaw<ExtraSlider>()};
  return effect;
}

}  // namespace uiclink
