#include "identify/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <exception>
#include <stdexcept>
#include <utility>

#include "data/checksum.h"
#include "data/data_path.h"
#include "data/file.h"
#include "data/parameter_set_file.h"
#include "model/parallel.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/hopf.h"
#include "vehicle/hunting/hunting_bounds.h"
#include "vehicle/hunting/speed_bounds.h"
#include "vehicle/simulation.h"
#include "vehicle/stability.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr std::array kDirections{Direction::kLateral, Direction::kLongitudinal};
constexpr double kHighestSpeed = 80;      // [m/s]: well above what any two-axle freight wagon runs
constexpr double kSpeedTolerance = 1e-9;  // of a critical speed [m/s]
constexpr double kTypeSize = 1e-4;        // of the cycle that decides the type of a crossing [m]

// ---------------------------------------------------------------- sets

ValidationSet ReadShipped(const std::string& name) {
  const std::filesystem::path path = FindDataFile("parameter_sets", name);
  const std::string text = ReadFileWhole(path);
  return {.role = name,
          .label = {},
          .file = path.string(),
          .sha256 = CalcSha256(text),
          .set = ParseParameterSet(text, path.string())};
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

/// One set on all corners. Forces per load do not depend on the g that k and T0 were divided by.
std::array<CornerLinks, kCorners> LinksOf(const ParameterSet& set) {
  std::array<CornerLinks, kCorners> links;
  links.fill({.longitudinal = *set.longitudinal, .lateral = *set.lateral, .g = set.g});
  return links;
}

Wagon MakeWagonOn(const WagonInputs& inputs, const ParameterSet& set) {
  return {inputs.data, inputs.body, inputs.loaded, LinksOf(set), inputs.table, inputs.choice.options};
}

// ---------------------------------------------------------------- the linear critical speed and its bounds

/// @param lambda  the eigenvalue that crosses.
CriticalSpeed FindCriticalSpeed(const Wagon& wagon, bool with_type, std::complex<double>* lambda) {
  StabilityOptions options;
  options.to = kHighestSpeed;
  options.tolerance = kSpeedTolerance;
  options.first_only = true;
  const StabilityResult result = FindCrossings(wagon, options);
  CriticalSpeed speed;
  speed.value = result.linear_critical_speed;
  speed.searched_to = result.searched_to;
  speed.unstable_from_start = result.unstable_at_start > 0;
  if (speed.value) {
    speed.frequency_hz = result.crossings.front().frequency_hz;
    *lambda = result.crossings.front().mode.lambda;
    if (!with_type) return speed;
    HopfOptions at;
    at.sizes = {kTypeSize};
    at.type_size = kTypeSize;
    const HopfPoint hopf = ExamineHopf(wagon, result.crossings.front(), at);
    if (hopf.type) {
      speed.type = HopfTypeName(*hopf.type);
    } else {
      speed.type_reason = hopf.reason;
    }
  }
  return speed;
}

/// To first order. @throws std::runtime_error where the critical speed cannot be followed.
void AddBounds(const Wagon& wagon, const ParameterSet& set, std::complex<double> lambda, CriticalSpeed* speed) {
  if (!speed->value) return;
  try {
    const SetScatter scatter(LinksOf(set), {.draws = 0});
    if (scatter.empty()) return;
    const Eigen::VectorXd gradient = CalcSpeedGradient(scatter, wagon, {*speed->value, lambda});
    for (std::size_t i = 0; i < scatter.parameters().size(); ++i) {
      const UncertainParameter& parameter = scatter.parameters()[i];
      speed->sensitivities.push_back({parameter.direction, parameter.symbol, gradient[static_cast<Eigen::Index>(i)]});
    }
    for (const VarianceShare& share : CalcVarianceShares(scatter, gradient).groups)
      speed->shares.push_back({share.name, share.share});
    const double half = kNormalCoverage * std::sqrt(std::max(0.0, gradient.dot(scatter.covariance() * gradient)));
    speed->low = std::max(0.0, *speed->value - half);
    speed->high = *speed->value + half;
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("no bounds: {}", error.what()));
  }
}

// ---------------------------------------------------------------- the hunting run

