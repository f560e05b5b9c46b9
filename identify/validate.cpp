#include "identify/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "data/checksum.h"
#include "data/data_path.h"
#include "data/file.h"
#include "data/parameter_set_file.h"
#include "identify/parallel.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"
#include "vehicle/stability.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr std::array kDirections{Direction::kLateral, Direction::kLongitudinal};
constexpr double kHighestSpeed = 80;      // [m/s]: well above what any two-axle freight wagon runs
constexpr double kSpeedTolerance = 1e-9;  // of a critical speed [m/s]
constexpr double kReach = 0.05;           // of the critical speed, on both sides, where a changed set is searched
constexpr double kRelativeStep = 1e-3;    // of a parameter: truncation 1e-6 and tolerance 1e-7 of the derivative

DirectionParameters& Of(ParameterSet* set, Direction direction) {
  return direction == Direction::kLateral ? *set->lateral : *set->longitudinal;
}

// ---------------------------------------------------------------- sets

ValidationSet ReadShipped(const std::string& name) {
  const std::filesystem::path path = FindDataFile("parameter_sets", name);
  const std::string text = ReadFileWhole(path);
  return {
      .role = name, .file = path.string(), .sha256 = CalcSha256(text), .set = ParseParameterSet(text, path.string())};
}

/// `set` with what it lacks from `stand_in`, and what has to be said about it.
ParameterSet Complete(const ParameterSet& set, const ValidationSet& stand_in, std::vector<std::string>* notices) {
  ParameterSet whole = set;
  for (const Direction direction : kDirections) {
    std::optional<DirectionParameters>& own = direction == Direction::kLateral ? whole.lateral : whole.longitudinal;
    if (!own) {
      if (!stand_in.set[direction])
        throw std::runtime_error(
            fmt::format("{}: expected a {} direction, found none", stand_in.file, Name(direction)));
      own = *stand_in.set[direction];
      own->covariance.reset();  // nothing was measured in this run
      notices->push_back(
          fmt::format("the {} direction was not measured: it comes from {}", Name(direction), stand_in.set.name));
    }
    for (const std::string& effect : EffectsLeftOut(*own))
      notices->push_back(fmt::format("{} ({}) has no place on a wagon and is left out", effect, Name(direction)));
  }
  return whole;
}

/// The wagon with one set on all corners. Forces per load do not depend on the g that k and T0 were divided by.
Wagon MakeWagonOn(const WagonInputs& inputs, const ParameterSet& set) {
  std::array<CornerLinks, kCorners> links;
  links.fill({.longitudinal = *set.longitudinal, .lateral = *set.lateral, .g = set.g});
  return {inputs.data, inputs.body, inputs.loaded, links, inputs.table, inputs.choice.options};
}

// ---------------------------------------------------------------- the linear critical speed and its bounds

CriticalSpeed FindCriticalSpeed(const Wagon& wagon) {
  StabilityOptions options;
  options.to = kHighestSpeed;
  options.tolerance = kSpeedTolerance;
  options.first_only = true;
  const StabilityResult result = FindCrossings(wagon, options);
  CriticalSpeed speed;
  speed.value = result.linear_critical_speed;
  speed.searched_to = result.searched_to;
  speed.unstable_from_start = result.unstable_at_start > 0;
  if (speed.value) speed.frequency_hz = result.crossings.front().frequency_hz;
  return speed;
}

/// Critical speed of a set that is a little changed.
std::optional<double> FindCriticalSpeedNear(const Wagon& wagon, double V) {
  StabilityOptions options;
  options.from = (1 - kReach) * V;
  options.to = (1 + kReach) * V;
  options.step = options.to - options.from;
  options.tolerance = kSpeedTolerance;
  options.first_only = true;
  return FindCrossings(wagon, options).linear_critical_speed;
}

/// The parameter that a covariance calls `symbol`; null if there is none.
double* FindParameter(DirectionParameters* parameters, const std::string& symbol) {
  const std::vector<std::string> symbols = ParameterSymbols(static_cast<int>(parameters->sliders.size()));
  const auto place = std::ranges::find(symbols, symbol);
  if (place != symbols.end()) {
    const auto i = static_cast<std::size_t>(place - symbols.begin());
    const std::size_t n = parameters->sliders.size();
    if (i == 0) return &parameters->k;
    return i <= n ? &parameters->sliders[i - 1].k : &parameters->sliders[i - n - 1].T0;
  }
  for (EffectValues& effect : parameters->effects)
    for (auto& [name, value] : effect.parameters)
      if (effect.id + "." + name == symbol) return &value;
  return nullptr;
}

