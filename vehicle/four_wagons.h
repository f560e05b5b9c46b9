#pragma once

#include <array>
#include <cstddef>

#include "vehicle/lanes.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// State, or rate, of four wagons: component i of all of them.
using FourStates = StateVector<Lanes>;

/// Load Q [N] and approach q [m] of each wheel (WagonForces::Wheel).
struct FourWheelLoads {
  std::array<Lanes, kCorners> Q, q;
};

/// Four wagons whose rates are computed at once, one in each lane, each with its own parameters, speed and joints. They
/// share the kind of their springs, the form of the roll moment, and Penetration::kTouching (CanShareLanes).
struct FourWagons {
  static constexpr std::size_t kWagons = 4;

  /// @param wagon  must outlive its place in the lane.
  void SetWagon(std::size_t lane, const Wagon& wagon, double V);
  /// @param links  must outlive their place in the lane where links are not affine.
  void SetLinks(std::size_t lane, const LinkStates& links);

  struct Stop {
    Lanes k, clearance;
  };
  struct Links {
    std::array<Lanes, kCorners> K, C, c;  ///< F = C - K d - c v
  };

  std::array<const Wagon*, kWagons> wagons{};
  std::array<const LinkStates*, kWagons> states{};  ///< of the links, where they are not affine
  bool all_affine = true;
  Lanes per_V, pitch_rate, mu, g, h;
  Lanes per_m_w, per_I_wx, per_I_wy, per_I_wz, per_m_c, per_I_cx, per_I_cz;
  std::array<CornerPlace<Lanes>, kCorners> places;
  struct {
    Lanes k, d;
  } linear;
  struct {
    Lanes stiffness, k2, F0, s0;
    [[gnu::always_inline]] const Lanes& k1() const { return stiffness; }
  } parabolic;
  Lanes parabolic_damping;
  struct {
    Lanes c, mu0, F_r, beta;
  } leaf;
  Stop longitudinal_stop, lateral_stop;
  Links longitudinal, lateral;
};

/// Whether two wagons can be lanes of one FourWagons, or, when both are the same, whether one can be.
bool CanShareLanes(const WagonOptions& a, const WagonOptions& b);

/// The numbers of CalcRate() of each wagon.  Every lane's depend on that lane alone, bit by bit.
void CalcRates(const FourWagons& four, const FourStates& x, FourStates* rate, FourWheelLoads* loads);

/// CalcDeflection() of wagon.h at one corner of the four.
[[gnu::always_inline]] inline CornerDeflection<Lanes> CalcDeflection(const FourWagons& four, const FourStates& x,
                                                                     std::size_t corner) {
  const Lanes* const axle = &x[AxleOf(corner) * wheelset::kSize];
  return CalcDeflection<Lanes>(
      four.places[corner], four.h, [axle](std::size_t i) -> const Lanes& { return axle[i]; },
      [&x](std::size_t i) -> const Lanes& { return x[kBody + i]; });
}

}  // namespace uiclink
