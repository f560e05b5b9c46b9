#include "tests/hidden_effects/blind_cases.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Draws that are the same on every compiler: the engine and std::seed_seq are fixed by the standard.
class Draw {
 public:
  Draw(std::uint64_t seed, int number) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                           static_cast<std::uint32_t>(number)};
    engine_.seed(sequence);
  }
  double Uniform(double low, double high) { return low + (high - low) * Unit(); }
  double LogUniform(double low, double high) { return low * std::pow(high / low, Unit()); }
  double Side() { return Unit() < 0.5 ? -1 : 1; }
  bool Coin() { return Unit() < 0.5; }
  std::size_t Below(std::size_t n) {
    return std::min(n - 1, static_cast<std::size_t>(Unit() * static_cast<double>(n)));
  }
  std::uint64_t Seed() { return engine_() >> 1; }  // settings files hold 63 bits

 private:
  double Unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

/// What the nuisance parameters of effects are drawn in proportion to.
struct Surroundings {
  const rig::Link& link;
  double swing;        ///< largest |displacement| of the free decays [m]
  double swing_above;  ///< largest displacement on either side [m], both positive
  double swing_below;
  double SlidingHz() const { return std::sqrt(link.g * link.k) / kTwoPi; }
  double RollingHz() const { return std::sqrt(link.g * (link.k + link.joints[0].k)) / kTwoPi; }
  double Critical() const { return link.joints[0].T0 / link.joints[0].k; }
  double TopSpeed() const { return swing * kTwoPi * SlidingHz(); }
};

/// How an effect is drawn: the size is log-uniform in low..high; Finish() gives it a sign and draws what belongs to it.
struct Recipe {
  double low = 0, high = 0;
  std::function<void(double size, const Surroundings&, Draw&, rig::EffectSizes&)> set;
};

/// A frequency in 0.8..2 Hz that differs by 8 % at least from both of the link's own.
double ForeignHz(const Surroundings& s, Draw& draw) {
  for (;;) {
    const double f = draw.LogUniform(0.8, 2);
    if (std::abs(std::log(f / s.SlidingHz())) > 0.08 && std::abs(std::log(f / s.RollingHz())) > 0.08) return f;
  }
}

double HumHz(Draw& draw) {
  const double lines[] = {50, 60, 100, 150, 180};
  return lines[draw.Below(std::size(lines))] + draw.Uniform(-0.2, 0.2);
}

/// A critical displacement in 0.5..10 mm that differs from the link's by a factor of 1.7 at least.
double OtherCritical(const Surroundings& s, Draw& draw) {
  for (;;) {
    const double y_c = draw.LogUniform(0.5e-3, 10e-3);
    if (std::abs(std::log(y_c / s.Critical())) > std::log(1.7)) return y_c;
  }
}

void SetStop(double k, const Surroundings& s, Draw& draw, rig::EffectSizes& e) {
  const double side = draw.Side();
  e.stop_k = k;
  e.stop_position = side * draw.Uniform(0.70, 0.97) * (side > 0 ? s.swing_above : s.swing_below);
}

void SetCrossAxis(double A, const Surroundings& s, Draw& draw, rig::EffectSizes& e) {
  e.cross_A = A;
  e.cross_f = ForeignHz(s, draw);
  e.cross_decay = draw.LogUniform(0.05, 0.5);
  e.cross_phase = draw.Uniform(0, kTwoPi);
}

using Recipes = std::map<std::string_view, Recipe>;
using S = const Surroundings&;
using E = rig::EffectSizes&;