/// Critical speed at a parameter's value; none where it is not near V, or the value is outside of its bounds.
std::optional<double> FindSpeedAt(const WagonInputs& inputs, ParameterSet set, Direction direction,
                                  const std::string& symbol, double value, double V) {
  *FindParameter(&Of(&set, direction), symbol) = value;
  try {
    return FindCriticalSpeedNear(MakeWagonOn(inputs, set), V);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// Central difference; one-sided where a bound of the parameter is in the way.
/// @throws std::runtime_error where the critical speed cannot be followed at all.
double CalcDerivative(const WagonInputs& inputs, const ParameterSet& set, Direction direction,
                      const std::string& symbol, double std, double V) {
  ParameterSet copy = set;
  const double* parameter = FindParameter(&Of(&copy, direction), symbol);
  const auto fail = [&](const char* why) {
    return std::runtime_error(fmt::format("no bounds: {} {} {}", Name(direction), symbol, why));
  };
  if (parameter == nullptr) throw fail("is in the covariance, but not in the set");
  const double value = *parameter;
  const double step = kRelativeStep * (value != 0 ? std::abs(value) : std);
  if (!(step > 0)) return 0;  // neither a value nor an uncertainty
  const std::optional<double> above = FindSpeedAt(inputs, set, direction, symbol, value + step, V);
  const std::optional<double> below = FindSpeedAt(inputs, set, direction, symbol, value - step, V);
  if (above && below) return (*above - *below) / (2 * step);
  if (above) return (*above - V) / step;
  if (below) return (V - *below) / step;
  throw fail("cannot be changed without losing the critical speed");
}

/// Variance of the critical speed that one direction's covariance makes [m^2/s^2]; appends the derivatives behind it.
double CalcVariance(const WagonInputs& inputs, const ParameterSet& set, Direction direction, double V,
                    std::vector<SpeedSensitivity>* sensitivities) {
  const Covariance& covariance = *set[direction]->covariance;
  std::vector<double> gradient;
  for (std::size_t i = 0; i < covariance.order.size(); ++i) {
    const std::string& symbol = covariance.order[i];
    gradient.push_back(CalcDerivative(inputs, set, direction, symbol, std::sqrt(covariance.matrix[i][i]), V));
    sensitivities->push_back({direction, symbol, gradient.back()});
  }
  double variance = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i)
    for (std::size_t j = 0; j < gradient.size(); ++j) variance += gradient[i] * covariance.matrix[i][j] * gradient[j];
  return std::max(variance, 0.0);
}

void AddBounds(const WagonInputs& inputs, const ParameterSet& set, const std::array<double, 2>& coverage,
               CriticalSpeed* speed) {
  if (!speed->value) return;
  double squares = 0;
  for (const Direction direction : kDirections) {
    if (!set[direction]->covariance) continue;
    const double factor = coverage[static_cast<std::size_t>(direction)];
    squares += factor * factor * CalcVariance(inputs, set, direction, *speed->value, &speed->sensitivities);
  }
  if (speed->sensitivities.empty()) return;
  speed->low = std::max(0.0, *speed->value - std::sqrt(squares));
  speed->high = *speed->value + std::sqrt(squares);
}

// ---------------------------------------------------------------- the hunting run

HuntingRun RunHunting(const Wagon& wagon, double V) {
  SimulationOptions options;
  options.duration = kHuntingDuration - kHuntingWindow;
  options.window = kHuntingWindow;
  const WagonState start =
      Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = kHuntingStart, .rear_y = kHuntingStart});
  SimulationResult result = Simulate(wagon, V, start, options);
  double simulated = result.simulated;
  if (result.end == SimulationEnd::kDuration) {
    options.duration = kHuntingWindow;
    result = Simulate(wagon, V, WagonState(result.state), options);
    simulated += result.simulated;
  }
  const auto motion = [&](TrackedMotion m) -> const MotionFigures& {
    return result.motions[static_cast<std::size_t>(m)];
  };
  HuntingRun run;
  run.wheelset_amplitude = {motion(TrackedMotion::kFrontLateral).amplitude,
                            motion(TrackedMotion::kRearLateral).amplitude};
  run.body_amplitude = motion(TrackedMotion::kBodyLateral).amplitude;
  const std::vector<double>& frequencies = motion(TrackedMotion::kFrontLateral).frequencies;
  if (std::ranges::max(run.wheelset_amplitude) >= kHuntingLeast && !frequencies.empty())
    run.frequency_hz = frequencies.front();
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    run.impacts[axle] = result.lateral[axle].impacts_in_window.count;
    run.peak_impact = std::max(run.peak_impact, result.lateral[axle].impacts_in_window.peak_N);
    run.longitudinal_impacts += result.longitudinal[axle].impacts_in_window.count;
  }
  run.minimum_wheel_load = result.minimum_wheel_load;
  run.wheel_lift = result.wheel_lift;
  run.derailed = result.derailed;
  run.simulated = simulated;
  run.end_reason = result.end_reason;
  return run;
}

