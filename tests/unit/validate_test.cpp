// Identified sets on the wagon: figures against those of vehicle/ called directly, bounds against a propagation that is
// done another way, and what happens to sets and data that are incomplete.

#include "identify/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "data/data_path.h"
#include "data/parameter_set_file.h"
#include "tests/cli/temporary_folder.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"
#include "vehicle/stability.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ParameterSet Shipped(const std::string& name) { return ReadParameterSet(FindDataFile("parameter_sets", name)); }

ValidationSet Given(ParameterSet set) {
  return {.role = "identified", .label = {}, .file = "out/parameters.toml", .sha256 = "none", .set = std::move(set)};
}

/// Set 1, with the correlated errors of k and k1 that a fit of the lateral direction has.
ParameterSet Uncertain() {
  ParameterSet set = Shipped("set1");
  set.lateral->covariance = {.order = {"k", "k1", "T01"},
                             .matrix = {{4e-4, -3e-4, 1e-8}, {-3e-4, 9e-4, 2e-8}, {1e-8, 2e-8, 1e-8}}};
  return set;
}

/// What one set does on the wagon.
ValidationRow Only(const ValidationSet& set, const ValidateOptions& options = {}) {
  const Validation validation = ValidateOnWagon({set}, options);
  EXPECT_EQ(validation.failure, "");
  EXPECT_EQ(validation.rows.size(), 3u);
  return validation.rows.front();
}

Wagon WagonOn(const ParameterSet& set, const std::string& geometry = "nominal-1435") {
  WagonChoice choice;
  choice.sets = {"set1"};
  choice.geometry = geometry;
  WagonInputs inputs = ReadWagonInputs(choice);
  inputs.links.fill({.longitudinal = *set.longitudinal, .lateral = *set.lateral, .g = set.g});
  return MakeWagon(inputs);
}

/// As `wagon stability` finds it, over all speeds.
double CriticalSpeedOf(const ParameterSet& set) {
  StabilityOptions options;
  options.to = 30;
  options.tolerance = 1e-10;
  return FindCrossings(WagonOn(set), options).linear_critical_speed.value();
}

TEST(Validate, CriticalSpeedsAreThoseOfTheWagonAlone) {
  for (const char* geometry : {"nominal-1435", "nominal-1435-rigid", "thesis-equivalent"}) {
    const Validation validation = ValidateOnWagon({}, {.geometry = geometry});
    ASSERT_EQ(validation.rows.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string name = i == 0 ? "set1" : "set2";
      EXPECT_EQ(validation.rows[i].set.role, name);
      const Wagon wagon = WagonOn(Shipped(name), geometry);
      const StabilityResult stability = FindCrossings(wagon, {});
      const CriticalSpeed& speed = validation.rows[i].critical_speed.value();
      // Both are bisected: to 1e-7 m/s there, to 1e-9 here.
      EXPECT_NEAR(speed.value.value(), stability.linear_critical_speed.value(), 1.01e-7) << geometry << ' ' << name;
      EXPECT_FALSE(speed.low || speed.high) << "these sets have no covariance";
    }
  }
}

TEST(Validate, HuntingRunIsThatOfTheWagonAlone) {
  const HuntingRun run = Only(Given(Shipped("set2"))).hunting.value();
  const Wagon wagon = WagonOn(Shipped("set2"));
  SimulationOptions options;
  options.duration = kHuntingDuration;
  options.window = kHuntingWindow;
  const SimulationResult result =
      Simulate(wagon, 12, Perturb(wagon, FindEquilibrium(wagon, 12), {.front_y = 5e-3, .rear_y = 5e-3}), options);
  EXPECT_EQ(run.wheelset_amplitude[0], result.motions[0].amplitude);  // the same run: bit by bit
  EXPECT_EQ(run.wheelset_amplitude[1], result.motions[1].amplitude);
  EXPECT_EQ(run.body_amplitude, result.motions[2].amplitude);
  EXPECT_EQ(run.frequency_hz.value(), result.motions[0].frequencies.at(0));
  EXPECT_GT(run.minimum_wheel_load, result.minimum_wheel_load) << "that of the start is not in the window";
  EXPECT_EQ(run.impacts,
            (std::array{result.lateral[0].impacts_in_window.count, result.lateral[1].impacts_in_window.count}));
  EXPECT_EQ(run.simulated, kHuntingDuration);
  EXPECT_GT(run.wheelset_amplitude[0], 1e-4) << "above its critical speed the wagon hunts";
}