/// Sizes: chosen from the plain fit's rms over the noise, measured with this program (its last table).
const Recipes& SizeRecipes() {
  static const Recipes recipes{
      {"viscous_damping", {0.0004, 0.012, [](double x, S, Draw&, E e) { e.viscous_c = x; }}},
      {"quadratic_drag", {0.02, 0.4, [](double x, S, Draw&, E e) { e.drag_d = x; }}},
      {"rolling_friction", {1e-5, 2.5e-4, [](double x, S, Draw&, E e) { e.rolling_T_r = x; }}},
      {"micro_slip",
       {0.04, 0.8,
        [](double x, S, Draw& draw, E e) {
          e.micro_k = x;
          e.micro_y_max = draw.LogUniform(1e-3, 6e-3);
        }}},
      {"extra_slider",
       {0.05, 1,
        [](double x, S s, Draw& draw, E e) {
          e.extra_k = x;
          e.extra_T0 = x * OtherCritical(s, draw);
        }}},
      // Share of the pendulum's force at the largest displacement: a softening one must still pull back.
      {"cubic_stiffness",
       {0.03, 0.45,
        [](double x, S s, Draw& draw, E e) { e.cubic_k3 = draw.Side() * x * s.link.k / (s.swing * s.swing); }}},
      {"quadratic_stiffness", {1.5, 30, [](double x, S, Draw& draw, E e) { e.quadratic_k2 = draw.Side() * x; }}},
      {"stribeck_friction",
       {0.03, 0.45,
        [](double x, S s, Draw& draw, E e) {
          e.stribeck_s = x;
          e.stribeck_v_s = draw.LogUniform(0.05, 0.5) * s.TopSpeed();
        }}},
      {"velocity_strengthening", {0.15, 4, [](double x, S, Draw&, E e) { e.strengthening_b = x; }}},
      {"friction_drift", {0.003, 0.04, [](double x, S, Draw& draw, E e) { e.friction_rate = draw.Side() * x; }}},
      // The bend goes with 1/l^2.
      {"pendulum_geometry", {100, 1000, [](double x, S, Draw&, E e) { e.pendulum_l = 1 / std::sqrt(x); }}},
      {"clearance", {1e-4, 2e-3, [](double x, S, Draw&, E e) { e.clearance_gap = x; }}},
      {"end_stop", {5, 150, SetStop}},
      {"cross_axis_motion", {1e-4, 1e-3, SetCrossAxis}},
      {"rig_mode",
       {1e-4, 1.5e-3,
        [](double x, S, Draw& draw, E e) {
          e.mode_A = x;
          e.mode_f = draw.LogUniform(5, 60);
          e.mode_zeta = draw.LogUniform(0.003, 0.03);
        }}},
      {"sensor_drift", {5e-6, 2e-4, [](double x, S, Draw& draw, E e) { e.drift_rate = draw.Side() * x; }}},
      // The share of the swing that is cut off.
      {"sensor_saturation", {0.03, 0.30, [](double x, S s, Draw&, E e) { e.saturation_level = s.swing * (1 - x); }}},
      {"sensor_nonlinearity", {0.15, 3, [](double x, S, Draw& draw, E e) { e.nonlinearity_e = draw.Side() * x; }}},
      {"mains_hum",
       {2e-5, 4e-4,
        [](double x, S, Draw& draw, E e) {
          e.hum_A = x;
          e.hum_f = HumHz(draw);
          e.hum_phase = draw.Uniform(0, kTwoPi);
        }}},
      {"asymmetric_friction", {0.02, 0.2, [](double x, S, Draw& draw, E e) { e.asymmetry_a = draw.Side() * x; }}},
      {"force_bump",
       {0.0015, 0.015,
        [](double x, S s, Draw& draw, E e) {
          e.bump_height = draw.Side() * x;
          e.bump_centre = draw.Uniform(0.3, 0.7) * s.swing;
          e.bump_width = draw.Uniform(0.08, 0.2) * e.bump_centre;
        }}},
      {"stiffness_modulation",
       {0.015, 0.15,
        [](double x, S, Draw& draw, E e) {
          e.modulation_a = x;
          e.modulation_f = draw.LogUniform(0.1, 0.8);
          e.modulation_phase = draw.Uniform(0, kTwoPi);
        }}},
      {"maxwell_branch",
       {0.02, 0.3,
        [](double x, S, Draw& draw, E e) {
          e.maxwell_k = x;
          e.maxwell_tau = draw.LogUniform(0.1, 2);
        }}},
  };
  return recipes;
}

/// Effects without a recipe: half a decade to either side of the rig's example, the rest as in the example.
Recipe RecipeOf(const rig::Effect& effect) {
  const auto known = SizeRecipes().find(effect.id);
  if (known != SizeRecipes().end()) return known->second;
  const double example = effect.parameters.front().example;
  return {example / std::sqrt(10), example * std::sqrt(10), [&effect](double x, S, Draw&, E e) {
            for (const rig::EffectParameter& p : effect.parameters) e.*p.value = p.example;
            e.*effect.parameters.front().value = x;
          }};
}

