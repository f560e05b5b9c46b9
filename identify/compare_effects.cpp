#include "identify/compare_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "data/input_error.h"
#include "model/closed_form.h"
#include "model/extended_solver.h"

namespace uiclink {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kDecays = 48;           // simulated decays of a table,
constexpr double kDecayRatio = 0.93;  // each from this share of the one before: down to 3 % of the largest
constexpr double kDecayPeriods = 4;   // of the sliding motion
constexpr int kStepsPerPeriod = 64;   // in which turning points are looked for
constexpr int kMostDerivatives = 16;  // that a fit carries: parameters of link and mechanics, and the start

[[noreturn]] void Fail(const std::string& file, Direction direction, const std::string& message) {
  throw InputError(file, 0, fmt::format("[{}] effects: {}", Name(direction), message));
}

const Effect* Find(const EffectValues& values, Direction direction, const std::string& file) {
  const Effect* effect = FindEffect(values.id);
  if (effect == nullptr)
    Fail(file, direction,
         fmt::format("expected an effect of the catalogue (see identify effects), found \"{}\"", values.id));
  return effect;
}

std::string ListSymbols(const Effect& effect) {
  std::string list;
  for (const EffectParameter& p : effect.parameters)
    if (p.scope == Scope::kLink) list += (list.empty() ? "" : ", ") + std::string(p.symbol);
  return list.empty() ? "none" : list;
}

void CheckSymbols(const EffectValues& values, const Effect& effect, Direction direction, const std::string& file) {
  for (const auto& [symbol, value] : values.parameters) {
    const auto found = std::find_if(effect.parameters.begin(), effect.parameters.end(),
                                    [&, name = std::string_view(symbol)](const auto& p) { return p.symbol == name; });
    if (found == effect.parameters.end())
      Fail(file, direction,
           fmt::format("{}: expected parameters among {}, found \"{}\"", effect.id, ListSymbols(effect), symbol));
    if (found->scope == Scope::kRecord)
      Fail(file, direction,
           fmt::format("{}: expected parameters among {}, found {}, which belongs to a record and not to a link",
                       effect.id, ListSymbols(effect), symbol));
  }
}

double ValueOf(const EffectValues& values, const EffectParameter& parameter, Direction direction,
               const std::string& file) {
  for (const auto& [symbol, value] : values.parameters) {
    if (symbol != parameter.symbol) continue;
    if (!(value >= parameter.low && value <= parameter.high))
      Fail(file, direction,
           fmt::format("{}: expected {} from {:g} to {:g} {}, found {:g}", values.id, parameter.symbol, parameter.low,
                       parameter.high, parameter.unit, value));
    return value;
  }
  Fail(file, direction,
       fmt::format("{}: expected a value of {} [{}], found none", values.id, parameter.symbol, parameter.unit));
}

ExtendedOscillator<double> MakeOscillator(const SetModel& model) {
  return MakeExtendedOscillator(model.link, model.extension, model.shared);
}

/// Turning points of a decay from rest at y0 [m], the first one included, as long as the mass swings.
std::vector<Extremum> FindTurningPoints(const SetModel& model, double y0, double periods) {
  const double period = 2 * std::numbers::pi / CalcSlidingFrequency(model.link), duration = periods * period;
  ExtendedTrajectory<double> run;
  if (Solve(MakeOscillator(model), y0, 0.0, duration, &run) != SolveStatus::kOk) return {};
  std::vector<Extremum> extrema = {{.t = 0, .y = y0}};
  const double step = period / kStepsPerPeriod;
  for (double t = step; t + step < duration; t += step) {
    if (!(run.v(t) * run.v(t + step) < 0)) continue;  // a mass that stops for good turns no more
    double low = t, high = t + step;
    for (int i = 0; i < 40; ++i) {  // to 1e-12 of a step
      const double middle = 0.5 * (low + high);
      (run.v(low) * run.v(middle) <= 0 ? high : low) = middle;
    }
    extrema.push_back({.t = high, .y = run.y(high)});
  }
  return extrema;
}

}  // namespace

