#pragma once

#include <Eigen/Core>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/wagon_flow.h"
#include "vehicle/simulation.h"

namespace uiclink {

/// A wagon whose hunting is to be differentiated. On knife-edge rails (tests/support/wagon_fixture.h).
struct HuntingSample {
  std::string name;
  std::string freight = "empty";
  Suspension suspension = Suspension::kParabolic;
  bool guidance = true;
  bool extended = false;  ///< viscous damping, clearance and a static peak that falls with the speed of sliding
  double V = 20;
};
inline void PrintTo(const HuntingSample& sample, std::ostream* out) { *out << sample.name; }

inline std::vector<EffectValues> ExtendedEffects() {
  return {{"viscous_damping", {{"c", 0.01}}},
          {"clearance", {{"gap", 1e-4}}},
          {"stribeck_friction", {{"s", 0.15}, {"v_s", 0.02}}}};
}

inline Wagon MakeWagon(const HuntingSample& sample, double stiffer = 1) {
  WagonFixture fixture{.freight = sample.freight};
  fixture.options.suspension = sample.suspension;
  fixture.options.guidance = sample.guidance;
  CornerLinks links = fixture.ReadLinks();
  links.lateral.k *= stiffer;
  if (sample.extended) links.lateral.effects = ExtendedEffects();
  return Wagon(fixture.ReadData(), fixture.ReadBody(), sample.freight != "empty", {links, links, links, links},
               MakeHandMadeTable(), fixture.options);
}

/// A wagon that has come to hunt, at a moment when its body passes the middle.
struct HuntingWagon {
  HuntingSample sample;
  Wagon wagon;
  WagonFlow flow;
  Eigen::VectorXd start;
  double period = 0;

  explicit HuntingWagon(const HuntingSample& made, double tolerance = 1e-10)
      : sample(made), wagon(MakeWagon(made)), flow(FamilyBySpeed(wagon), made.V, {.tolerance = tolerance}) {
    // The long run needs no such tolerance.
    WagonFlow rough(FamilyBySpeed(wagon), made.V, {.tolerance = 1e-7});
    const WagonState pushed =
        Perturb(wagon, FindEquilibrium(wagon, made.V), {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3});
    const auto guess = rough.GuessCycle(pushed, made.V, 12);
    if (!guess) throw std::runtime_error(made.name + " does not hunt");
    start = guess->state;
    period = guess->period;
  }
};

}  // namespace uiclink