/// Link: one slider, log-uniform where ratios matter.
rig::Link DrawLink(Draw& draw) {
  for (;;) {
    rig::Link link;
    link.k = draw.LogUniform(2.5, 6);
    const double k1 = link.k * draw.LogUniform(0.3, 4);
    const double T0 = draw.LogUniform(0.005, 0.025);
    link.joints = {{.k = k1, .T0 = T0}};
    if (T0 / k1 >= 1e-3 && T0 / k1 <= 8e-3) return link;
  }
}

/// First extrema of the records, with their sides [m].
std::vector<double> DrawExtrema(const rig::Link& link, Draw& draw) {
  const double y_c = link.joints[0].T0 / link.joints[0].k;
  std::vector<double> extrema;
  for (int i = 0; i < kBlindRecords; ++i)
    extrema.push_back(draw.Side() * draw.Uniform(std::max(14e-3, 2.5 * y_c), 30e-3));
  return extrema;
}

/// Size of the extremum that follows one of size A after sliding outward (reference: half-cycle map of one slider).
double NextExtremum(const rig::Link& link, double A) {
  const double k = link.k, T0 = link.joints[0].T0;
  return (std::sqrt((k * A - T0) * (k * A - T0) + 4 * k * T0 * T0 / link.joints[0].k) - T0) / k;
}

Surroundings Look(const rig::Link& link, const std::vector<double>& extrema) {
  Surroundings s{.link = link, .swing = 0, .swing_above = 0, .swing_below = 0};
  for (const double y : extrema) {
    const double first = std::abs(y), second = NextExtremum(link, first);
    s.swing = std::max(s.swing, first);
    s.swing_above = std::max(s.swing_above, y > 0 ? first : second);
    s.swing_below = std::max(s.swing_below, y < 0 ? first : second);
  }
  return s;
}

const rig::Scatter kScatter{.k = 0.02, .joint_k = 0.03, .joint_T0 = 0.03};

/// A case in the making.
struct Making {
  BlindCase& blind;
  rig::Settings base;
  Surroundings around;
  Draw& draw;

  /// Hides an effect; `from` is the share of its logarithmic range below which no size is drawn.
  void Hide(const rig::Effect& effect, double from) {
    const Recipe recipe = RecipeOf(effect);
    rig::EffectSizes& sizes = base.link.effects;
    recipe.set(draw.LogUniform(recipe.low * std::pow(recipe.high / recipe.low, from), recipe.high), around, draw,
               sizes);
    std::string text;
    for (const rig::EffectParameter& p : effect.parameters)
      text += fmt::format("{}{} {:.3g}", text.empty() ? "" : ", ", p.symbol, sizes.*p.value);
    blind.sizes.push_back(text);
    if (effect.id != kUnobservable) blind.effects.push_back(effect.id);
  }
};

void MakeClean(int i, Making* making) {
  const char* variants[] = {"one link", "scattered", "asymmetric friction"};
  making->blind.variant = variants[i % 3];
  making->blind.scattered = i % 3 == 1 || (i % 3 == 2 && making->blind.scattered);
  if (i % 3 != 2) return;
  for (const rig::Effect& effect : rig::EffectCatalogue())
    if (effect.id == kUnobservable) making->Hide(effect, 0);
}

void MakeDecoy(int i, Making* making) {
  rig::Settings& base = making->base;
  Draw& draw = making->draw;
  const char* variants[] = {"joint's start force", "large zero", "loud noise",
                            "coarse converter",    "other rate", "wide scatter"};
  making->blind.variant = variants[i % 6];
  switch (i % 6) {
    case 0:
      base.link.joints[0].T_start = draw.Uniform(-0.9, 0.9) * base.link.joints[0].T0;
      break;
    case 1:
      base.sensor.zero_offset = draw.Side() * draw.Uniform(3e-3, 8e-3);
      base.sensor.range = 0.040;  // so that nothing is cut off
      break;
    case 2:
      base.sensor.noise *= draw.Uniform(3, 8);
      break;
    case 3:
      base.sensor.bits = 10;  // steps of 0.0625 mm, five times the noise
      break;
    case 4:
      base.sensor.keep_every = draw.Coin() ? 2 : 10;
      break;
    default:
      making->blind.scattered = true;
      base.scatter = {.k = 0.05, .joint_k = 0.08, .joint_T0 = 0.08};
  }
}

void MakePair(Making* making) {
  const std::vector<const rig::Effect*> effects = ObservableEffects();
  const std::size_t first = making->draw.Below(effects.size());
  const std::size_t second = (first + 1 + making->draw.Below(effects.size() - 1)) % effects.size();
  making->Hide(*effects[first], 0.5);
  making->Hide(*effects[second], 0.5);
}