TEST(Validate, DerailmentEndsARunAndIsSaid) {
  const ValidationRow row = Only(Given(Shipped("set1")), {.speed = 80});  // 288 km/h
  const HuntingRun& run = row.hunting.value();
  EXPECT_TRUE(run.derailed || run.wheel_lift);
  EXPECT_THAT(run.end_reason, HasSubstr("wheel"));
  EXPECT_LT(run.simulated, kHuntingDuration - kHuntingWindow);
  EXPECT_THAT(row.failures, IsEmpty()) << "this is what the wagon does: nothing has failed";
}

TEST(Validate, BoundsAreThePropagatedCovariance) {
  const ParameterSet set = Uncertain();
  const CriticalSpeed speed = Only(Given(set)).critical_speed.value();
  // The stiffness at rest is k + k1, however it is shared; T01 does not come in. One derivative is enough, here by
  // differences of fourth order with steps thirty times as long, over the whole range of speeds.
  const auto at = [&](double change) {
    ParameterSet changed = set;
    changed.lateral->k += change;
    return CriticalSpeedOf(changed);
  };
  const double h = 0.12;
  const double slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
  const double half = 1.96 * std::sqrt(slope * slope * (4e-4 + 9e-4 - 2 * 3e-4));
  ASSERT_TRUE(speed.low && speed.high);
  // Truncation of either difference is below 1e-4 of the slope: the critical speed curves with the square root of k.
  EXPECT_NEAR(*speed.high - *speed.value, half, 1e-4 * half);
  EXPECT_NEAR(*speed.value - *speed.low, half, 1e-4 * half);
  ASSERT_EQ(speed.sensitivities.size(), 3u);
  EXPECT_NEAR(speed.sensitivities[0].derivative, slope, 1e-4 * slope);
  EXPECT_NEAR(speed.sensitivities[1].derivative, slope, 1e-4 * slope);
  EXPECT_EQ(speed.sensitivities[2].derivative, 0);
}

TEST(Validate, DirectionsAreIndependentAndHaveTheirOwnCoverage) {
  ValidationSet lateral = Given(Uncertain());
  lateral.set.lateral->covariance->coverage = 4.3;  // Student, three records
  ValidationSet longitudinal = Given(Shipped("set1")), both = lateral;
  longitudinal.set.longitudinal->covariance = {.order = {"k", "k2"}, .matrix = {{1e-2, 0}, {0, 4e-2}}};
  both.set.longitudinal = longitudinal.set.longitudinal;
  const auto half = [](const ValidationRow& row) { return *row.critical_speed->high - *row.critical_speed->value; };
  const Validation validation = ValidateOnWagon({Given(Uncertain()), lateral, longitudinal, both});
  const std::vector<ValidationRow>& rows = validation.rows;
  // The same derivatives: nothing but rounding, of speeds near 6 m/s against halves near 0.01 m/s.
  EXPECT_NEAR(half(rows[1]), half(rows[0]) * 4.3 / 1.96, 1e-11);
  EXPECT_NEAR(half(rows[3]), std::hypot(half(rows[1]), half(rows[2])), 1e-11);
  EXPECT_GT(half(rows[2]), 0);
}

TEST(Validate, ParametersOfEffectsCount) {
  ParameterSet set = Shipped("set1");
  set.lateral->effects = {{.id = "viscous_damping", .parameters = {{"c", 0.02}}}};
  set.lateral->covariance = {.order = {"k", "viscous_damping.c"}, .matrix = {{1e-4, 0}, {0, 1e-6}}};
  const CriticalSpeed speed = Only(Given(set)).critical_speed.value();
  ASSERT_EQ(speed.sensitivities.size(), 2u);
  EXPECT_EQ(speed.sensitivities[1].symbol, "viscous_damping.c");
  EXPECT_GT(speed.sensitivities[1].derivative, 0) << "damping between wheelset and body makes the wagon more stable";
  EXPECT_GT(*speed.value, Only(Given(Shipped("set1"))).critical_speed->value.value());
}

TEST(Validate, BoundsThatCannotBeFoundLeaveTheCriticalSpeed) {
  ParameterSet set = Shipped("set1");
  set.lateral->covariance = {.order = {"k", "k7"}, .matrix = {{1e-4, 0}, {0, 1e-4}}};
  const ValidationRow row = Only(Given(set));
  EXPECT_TRUE(row.critical_speed->value);
  EXPECT_FALSE(row.critical_speed->low || row.critical_speed->high);
  EXPECT_THAT(row.failures,
              ElementsAre("linear critical speed: no bounds: lateral k7 is in the covariance, but not in the set"));
}

