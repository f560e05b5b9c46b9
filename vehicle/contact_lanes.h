#pragma once

#include <cstddef>

#include "vehicle/contact/contact_curve.h"
#include "vehicle/lanes.h"
#include "vehicle/wheel_force.h"

namespace uiclink {

/// Contact quantities of four wheels: each wheel's from its cell, several quantities at once, then turned so that each
/// quantity has the four wheels in its lanes.
class ContactLanes {
 public:
  /// @param curve_of  the table of the wheel in a lane.
  template <typename CurveOf>
  [[gnu::always_inline]] ContactLanes(const CurveOf& curve_of, const Lanes& y) {
    for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
      const ContactCurve& curve = curve_of(wheel);
      const ContactCurve::Place place = curve.Find(y[wheel]);
      t_[wheel] = place.t;
      Set(wheel, curve.cubic(place.cell));
      const ContactCurve::PoseCubic& c = curve.pose_cubic(place.cell);
      for (std::size_t i = 0; i < 2; ++i)
        pose_[i][wheel] = ((c[3][i] * place.t + c[2][i]) * place.t + c[1][i]) * place.t + c[0][i];
      after_[wheel] = curve.after_jump(place.cell);
      jumps_ |= after_[wheel] != nullptr;
    }
  }
  [[gnu::always_inline]] bool jumps() const { return jumps_; }
  /// Goes over to the contacts behind their jumps. Returns the share of each.
  [[gnu::always_inline]] Lanes PassJumps() {
    Lanes share(0.0);
    for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
      if (after_[wheel] == nullptr) continue;
      Set(wheel, *after_[wheel]);
      share.Set(wheel, ContactCurve::ShareAfter(t_[wheel]));
    }
    return share;
  }
  [[gnu::always_inline]] WheelContact<Lanes> Contact() const {
    Lanes a = first_[0], r = first_[1], sine = first_[2], cosine = first_[3];
    Lanes n = second_[0], f11 = second_[1], f22 = second_[2], f23 = second_[3];
    Lanes::Transpose(&a, &r, &sine, &cosine);
    Lanes::Transpose(&n, &f11, &f22, &f23);
    return {a, r, sine, cosine, n, f11, f22, f23};
  }
  [[gnu::always_inline]] KinematicPose<Lanes> Pose() const { return {Lanes(pose_[0]), Lanes(pose_[1])}; }

 private:
  static constexpr std::size_t kWheels = 4;
  static_assert(ContactCurve::kQuantities == 8);

  [[gnu::always_inline]] void Set(std::size_t wheel, const ContactCurve::Cubic& c) {
    const Lanes t(t_[wheel]);
    first_[wheel] = ((Lanes(&c[3][0]) * t + Lanes(&c[2][0])) * t + Lanes(&c[1][0])) * t + Lanes(&c[0][0]);
    second_[wheel] = ((Lanes(&c[3][4]) * t + Lanes(&c[2][4])) * t + Lanes(&c[1][4])) * t + Lanes(&c[0][4]);
  }

  Lanes first_[kWheels];   ///< quantities 0 to 3 by wheel
  Lanes second_[kWheels];  ///< 4 to 7
  alignas(32) double pose_[2][kWheels];
  const ContactCurve::Cubic* after_[kWheels];
  double t_[kWheels];
  bool jumps_ = false;
};

/// @param approach  of a contact and the wheels' pose.
template <typename CurveOf, typename P, typename Approach>
[[gnu::always_inline]] inline WheelForces<Lanes> CalcWheels(const CurveOf& curve_of, const WheelsetMotion<Lanes>& m,
                                                            const WheelSettingsOf<P>& settings,
                                                            const Approach& approach) {
  ContactLanes contacts(curve_of, m.y);
  const WheelContact<Lanes> contact = contacts.Contact();
  const KinematicPose<Lanes> pose = contacts.Pose();
  WheelForces<Lanes> forces = CalcWheel(m, contact, approach(contact, pose), settings);
  if (contacts.jumps()) [[unlikely]] {
    const Lanes share = contacts.PassJumps();
    const WheelContact<Lanes> after = contacts.Contact();
    Blend(share, CalcWheel(m, after, approach(after, pose), settings), &forces);
  }
  return forces;
}

}  // namespace uiclink
