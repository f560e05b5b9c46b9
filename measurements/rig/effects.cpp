#include <fmt/core.h>

#include "measurements/rig/rig.h"

namespace uiclink::rig {

const std::vector<Effect>& EffectCatalogue() {
  using E = EffectSizes;
  static const std::vector<Effect> catalogue{
      {"viscous_damping", "y''/g = ... - c y'", {{"c", "s/m", "damping", &E::viscous_c, 0, 1, 0.015}}},
      {"quadratic_drag", "y''/g = ... - d y' abs(y')", {{"d", "s^2/m^2", "drag", &E::drag_d, 0, 10, 0.3}}},
      {"rolling_friction",
       "y''/g = ... - T_r sign(y'), times sliding_share while every joint slides; stops the mass where it can hold it",
       {{"T_r", "-", "friction of the rolling joints", &E::rolling_T_r, 0, 0.1, 5e-4},
        {"sliding_share", "-", "share that also acts in full sliding", &E::rolling_sliding_share, 0, 1, 1}}},
      {"micro_slip",
       "count parallel sliders of stiffness k/count that slip at displacements (j - 1/2) y_max/count, j = 1..count",
       {{"k", "1/m", "stiffness of all together", &E::micro_k, 0, 100, 0.4},
        {"y_max", "m", "largest slip displacement", &E::micro_y_max, 1e-6, 1, 0.004},
        {"count", "-", "number of sliders", &E::micro_count, 1, 1000, 32}}},
      {"extra_slider",
       "one further joint: T' = -k y' until abs(T) = T0",
       {{"k", "1/m", "stiffness", &E::extra_k, 0, 100, 0.6}, {"T0", "-", "slip force", &E::extra_T0, 0, 1, 0.002}}},
      {"cubic_stiffness", "y''/g = ... - k3 y^3", {{"k3", "1/m^3", "hardening > 0", &E::cubic_k3, -1e5, 1e5, 400}}},
      {"quadratic_stiffness", "y''/g = ... - k2 y^2", {{"k2", "1/m^2", "curvature", &E::quadratic_k2, -1e3, 1e3, 8}}},
      {"stribeck_friction",
       "a stuck joint breaks out at T0 (1 + s), a sliding one has T0 (1 + s exp(-(y'/v_s)^2))",
       {{"s", "-", "static excess", &E::stribeck_s, 0, 5, 0.15},
        {"v_s", "m/s", "Stribeck speed", &E::stribeck_v_s, 1e-6, 10, 0.03}}},
      {"velocity_strengthening",
       "a joint breaks out and slides at T0 (1 + b abs(y')), y' the speed of the mass",
       {{"b", "s/m", "growth with the speed of the mass", &E::strengthening_b, 0, 100, 1}}},
      {"friction_drift",
       "T0(t) = T0 (1 + rate t), t from the start of the record, never below 0",
       {{"rate", "1/s", "relative change", &E::friction_rate, -1, 1, 0.02}}},
      {"asymmetric_friction",
       "T0 (1 + a) sliding towards y > 0, T0 (1 - a) towards y < 0",
       {{"a", "-", "asymmetry", &E::asymmetry_a, -1, 1, 0.1}}},
      {"pendulum_geometry",
       "-k l sin(y/l) instead of -k y",
       {{"l", "m", "swinging length", &E::pendulum_l, 1e-3, kNever, 0.05}}},
      {"clearance",
       "a joint's spring is slack over a free travel of +-gap about the slider: T = -k (z - clip(z, +-gap))",
       {{"gap", "m", "half the play", &E::clearance_gap, 0, 0.1, 3e-4}}},
      {"end_stop",
       "y''/g = ... - k (y - position) beyond the stop (above position > 0, below position < 0)",
       {{"k", "1/m", "stiffness", &E::stop_k, 0, 1e5, 200},
        {"position", "m", "displacement at the touch", &E::stop_position, -1, 1, 0.02}}},
      {"cross_axis_motion",
       "displacement at the sensor: y + A exp(-decay t) cos(2 pi f t + phase), from the start of the record",
       {{"A", "m", "amplitude", &E::cross_A, 0, 0.1, 5e-4},
        {"f", "Hz", "frequency", &E::cross_f, 0, 500, 1.3},
        {"decay", "1/s", "decay rate", &E::cross_decay, 0, 100, 0.15},
        {"phase", "rad", "phase", &E::cross_phase, -7, 7, 0.7}}},
      {"rig_mode",
       "displacement at the sensor: y + q; q'' + 2 zeta w q' + w^2 q = 0, w = 2 pi f, from q = 0, q' = A w at release",
       {{"A", "m", "amplitude", &E::mode_A, 0, 0.1, 3e-4},
        {"f", "Hz", "natural frequency", &E::mode_f, 0.01, 500, 23},
        {"zeta", "-", "damping ratio, < 1", &E::mode_zeta, 0, 0.99, 0.01}}},
      {"sensor_drift", "reading + rate t", {{"rate", "m/s", "drift", &E::drift_rate, -1e-2, 1e-2, 2e-5}}},
      {"sensor_saturation",
       "reading = clip(reading, +-level), before the converter",
       {{"level", "m", "level", &E::saturation_level, 0, kNever, 0.018}}},
      {"sensor_nonlinearity",
       "reading = y (1 + e y), y the displacement at the sensor",
       {{"e", "1/m", "curvature", &E::nonlinearity_e, -20, 20, 1}}},
      {"mains_hum",
       "reading + A sin(2 pi f t + phase)",
       {{"A", "m", "amplitude", &E::hum_A, 0, 0.1, 5e-5},
        {"f", "Hz", "frequency; above 100 Hz it is aliased", &E::hum_f, 0, 500, 50},
        {"phase", "rad", "phase", &E::hum_phase, -7, 7, 0.3}}},
  };
  return catalogue;
}

const std::vector<Effect>& OutsideCatalogue() {
  using E = EffectSizes;
  static const std::vector<Effect> outside{
      {"force_bump",
       "y''/g = ... - height (b((y - centre)/width) + b((y + centre)/width)), b(u) = u exp((1 - u^2)/2): a dip in the "
       "potential on either side",
       {{"height", "-", "largest force", &E::bump_height, -1, 1, 0.003},
        {"centre", "m", "displacement of the dips", &E::bump_centre, 0, 1, 0.012},
        {"width", "m", "from the centre to the largest force", &E::bump_width, 1e-5, 1, 0.002}}},
      {"stiffness_modulation",
       "k (1 + a sin(2 pi f t + phase)) instead of k, t from the start of the record",
       {{"a", "-", "relative depth", &E::modulation_a, 0, 0.9, 0.03},
        {"f", "Hz", "frequency", &E::modulation_f, 0, 100, 0.4},
        {"phase", "rad", "phase", &E::modulation_phase, -7, 7, 0.5}}},
      {"maxwell_branch",
       "a spring in series with a dashpot beside the link: T' = -k y' - T/tau",
       {{"k", "1/m", "stiffness of the spring", &E::maxwell_k, 0, 100, 0.3},
        {"tau", "s", "relaxation time", &E::maxwell_tau, 1e-3, 1e3, 0.3}}},
  };
  return outside;
}

std::vector<Effect> AllEffects() {
  std::vector<Effect> all = EffectCatalogue();
  all.insert(all.end(), OutsideCatalogue().begin(), OutsideCatalogue().end());
  return all;
}

std::string FormatEffectTable(const std::vector<Effect>& effects) {
  std::string table =
      "| identifier | equation | parameters (the first is the size), unit, neutral or default value |\n";
  table += "| --- | --- | --- |\n";
  const EffectSizes defaults;
  for (const Effect& effect : effects) {
    std::string parameters;
    for (const EffectParameter& p : effect.parameters) {
      parameters += fmt::format("{}`{}` [{}] {}, {}", parameters.empty() ? "" : "; ", p.symbol, p.unit, p.meaning,
                                defaults.*p.value);
    }
    table += fmt::format("| `{}` | {} | {} |\n", effect.id, effect.equation, parameters);
  }
  return table;
}

}  // namespace uiclink::rig
