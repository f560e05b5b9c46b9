#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "model/parameter_set.h"
#include "vehicle/contact/contact_curve.h"
#include "vehicle/contact/contact_table.h"
#include "vehicle/link.h"
#include "vehicle/wagon_data.h"
#include "vehicle/wagon_state.h"

namespace uiclink {

/// The vertical suspension (chapter 5). With kLinear the links are springs without sliders too (suspension type 1).
enum class Suspension { kLinear, kParabolic, kLeaf };

/// What the additional penetration is measured from.
enum class Penetration {
  kTouching,  ///< the height at which wheel and rail just touch
  kPrinted,   ///< as the thesis prints it: each lateral position's own static state (corrections.md 1.3)
};

struct WagonOptions {
  Suspension suspension = Suspension::kParabolic;
  Penetration penetration = Penetration::kTouching;
  bool guidance = true;
  double mu = 0.15;           ///< friction of wheel on rail [-] (section 3.2)
  bool printed_roll = false;  ///< wheelset roll as (2.4) prints it, without r_l C_ly + r_r C_ry
};

/// The links of one corner: what is used of a parameter set.
struct CornerLinks {
  DirectionParameters longitudinal;
  DirectionParameters lateral;
  double g =
      kThesisGravity;  ///< that a set was normalised with [m/s^2]; forces are its numbers times the load, without it
};

/// A wagon ready to run, at any speed. Constant; shared by threads. Its members are for reading.
///
/// Frames: x forward, y left, z up. Motions of wheelsets are relative to the track frame that moves with the wagon,
/// z from the height at which wheels of radius r0 stand on the rail tops; those of the body from its static position.
class Wagon {
 public:
  Wagon(const WagonData& data, const BodyInertia& body, bool loaded, const std::array<CornerLinks, kCorners>& links,
        const ContactTable& table, const WagonOptions& options);
  /// On a curve that is known already: making it from its table takes most of the time.
  Wagon(const WagonData& data, const BodyInertia& body, bool loaded, const std::array<CornerLinks, kCorners>& links,
        const ContactCurve& contact, const WagonOptions& options);

  // What does not change between corners.
  double g = 0;
  double b = 0;   ///< lateral half distance of links, springs, guidance on the wheelset [m]
  double mu = 0;  ///< wheel-rail friction [-]
  double r0 = 0;  ///< nominal rolling radius [m]
  WheelsetInertia wheelset;
  BodyInertia body;
  Guidance guidance;
  WagonOptions options;
  LinearSpring linear;
  ParabolicSpring parabolic;
  double parabolic_damping = 0;  ///< d of the parabolic spring: unloaded or loaded wagon [N s/m]
  LeafSpring leaf;
  ContactCurve contact;

  /// Corner by corner, as seen from the body's centre of mass.
  struct Corner {
    double X = 0;     ///< arm ahead [m]
    double Y = 0;     ///< arm to the left [m]
    double load = 0;  ///< weight of body and freight on it [N]
    double s_eq = 0;  ///< compression of its spring there [m]
  };
  std::array<Corner, kCorners> corners;
  std::array<Link, kCorners> longitudinal;
  std::array<Link, kCorners> lateral;

  /// Components of the state vector that move: 30, or 34 with leaf springs.
  std::size_t size() const { return options.suspension == Suspension::kLeaf ? kMaxState : kMotions; }
  bool all_links_affine() const { return all_links_affine_; }

  /// What follows from all this, in the form that the right-hand side wants.
  struct Fixed {
    alignas(32) std::array<double, kCorners> e_b{}, X{}, Y{}, s_eq{};
    double per_m_w = 0, per_I_wx = 0, per_I_wy = 0, per_I_wz = 0;  ///< 1 / mass or inertia of a wheelset
    double per_m_c = 0, per_I_cx = 0, per_I_cz = 0;                ///< ... of the body
  };
  const Fixed& fixed() const { return fixed_; }

 private:
  bool all_links_affine_ = true;
  Fixed fixed_;
};

/// Which joints stick and slide, corner by corner.
struct LinkStates {
  std::array<LinkState, kCorners> longitudinal;
  std::array<LinkState, kCorners> lateral;
};

/// Everything that a run goes on from.
struct WagonState {
  double t = 0;  ///< [s]
  StateVector<double> x{};
  LinkStates links;
};

/// Deflections of link, spring and guidance at a corner: axle box relative to body.
template <typename T>
struct CornerDeflection {
  T dx{}, vx{};  ///< longitudinal [m], [m/s]
  T dy{}, vy{};  ///< lateral
  T s{}, vs{};   ///< compression of the vertical spring and its rate
};

/// What of a corner's place is constant, for one corner (double) or for four at once.
template <typename K>
struct CornerPlace {
  K e_b;   ///< lateral arm on the wheelset, + left [m]
  K X, Y;  ///< arms from the body's centre of mass [m]
  K s_eq;  ///< compression of the spring in the static position [m]
};

/// dx = x - e b psi_w + Y psi_c,  dy = y_w - (y_c + X psi_c + h phi_c),  s = s_eq + z_w + e b phi_w - (z_c + Y phi_c);
/// e = +1 left, -1 right; X, Y arms of the corner from the body's centre of mass.
/// @param h  of the body; Lanes where every lane is another wagon.
/// @param axle, car  give the motions of the corner's wheelset and of the body by their index.
template <typename V, typename K, typename H, typename Axle, typename Car>
[[gnu::always_inline]] inline CornerDeflection<V> CalcDeflection(const CornerPlace<K>& at, const H& h, const Axle& axle,
                                                                 const Car& car) {
  return {.dx = axle(wheelset::kX) - at.e_b * axle(wheelset::kPsi) + at.Y * car(body::kPsi),
          .vx = axle(wheelset::kXRate) - at.e_b * axle(wheelset::kPsiRate) + at.Y * car(body::kPsiRate),
          .dy = axle(wheelset::kY) - (car(body::kY) + at.X * car(body::kPsi) + h * car(body::kPhi)),
          .vy = axle(wheelset::kYRate) - (car(body::kYRate) + at.X * car(body::kPsiRate) + h * car(body::kPhiRate)),
          .s = at.s_eq + axle(wheelset::kZ) + at.e_b * axle(wheelset::kPhi) - (car(body::kZ) + at.Y * car(body::kPhi)),
          .vs = axle(wheelset::kZRate) + at.e_b * axle(wheelset::kPhiRate) -
                (car(body::kZRate) + at.Y * car(body::kPhiRate))};
}

inline CornerPlace<double> PlaceOf(const Wagon& wagon, std::size_t corner) {
  const Wagon::Corner& at = wagon.corners[corner];
  return {.e_b = SideOf(corner) * wagon.b, .X = at.X, .Y = at.Y, .s_eq = at.s_eq};
}

template <typename T>
CornerDeflection<T> CalcDeflection(const Wagon& wagon, const StateVector<T>& x, std::size_t corner) {
  const std::size_t wheelset_begin = AxleOf(corner) * wheelset::kSize;
  return CalcDeflection<T>(
      PlaceOf(wagon, corner), wagon.body.h, [&](std::size_t i) -> const T& { return x[wheelset_begin + i]; },
      [&](std::size_t i) -> const T& { return x[kBody + i]; });
}

}  // namespace uiclink