void HideWhatBelongs(int i, Making* making) {
  switch (making->blind.kind) {
    case CaseKind::kSingle: {
      const std::vector<const rig::Effect*> effects = ObservableEffects();
      making->Hide(*effects[static_cast<std::size_t>(i) % effects.size()], 0);
      break;
    }
    case CaseKind::kClean:
      MakeClean(i, making);
      break;
    case CaseKind::kDecoy:
      MakeDecoy(i, making);
      break;
    case CaseKind::kPair:
      MakePair(making);
      break;
    case CaseKind::kOutside:
      making->Hide(rig::OutsideCatalogue()[static_cast<std::size_t>(i) % rig::OutsideCatalogue().size()], 0);
      break;
  }
}

}  // namespace

std::string_view Name(CaseKind kind) {
  switch (kind) {
    case CaseKind::kSingle:
      return "single";
    case CaseKind::kClean:
      return "clean";
    case CaseKind::kDecoy:
      return "decoy";
    case CaseKind::kPair:
      return "pair";
    case CaseKind::kOutside:
      return "outside";
  }
  return "?";
}

std::vector<const rig::Effect*> ObservableEffects() {
  std::vector<const rig::Effect*> effects;
  for (const rig::Effect& effect : rig::EffectCatalogue())
    if (effect.id != kUnobservable) effects.push_back(&effect);
  return effects;
}

BlindCase DrawBlindCase(std::uint64_t study_seed, int number) {
  const auto kind = static_cast<std::size_t>(number / kCasesPerKind);
  if (number < 0 || kind >= std::size(kCaseKinds))
    throw std::invalid_argument(fmt::format("DrawBlindCase: number = {} belongs to no kind of case", number));
  Draw draw(study_seed, number);
  BlindCase blind;
  blind.number = number;
  blind.kind = kCaseKinds[kind];
  rig::Settings base;
  base.name = "blind";
  base.direction = "lateral";
  base.seed = draw.Seed();
  base.link = DrawLink(draw);
  base.sensor.zero_scatter = 0.3e-3;
  const std::vector<double> extrema = DrawExtrema(base.link, draw);
  blind.scattered = draw.Coin();
  const rig::Link link = base.link;
  Making making{.blind = blind, .base = base, .around = Look(link, extrema), .draw = draw};
  blind.swing = making.around.swing;
  HideWhatBelongs(number % kCasesPerKind, &making);
  if (blind.scattered && making.base.scatter.k == 0) making.base.scatter = kScatter;
  // While it is pushed against a stop, the mass swings farther to the other side than any first extremum.
  if (making.base.link.effects.stop_k > 0) making.base.sensor.range = 48e-3;
  for (const double y : extrema) {
    blind.settings.push_back(making.base);
    rig::Push& push = blind.settings.back().push;
    push.first = y > 0 ? rig::Push::First::kPositive : rig::Push::First::kNegative;
    push.first_extremum = std::abs(y);
  }
  return blind;
}

WrittenCase WriteBlindCase(const BlindCase& blind, const std::filesystem::path& folder) {
  WrittenCase written;
  const rig::Link& mean = blind.settings.front().link;
  written.population = {.k = mean.k, .k1 = mean.joints[0].k, .T01 = mean.joints[0].T0};
  const rig::Sensor& sensor = blind.settings.front().sensor;
  const double quantum = 2 * sensor.range / std::ldexp(1.0, sensor.bits);
  written.noise_mm = 1e3 * std::hypot(sensor.noise, quantum / std::sqrt(12));
  const double share = 1.0 / static_cast<double>(blind.settings.size());
  for (std::size_t i = 0; i < blind.settings.size(); ++i) {
    const int index = static_cast<int>(i) + 1;
    const rig::RigRecord record = rig::MakeRecord(blind.settings[i], index);
    written.records_mean.k += share * record.truth.link.k;
    written.records_mean.k1 += share * record.truth.link.joints[0].k;
    written.records_mean.T01 += share * record.truth.link.joints[0].T0;
    written.files.push_back(fmt::format("record_{}.txt", index));
    std::ofstream stream(folder / written.files.back(), std::ios::binary);
    stream << rig::FormatRecord(record, blind.settings[i], index);
    stream.close();
    if (!stream) throw std::runtime_error((folder / written.files.back()).string() + ": cannot be written");
  }
  return written;
}

}  // namespace uiclink