/// @param end  the state at the end.
HuntingRun RunHunting(const Wagon& wagon, double V, WagonState* end) {
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
  *end = result.state;
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

/// One set and what is known of it beside its row.
struct SetOnWagon {
  std::optional<ParameterSet> set;  ///< with both directions
  WagonState end;                   ///< of its hunting run
};

/// One of the two things that are done with each set. Writes only to its part of the row, so that both can be done at
/// once; what fails is returned in words.
std::string Run(const WagonInputs& inputs, bool hunting, const ValidateOptions& options, SetOnWagon* of,
                ValidationRow* row) {
  try {
    const Wagon wagon = MakeWagonOn(inputs, *of->set);
    if (hunting) {
      row->hunting = RunHunting(wagon, options.speed, &of->end);
    } else {
      std::complex<double> lambda;
      row->critical_speed = FindCriticalSpeed(wagon, options.side_by_side, &lambda);
      AddBounds(wagon, *of->set, lambda, &*row->critical_speed);
    }
    return {};
  } catch (const std::exception& error) {
    return fmt::format("{}: {}", hunting ? "hunting run" : "linear critical speed", error.what());
  }
}

void RunAll(const WagonInputs& inputs, std::vector<SetOnWagon>* sets, Validation* validation) {
  std::vector<ValidationRow>& rows = validation->rows;
  const std::size_t jobs = 2 * rows.size();
  std::vector<std::string> failures(jobs);
  const auto& progress = validation->options.progress;
  ParallelFor(
      jobs, validation->options.threads,
      [&](std::size_t i) {
        // The hunting runs first: they take longer.
        const std::size_t row = i % rows.size();
        if ((*sets)[row].set)
          failures[i] = Run(inputs, i < rows.size(), validation->options, &(*sets)[row], &rows[row]);
      },
      [&](std::size_t done) {
        if (progress) progress("on the wagon", static_cast<int>(done), static_cast<int>(jobs));
      });
  for (std::size_t i = 0; i < jobs; ++i)
    if (!failures[i].empty()) rows[i % rows.size()].failures.push_back(std::move(failures[i]));
}

// ---------------------------------------------------------------- what is uncertain about the hunting, and costs

/// Half of the 95 % intervals of the hunting of one set, by HuntingScalars(): of draws that run on from its own
/// hunting, which they are close to, so that two windows are enough to settle.
std::vector<ScalarBounds> FindHuntingBounds(const WagonInputs& inputs, const ValidateOptions& options,
                                            const SetOnWagon& of) {
  const SetScatter scatter(LinksOf(*of.set), {.draws = static_cast<std::size_t>(options.hunting_draws)});
  if (scatter.empty()) return {};
  SimulationOptions simulation;
  simulation.duration = 2 * kHuntingWindow;
  simulation.window = kHuntingWindow;
  return CalcHuntingBounds(scatter, MakeWagonOn(inputs, *of.set), options.speed, of.end, simulation,
                           {.threads = options.threads});
}

/// Every row that hunts until its end and has something uncertain.
void AddHuntingBounds(const WagonInputs& inputs, const std::vector<SetOnWagon>& sets, Validation* validation) {
  if (validation->options.hunting_draws < 2) return;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    ValidationRow& row = validation->rows[i];
    if (!row.hunting || !row.hunting->end_reason.empty()) continue;
    try {
      for (const ScalarBounds& bounds : FindHuntingBounds(inputs, validation->options, sets[i]))
        if (bounds.nominal && bounds.exists())
          row.hunting_bounds.push_back({bounds.name, bounds.unit, *bounds.nominal, kNormalCoverage * bounds.std.value});
    } catch (const std::exception& error) {
      row.notices.push_back(fmt::format("no bounds of the hunting: {}", error.what()));
    }
  }
}

void AddHuntingCost(const ValidationRow& plain, const ValidationRow& extended, Validation* validation) {
  for (const char* name : {"front lateral amplitude", "front lateral frequency"}) {
    const auto a = std::ranges::find(plain.hunting_bounds, name, &HuntingBound::name);
    const auto b = std::ranges::find(extended.hunting_bounds, name, &HuntingBound::name);
    if (a == plain.hunting_bounds.end() || b == extended.hunting_bounds.end()) continue;
    validation->cause_cost.push_back({.name = name,
                                      .unit = a->unit,
                                      .plain = a->value,
                                      .extended = b->value,
                                      .plain_half = a->half,
                                      .extended_half = b->half});
  }
}

/// Plain against extended model, where both are given, and the draws that this and a comparison need.
void AddUncertainty(const WagonInputs& inputs, const std::vector<SetOnWagon>& sets, Validation* validation) {
  const std::vector<ValidationRow>& rows = validation->rows;
  const auto find = [&](const char* role) {
    return std::ranges::find_if(rows, [&](const ValidationRow& row) { return row.set.role == role; });
  };
  const auto plain = find("identified_plain"), extended = find("identified");
  const bool both = plain != rows.end() && extended != rows.end();
  if (both || validation->options.side_by_side) AddHuntingBounds(inputs, sets, validation);
  if (!both) return;
  if (const std::optional<CauseCost> cost = CalcSpeedCost(*plain, *extended)) validation->cause_cost.push_back(*cost);
  AddHuntingCost(*plain, *extended, validation);
}

/// The sets given, then sets 1 and 2 unless they stand for themselves.
std::vector<ValidationSet> ListSets(const std::vector<ValidationSet>& given, const ValidationSet& set1,
                                    bool side_by_side) {
  std::vector<ValidationSet> all = given;
  if (side_by_side) return all;
  all.push_back(set1);
  all.push_back(ReadShipped("set2"));
  return all;
}

void Validate(const std::vector<ValidationSet>& given, Validation* validation) {
  const WagonInputs inputs = ReadWagonWithoutLinks(validation->options, validation);
  const ValidationSet set1 = ReadShipped("set1");
  std::vector<SetOnWagon> sets;
  for (ValidationSet& set : ListSets(given, set1, validation->options.side_by_side)) {
    ValidationRow row{.set = std::move(set), .critical_speed = {}, .hunting = {}, .notices = {}, .failures = {}};
    sets.emplace_back();
    try {
      sets.back().set = Complete(row.set.set, set1, &row.notices);
    } catch (const std::exception& error) {
      row.failures.emplace_back(error.what());
    }
    validation->files.push_back(
        {.role = "set", .name = row.set.set.name, .file = row.set.file, .sha256 = row.set.sha256});
    validation->rows.push_back(std::move(row));
  }
  RunAll(inputs, &sets, validation);
  AddUncertainty(inputs, sets, validation);
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