TEST(Validate, DirectionThatWasNotMeasuredComesFromSet1) {
  const ParameterSet set1 = Shipped("set1"), set2 = Shipped("set2");
  for (const Direction missing : {Direction::kLateral, Direction::kLongitudinal}) {
    ParameterSet part = set2, whole = set2;
    part.g = 9.81;  // what it was normalised with does not come into forces per load
    if (missing == Direction::kLateral) {
      part.lateral.reset();
      whole.lateral = set1.lateral;
    } else {
      part.longitudinal.reset();
      whole.longitudinal = set1.longitudinal;
    }
    const ValidationRow row = Only(Given(part)), same = Only(Given(whole));
    ASSERT_EQ(row.notices.size(), 1u);
    EXPECT_THAT(row.notices[0],
                HasSubstr(std::string("the ") + Name(missing) + " direction was not measured: it comes from set 1"));
    EXPECT_THAT(same.notices, IsEmpty());
    EXPECT_EQ(row.critical_speed->value, same.critical_speed->value);
    EXPECT_EQ(row.hunting->wheelset_amplitude, same.hunting->wheelset_amplitude);
  }
}

TEST(Validate, EffectsWithoutAPlaceOnAWagonAreLeftOut) {
  ParameterSet set = Shipped("set1");
  set.lateral->effects = {{.id = "sensor_drift", .parameters = {{"rate", 1e-5}}}};
  const ValidationRow row = Only(Given(set));
  EXPECT_THAT(row.notices, ElementsAre("sensor_drift (lateral) has no place on a wagon and is left out"));
  EXPECT_EQ(row.critical_speed->value, Only(Given(Shipped("set1"))).critical_speed->value);
}

TEST(Validate, OneSetThatCannotRunLeavesTheOthers) {
  ParameterSet set = Shipped("set1");
  set.lateral->effects = {{.id = "magic", .parameters = {}}};
  const Validation validation = ValidateOnWagon({Given(set), Given(Shipped("set1"))});
  ASSERT_EQ(validation.rows.size(), 4u);
  EXPECT_FALSE(validation.Complete());
  EXPECT_FALSE(validation.rows[0].critical_speed || validation.rows[0].hunting);
  ASSERT_EQ(validation.rows[0].failures.size(), 2u);
  EXPECT_THAT(validation.rows[0].failures[0], HasSubstr("magic"));
  for (std::size_t i = 1; i < 4; ++i) EXPECT_TRUE(validation.rows[i].critical_speed && validation.rows[i].hunting) << i;
}

TEST(Validate, WithoutDataNothingIsDoneAndSaid) {
  const Validation no_freight = ValidateOnWagon({Given(Shipped("set1"))}, {.cargo = "feathers"});
  EXPECT_THAT(no_freight.failure, HasSubstr("feathers"));
  EXPECT_THAT(no_freight.rows, IsEmpty());
  EXPECT_FALSE(no_freight.Complete());

  const ValidationSet set = Given(Shipped("set1"));
  const TemporaryFolder empty;
  setenv("UICLINK_DATA", empty.path().c_str(), 1);
  const Validation no_data = ValidateOnWagon({set});
  unsetenv("UICLINK_DATA");
  EXPECT_THAT(no_data.failure, HasSubstr("hbbills311"));
  EXPECT_THAT(no_data.rows, IsEmpty());
}

TEST(Validate, TheNumberOfThreadsDoesNotChangeResults) {
  const std::vector<ValidationSet> sets{Given(Uncertain())};
  int last = 0;
  const Validation one = ValidateOnWagon(sets, {.threads = 1, .progress = [&](const std::string&, int done, int of) {
                                                  EXPECT_EQ(done, ++last);
                                                  EXPECT_EQ(of, 6);  // three sets, two runs each
                                                }});
  const Validation two = ValidateOnWagon(sets, {.threads = 2});
  EXPECT_EQ(last, 6);
  ASSERT_EQ(one.rows.size(), two.rows.size());
  for (std::size_t i = 0; i < one.rows.size(); ++i) {
    EXPECT_EQ(one.rows[i].critical_speed->value, two.rows[i].critical_speed->value);
    EXPECT_EQ(one.rows[i].critical_speed->high, two.rows[i].critical_speed->high);
    EXPECT_EQ(one.rows[i].hunting->wheelset_amplitude, two.rows[i].hunting->wheelset_amplitude);
    EXPECT_EQ(one.rows[i].hunting->peak_impact, two.rows[i].hunting->peak_impact);
  }
}

TEST(Validate, FilesHaveTheirChecksums) {
  const Validation validation = ValidateOnWagon({Given(Shipped("set1"))});
  std::vector<std::string> roles;
  for (const ValidationFile& file : validation.files) {
    roles.push_back(file.role);
    EXPECT_TRUE(file.sha256.size() == 64 || file.file == "out/parameters.toml") << file.file;
  }
  EXPECT_THAT(roles, ElementsAre("wagon", "cargo", "geometry", "set", "set", "set"));
  EXPECT_EQ(validation.wagon, "Hbbills 311");
  EXPECT_EQ(validation.cargo, "empty");
}

}  // namespace
}  // namespace uiclink
