// Parameters of the wagon by name, and the derivatives of hunting by them against differences of whole passages.

#include "vehicle/hunting/wagon_parameter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/unit/hunting_samples.h"
#include "vehicle/hunting/parameter_diagram.h"
#include "vehicle/hunting/recorded_run.h"

namespace uiclink {
namespace {

using Eigen::VectorXd;
using testing::HasSubstr;
using testing::ThrowsMessage;

double Norm(const VectorXd& v, const VectorXd& scales) { return v.cwiseQuotient(scales).norm(); }

/// What MakeWagon(sample) is made of.
WagonInputs MakeInputs(const HuntingSample& sample) {
  WagonFixture fixture{.freight = sample.freight};
  WagonInputs inputs;
  inputs.choice.options.suspension = sample.suspension;
  inputs.choice.options.guidance = sample.guidance;
  inputs.data = fixture.ReadData();
  inputs.freight = ReadFreight(WagonFixture::Data() / "freight" / (sample.freight + ".toml"));
  inputs.body = fixture.ReadBody();
  inputs.loaded = sample.freight != "empty";
  CornerLinks links = fixture.ReadLinks();
  if (sample.extended) links.lateral.effects = ExtendedEffects();
  inputs.links = {links, links, links, links};
  inputs.table = MakeHandMadeTable();
  return inputs;
}

// ---------------------------------------------------------------- names

TEST(WagonParameter, HasTheNamesOfSetsAndCampaigns) {
  const WagonInputs inputs = MakeInputs({.name = "extended", .freight = "packed", .extended = true});
  const CornerLinks& links = inputs.links[0];
  struct Expected {
    const char* name;
    const char* unit;
    double value;
  };
  for (const Expected& expected :
       std::vector<Expected>{{"lateral.k", "1/m", links.lateral.k},
                             {"rear-left.lateral.k1", "1/m", links.lateral.sliders[0].k},
                             {"longitudinal.T04", "-", links.longitudinal.sliders[3].T0},
                             {"front.lateral.clearance.gap", "m", 1e-4},
                             {"friction", "-", 0.15},
                             {"lateral_clearance_mm", "mm", 1e3 * inputs.data.guidance.lateral.clearance},
                             {"longitudinal_stop_N_per_m", "N/m", inputs.data.guidance.longitudinal.k},
                             {"body_yaw_inertia_kg_m2", "kg m^2", inputs.body.I_z},
                             {"cargo_mass_kg", "kg", inputs.freight.even->mass}}) {
    const WagonParameter parameter = FindWagonParameter(inputs, expected.name);
    EXPECT_EQ(parameter.name, expected.name);
    EXPECT_EQ(parameter.unit, expected.unit) << expected.name;
    EXPECT_DOUBLE_EQ(parameter.value, expected.value) << expected.name;
  }
  for (const WagonParameter& parameter : ListWagonParameters(inputs))
    EXPECT_EQ(FindWagonParameter(inputs, parameter.name).value, parameter.value);
}

TEST(WagonParameter, ActsWhereItsNameSays) {
  const WagonInputs inputs = MakeInputs({});
  const double k = 1.1 * inputs.links[0].lateral.k;
  const auto make = [&](const std::string& name, double value) {
    return FamilyByParameter(inputs, FindWagonParameter(inputs, name), 20, 0.9 * value, 1.1 * value).make(value);
  };
  const auto stiffness = [](const Link& link) { return LinkState::AtRest(link, 0).K; };
  const Wagon own(inputs.data, inputs.body, inputs.loaded, inputs.links, inputs.table, inputs.choice.options);
  const auto rear = make("rear.lateral.k", k);
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double more = EndOf(i) < 0 ? (k - inputs.links[i].lateral.k) * own.corners[i].load : 0;
    EXPECT_NEAR(stiffness(rear->lateral[i]), stiffness(own.lateral[i]) + more, 1e-12 * stiffness(own.lateral[i]));
    EXPECT_EQ(stiffness(rear->longitudinal[i]), stiffness(own.longitudinal[i]));
  }
  EXPECT_EQ(make("friction", 0.3)->mu, 0.3);
  EXPECT_DOUBLE_EQ(make("lateral_clearance_mm", 15)->guidance.lateral.clearance, 15e-3);
  // Corners carry the body, and a heavier body more of it.
  const auto heavy = make("body_mass_kg", 2 * inputs.body.m);
  EXPECT_DOUBLE_EQ(heavy->corners[0].load, 2 * own.corners[0].load);
  EXPECT_EQ(heavy->body.I_z, own.body.I_z);
}

TEST(WagonParameter, CargoKeepsItsShape) {
  const WagonInputs inputs = MakeInputs({.name = "packed", .freight = "packed"});
  WagonInputs changed = inputs;
  const WagonParameter parameter = FindWagonParameter(inputs, "cargo_mass_kg");
  const BodyInertia empty = MakeInputs({}).body;
  parameter.set(0.5 * parameter.value, &changed);
  EXPECT_NEAR(changed.body.m, 0.5 * (inputs.body.m + empty.m), 1e-9 * inputs.body.m);
  parameter.set(parameter.value, &changed);
  EXPECT_NEAR(changed.body.I_z, inputs.body.I_z, 1e-12 * inputs.body.I_z);
}

TEST(WagonParameter, SaysWhatItCannotVary) {
  WagonInputs inputs = MakeInputs({});
  const auto find = [&](const char* name) { return [&, name] { FindWagonParameter(inputs, name); }; };
  EXPECT_THAT(find("gauge_mm"), ThrowsMessage<UsageError>(HasSubstr("acts through the contact table")));
  EXPECT_THAT(find("lateral.k7"), ThrowsMessage<UsageError>(HasSubstr("expected one of lateral.k, lateral.k1, ")));
  EXPECT_THAT(find("lateral."), ThrowsMessage<UsageError>(HasSubstr("expected one of")));
  EXPECT_THAT(find("cargo_mass_kg"), ThrowsMessage<UsageError>(HasSubstr("there is no cargo")));
  const WagonParameter friction = FindWagonParameter(inputs, "friction");
  EXPECT_THAT([&] { FamilyByParameter(inputs, friction, 20, 0, 0.3); },
              ThrowsMessage<UsageError>(HasSubstr("--range: expected 0 < LOW < HIGH")));
  inputs.links[2].lateral.k *= 1.1;
  EXPECT_THAT(find("lateral.k"), ThrowsMessage<UsageError>(HasSubstr("corners that have it in common")));
  EXPECT_NO_THROW(find("front.lateral.k")());
}

// ---------------------------------------------------------------- derivatives

struct Derivative {
  const char* parameter;
  HuntingSample sample;
  double share = 1e-4;  ///< of the value: the step of differences
};
void PrintTo(const Derivative& derivative, std::ostream* out) { *out << derivative.parameter; }

struct ByParameter : testing::TestWithParam<Derivative> {};

struct Deflection {
  double d = 0, v = 0;
};
Deflection DeflectionOf(const Wagon& wagon, const StateVector<double>& x, std::size_t link) {
  const CornerDeflection<double> at = CalcDeflection(wagon, x, link % kCorners);
  return link < kCorners ? Deflection{at.dx, at.vx} : Deflection{at.dy, at.vy};
}

/// The start for a wagon that is a little different: joints that slide are at its own limit.
VectorXd Transfer(const VectorXd& start, const std::vector<int>& slaved, const Wagon& from, const Wagon& to) {
  VectorXd moved = start;
  const std::vector<SliderPlace> sliders = ListSliders(from);
  StateVector<double> x{};
  std::copy_n(start.data(), from.size(), x.begin());
  for (const int i : slaved) {
    const SliderPlace& place = sliders[static_cast<std::size_t>(i) - from.size()];
    // p = d - side (limit + clearance), with the deflection of the same motions.
    const double side = DeflectionOf(from, x, place.link).d > start[i] ? 1 : -1;
    const auto position = [&](const Wagon& wagon) {
      const Link& link = LinkAt(wagon, place.link);
      const Deflection at = DeflectionOf(wagon, x, place.link);
      const double limit = link.CalcSlidingForce(place.joint, side, at.v) / link.sliders()[place.joint].k;
      return at.d - side * (limit + link.gap(place.joint));
    };
    moved[i] += position(to) - position(from);
  }
  return moved;
}

// Differences of whole passages, of fourth order from steps of 0.01 and 0.02 % of the value (0.1 and 0.2 % of a
// clearance of 0.1 mm). Their error is that of two runs at 1e-10 a step over the step: measured 3e-7 to 9e-6 of the
// derivative, and 1e-5 to 7e-5 where a number acts only a little (guides, one joint of four) or moves many events (a
// static peak, a clearance).
TEST_P(ByParameter, TheDerivativeIsThatOfDifferences) {
  const HuntingSample& sample = GetParam().sample;
  HuntingWagon hunting(sample, 1e-10);
  const WagonInputs inputs = MakeInputs(sample);
  const WagonParameter parameter = FindWagonParameter(inputs, GetParam().parameter);
  const double p = parameter.value;
  const WagonFamily family = FamilyByParameter(inputs, parameter, sample.V, 0.9 * p, 1.1 * p);
  WagonFlow flow(family, p, {.tolerance = 1e-10});
  const Passage passage = flow.Pass(hunting.start, hunting.period, p, Flow::Derivatives::kAll);
  const auto end = [&](double value) {
    const VectorXd start = Transfer(hunting.start, passage.slaved_start, *family.make(p), *family.make(value));
    return flow.Pass(start, hunting.period, value, Flow::Derivatives::kNone).end;
  };
  const auto slope = [&](double h) -> VectorXd { return (end(p + h) - end(p - h)) / (2 * h); };
  const VectorXd expected = (4 * slope(GetParam().share * p) - slope(2 * GetParam().share * p)) / 3;
  const double error = Norm(passage.by_parameter - expected, flow.scales()) / Norm(expected, flow.scales());
  RecordProperty("error", std::to_string(error));
  EXPECT_LT(error, 1e-4);
  EXPECT_GT(Norm(expected, flow.scales()) * p, 1e-3) << "it acts";
}

const HuntingSample kImpacts{.name = "with_impacts"};
const HuntingSample kExtended{.name = "extended", .extended = true};
INSTANTIATE_TEST_SUITE_P(All, ByParameter,
                         testing::ValuesIn(std::vector<Derivative>{
                             {"lateral.k", kImpacts},
                             {"front-left.lateral.k1", kImpacts},
                             {"lateral.T01", kImpacts},
                             {"longitudinal.k", kImpacts},
                             {"longitudinal.k2", kImpacts},
                             {"friction", kImpacts},
                             {"lateral_clearance_mm", kImpacts},
                             {"lateral_stop_N_per_m", kImpacts},
                             {"body_mass_kg", kImpacts},
                             {"body_yaw_inertia_kg_m2", kImpacts},
                             {"body_height_mm", kImpacts},
                             {"body_height_mm", kExtended},
                             {"wheelset_mass_kg", kImpacts},
                             {"cargo_mass_kg", {.name = "packed", .freight = "packed", .V = 24}},
                             {"lateral.k1", kExtended},
                             {"lateral.T01", kExtended},
                             {"lateral.viscous_damping.c", kExtended},
                             {"lateral.clearance.gap", kExtended, 1e-3},
                             {"lateral.stribeck_friction.s", kExtended},
                             {"lateral.stribeck_friction.v_s", kExtended},
                         }),
                         [](const auto& derivative) {
                           std::string name = derivative.param.sample.name + "_" + derivative.param.parameter;
                           std::ranges::replace_if(
                               name, [](char c) { return c == '.' || c == '-'; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace uiclink
