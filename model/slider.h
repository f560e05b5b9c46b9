#pragma once

namespace uiclink {

/// A spring in series with a dry-friction slider, beside the main spring: one rolling-sliding joint of the link.
///
/// Force on the mass per unit load (Piotrowski's differential succession; y is the displacement of the mass):
///   stick  T' = -k y'  while |T| < T0,   slide  T = -sign(y') T0.
template <typename Scalar>
struct Slider {
  Scalar k{};   ///< stiffness per unit load [1/m], > 0
  Scalar T0{};  ///< force at which the joint slides, per unit load [-], >= 0
};

}  // namespace uiclink