SetModel MakeSetModel(const DirectionParameters& parameters, double g, Direction direction, const std::string& file) {
  SetModel model;
  model.link = uiclink::MakeOscillator(parameters, g);
  std::vector<const Effect*> effects;
  for (const EffectValues& values : parameters.effects) {
    effects.push_back(Find(values, direction, file));
    CheckSymbols(values, *effects.back(), direction, file);
  }
  model.extension = Extension(effects);
  const int room = kMostDerivatives - 2 * model.link.size() - 2;
  if (model.extension.CountMechanical() > room)
    Fail(file, direction,
         fmt::format("expected at most {} parameters of effects on the mechanics beside {} sliders, found {}", room,
                     model.link.size(), model.extension.CountMechanical()));
  for (const Extension::Unknown& unknown : model.extension.shared()) {
    const auto values = std::find_if(parameters.effects.begin(), parameters.effects.end(),
                                     [&](const EffectValues& v) { return v.id == unknown.effect->id; });
    model.shared.push_back(ToCoordinate(unknown.Parameter(), ValueOf(*values, unknown.Parameter(), direction, file)));
  }
  model.simulated = true;
  return model;
}

std::vector<Cycle> FindCycles(const std::vector<Extremum>& e) {
  std::vector<Cycle> cycles;
  for (std::size_t i = 0; i + 2 < e.size(); ++i) {
    const double first = std::abs(e[i].y - e[i + 1].y), second = std::abs(e[i + 1].y - e[i + 2].y);
    cycles.push_back(
        {.amplitude = (first + second) / 4, .frequency = 1 / (e[i + 2].t - e[i].t), .loss = (first - second) / 2});
  }
  return cycles;
}

CycleTable::CycleTable(const SetModel& model, double largest) {
  double start = 1.1 * largest;  // a first cycle has a mean amplitude below its start
  while (start < 10 * largest) {
    const std::vector<Cycle> first = FindCycles(FindTurningPoints(model, start, 3));
    if (first.empty() || first[0].amplitude > largest) break;
    start *= 1.1;
  }
  for (int i = 0; i < kDecays; ++i, start *= kDecayRatio)
    for (const Cycle& cycle : FindCycles(FindTurningPoints(model, start, kDecayPeriods))) cycles_.push_back(cycle);
  std::sort(cycles_.begin(), cycles_.end(), [](const Cycle& a, const Cycle& b) { return a.amplitude < b.amplitude; });
}

Cycle CycleTable::About(double amplitude) const {
  const auto above = std::lower_bound(cycles_.begin(), cycles_.end(), amplitude,
                                      [](const Cycle& cycle, double a) { return cycle.amplitude < a; });
  if (above == cycles_.begin() || above == cycles_.end())
    return {.amplitude = amplitude, .frequency = kNan, .loss = kNan};
  const Cycle &high = *above, &low = *(above - 1);
  const double width = high.amplitude - low.amplitude;
  const double share = width > 0 ? (amplitude - low.amplitude) / width : 0;
  return {.amplitude = amplitude,
          .frequency = low.frequency + share * (high.frequency - low.frequency),
          .loss = low.loss + share * (high.loss - low.loss)};
}

double CalcExtendedFrequency(const SetModel& model, double A) {
  const std::vector<Extremum> extrema = FindTurningPoints(model, A, 2);
  return extrema.size() > 1 && extrema[1].y < 0 ? 0.5 / extrema[1].t : kNan;
}

double CalcExtendedLoss(const SetModel& model, double A) {
  double loss = CalcLossPerCycle(model.link, A);
  const double w = 2 * std::numbers::pi * CalcExtendedFrequency(model, A);
  for (const Effect* effect : model.extension.effects()) {
    if (!effect->IsMechanical() || effect->acts_on == ActsOn::kStiffness) continue;
    if (effect->loss_per_cycle == nullptr) return kNan;  // those that have one stand beside the sliders
    loss += effect->loss_per_cycle(model.extension.CalcLawValues(effect, model.shared, {}), A, w);
  }
  return loss;
}

}  // namespace uiclink