// ---------------------------------------------------------------- all of it

/// Everything but the links.
WagonInputs ReadWagonWithoutLinks(const ValidateOptions& options, Validation* validation) {
  WagonInputs inputs;
  inputs.choice.cargo = options.cargo;
  inputs.choice.geometry = options.geometry;
  ReadWagonBody(inputs.choice, &inputs);
  ReadWagonContact(inputs.choice, &inputs);
  validation->wagon = inputs.data.name;
  validation->cargo = inputs.freight.name;
  validation->geometry = inputs.geometry->name;
  validation->notices = inputs.notices;
  for (const InputFile& file : inputs.files)
    validation->files.push_back({.role = file.role, .name = file.name, .file = file.path, .sha256 = file.sha256});
  return inputs;
}

/// One of the two things that are done with each set. Writes only to its part of the row, so that both can be done at
/// once; what fails is returned in words.
std::string Run(const WagonInputs& inputs, const ParameterSet& set, bool hunting, double V, ValidationRow* row) {
  try {
    const Wagon wagon = MakeWagonOn(inputs, set);
    if (hunting) {
      row->hunting = RunHunting(wagon, V);
    } else {
      row->critical_speed = FindCriticalSpeed(wagon);
      AddBounds(inputs, set, row->set.coverage, &*row->critical_speed);
    }
    return {};
  } catch (const std::exception& error) {
    return fmt::format("{}: {}", hunting ? "hunting run" : "linear critical speed", error.what());
  }
}

void RunAll(const WagonInputs& inputs, const std::vector<std::optional<ParameterSet>>& sets, Validation* validation) {
  std::vector<ValidationRow>& rows = validation->rows;
  const std::size_t jobs = 2 * rows.size();
  std::vector<std::string> failures(jobs);
  const auto& progress = validation->options.progress;
  ParallelFor(
      jobs, validation->options.threads,
      [&](std::size_t i) {
        // The hunting runs first: they take longer.
        const std::size_t row = i % rows.size();
        if (sets[row]) failures[i] = Run(inputs, *sets[row], i < rows.size(), validation->options.speed, &rows[row]);
      },
      [&](std::size_t done) {
        if (progress) progress("on the wagon", static_cast<int>(done), static_cast<int>(jobs));
      });
  for (std::size_t i = 0; i < jobs; ++i)
    if (!failures[i].empty()) rows[i % rows.size()].failures.push_back(std::move(failures[i]));
}

void Validate(const std::vector<ValidationSet>& given, Validation* validation) {
  const WagonInputs inputs = ReadWagonWithoutLinks(validation->options, validation);
  const ValidationSet set1 = ReadShipped("set1");
  std::vector<ValidationSet> all = given;
  all.push_back(set1);
  all.push_back(ReadShipped("set2"));
  std::vector<std::optional<ParameterSet>> sets;  // with both directions
  for (ValidationSet& set : all) {
    ValidationRow row{.set = std::move(set), .critical_speed = {}, .hunting = {}, .notices = {}, .failures = {}};
    sets.emplace_back();
    try {
      sets.back() = Complete(row.set.set, set1, &row.notices);
    } catch (const std::exception& error) {
      row.failures.emplace_back(error.what());
    }
    validation->files.push_back(
        {.role = "set", .name = row.set.set.name, .file = row.set.file, .sha256 = row.set.sha256});
    validation->rows.push_back(std::move(row));
  }
  RunAll(inputs, sets, validation);
}

}  // namespace

bool Validation::Complete() const {
  return failure.empty() && std::ranges::all_of(rows, [](const ValidationRow& row) { return row.failures.empty(); });
}

Validation ValidateOnWagon(const std::vector<ValidationSet>& sets, const ValidateOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Validation validation;
  validation.options = options;
  try {
    Validate(sets, &validation);
  } catch (const std::exception& error) {
    validation.rows.clear();
    validation.failure = error.what();
  }
  validation.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return validation;
}

}  // namespace uiclink
