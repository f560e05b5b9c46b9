#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "vehicle/contact/profile.h"

namespace uiclink {
namespace {

constexpr double kMm = 1e-3;

/// A zone of a wheel profile as the standards print it: F(y) in mm, positive downward, powers of y in mm. Far from y =
/// 0 its terms cancel by five digits; written about the middle of the zone they do not.
template <std::size_t N>
ProfilePiece DownwardPolynomial(double y_begin_mm, double y_end_mm, const std::array<double, N>& printed) {
  const double middle = 0.5 * (y_begin_mm + y_end_mm);
  std::array<long double, N> shifted{};
  std::copy(printed.begin(), printed.end(), shifted.begin());
  for (std::size_t i = 0; i + 1 < N; ++i) {  // Horner's scheme, N - 1 times
    for (std::size_t k = N - 1; k-- > i;) shifted[k] += static_cast<long double>(middle) * shifted[k + 1];
  }
  std::array<double, N> c{};
  long double scale = -kMm;  // up is positive here, and c_k [mm^(1-k)] -> [m^(1-k)]
  for (std::size_t k = 0; k < N; ++k) {
    c[k] = static_cast<double>(shifted[k] * scale);
    scale /= kMm;
  }
  return ProfilePiece::Polynomial(y_begin_mm * kMm, y_end_mm * kMm, middle * kMm, c);
}

/// EN 13715; the coefficients as H. Netter (DLR) distributed them. Zones from the flange's back to the field side.
Profile MakeS1002() {
  std::vector<ProfilePiece> zones;
  zones.push_back(ProfilePiece::LowerArc(-70 * kMm, -62.764705882 * kMm, -49.5 * kMm, -9.519259302 * kMm, 20.5 * kMm));
  zones.push_back(ProfilePiece::LowerArc(-62.764705882 * kMm, -49.662510381 * kMm, -55 * kMm, -16 * kMm, 12 * kMm));
  zones.push_back(ProfilePiece::LowerArc(-49.662510381 * kMm, -39.764473993 * kMm, -58.558326413 * kMm,
                                         -8.834924130 * kMm, 20 * kMm));
  zones.push_back(DownwardPolynomial(-39.764473993, -38.426669071, std::array{-93.576667419, -2.747477419}));
  zones.push_back(ProfilePiece::UpperArc(-38.426669071 * kMm, -35 * kMm, -26.210665 * kMm, -16.446 * kMm, 13 * kMm));
  zones.push_back(DownwardPolynomial(-35, -26,
                                     std::array{-4.320221063e+3, -1.038384026e+3, -1.065501873e+2, -6.051367875,
                                                -2.054332446e-1, -4.169739389e-3, -4.687195829e-5, -2.252755540e-7}));
  zones.push_back(DownwardPolynomial(-26, 32.15796,
                                     std::array{0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8,
                                                -1.562379023e-8, 5.309217349e-15, -5.957839843e-12, 2.646656573e-13}));
  zones.push_back(DownwardPolynomial(32.15796, 60, std::array{1.364323640, -0.066666667}));
  const Profile closed = Profile("S1002", std::move(zones)).WithoutSteps();
  return closed.Shifted(0, -closed.Eval(0).z);
}

struct Circle {
  double u, z, radius;
};

/// Radii of both UIC60 heads; the arcs touch each other without a corner.
constexpr double kTopRadius = 300 * kMm;
constexpr double kShoulderRadius = 80 * kMm;
constexpr double kCornerRadius = 13 * kMm;
constexpr double kSideSlope = 20;          // sides 1:20 from the vertical
constexpr double kSideDepth = 38.5 * kMm;  // the head's side ends about here

/// The circle of `radius` that touches `outer` from inside where that one is at u.
Circle InnerCircle(const Circle& outer, double u, double radius) {
  const double sin = (u - outer.u) / outer.radius;
  const double along = outer.radius - radius;
  return {outer.u + along * sin, outer.z + along * std::sqrt(1 - sin * sin), radius};
}

/// A symmetric head of five arcs and two straight sides.
Profile MakeHead(std::string name, double u_top, const Circle& shoulder, const Circle& corner) {
  const double angle = std::atan(1 / kSideSlope);  // of the side, and of the last radius of the corner
  const double along = (corner.u - shoulder.u) / (shoulder.radius - corner.radius);
  const double u_shoulder = shoulder.u + shoulder.radius * along;
  const double u_corner = corner.u + corner.radius * std::cos(angle);
  const double z_corner = corner.z + corner.radius * std::sin(angle);
  const double u_side = u_corner + (z_corner + kSideDepth) / kSideSlope;
  std::vector<ProfilePiece> right{
      ProfilePiece::UpperArc(u_top, u_shoulder, shoulder.u, shoulder.z, shoulder.radius),
      ProfilePiece::UpperArc(u_shoulder, u_corner, corner.u, corner.z, corner.radius),
      ProfilePiece::Polynomial(u_corner, u_side, u_corner, std::array{z_corner, -kSideSlope})};
  std::vector<ProfilePiece> pieces;
  for (auto piece = right.rbegin(); piece != right.rend(); ++piece) pieces.push_back(piece->Mirrored());
  pieces.push_back(ProfilePiece::UpperArc(-u_top, u_top, 0, -kTopRadius, kTopRadius));
  pieces.insert(pieces.end(), right.begin(), right.end());
  return Profile(std::move(name), std::move(pieces));
}

/// The drawing with the measures 21.0 and 52.0: the corner's arc ends 36.0 mm from the axis (head 72 mm wide).
Profile MakeUic60() {
  const double u_top = 10.5 * kMm;
  const Circle shoulder = InnerCircle({0, -kTopRadius, kTopRadius}, u_top, kShoulderRadius);
  const double u = 36.0 * kMm - kCornerRadius * std::cos(std::atan(1 / kSideSlope));
  const double across = u - shoulder.u;
  const double along = kShoulderRadius - kCornerRadius;
  return MakeHead("UIC60", u_top, shoulder,
                  {u, shoulder.z + std::sqrt(along * along - across * across), kCornerRadius});
}

/// EN 13674-1: the arcs meet 20.456 / 2 and 52.053 / 2 mm from the axis.
Profile Make60E1() {
  const double u_top = 20.456 / 2 * kMm;
  const Circle shoulder = InnerCircle({0, -kTopRadius, kTopRadius}, u_top, kShoulderRadius);
  return MakeHead("60E1", u_top, shoulder, InnerCircle(shoulder, 52.053 / 2 * kMm, kCornerRadius));
}

}  // namespace

const Profile& WheelS1002() {
  static const Profile profile = MakeS1002();
  return profile;
}

const Profile& RailUic60() {
  static const Profile profile = MakeUic60();
  return profile;
}

const Profile& Rail60E1() {
  static const Profile profile = Make60E1();
  return profile;
}

const Profile* FindStandardProfile(const std::string& name) {
  for (const Profile* profile : {&WheelS1002(), &RailUic60(), &Rail60E1()}) {
    if (profile->name() == name) return profile;
  }
  return nullptr;
}

}  // namespace uiclink
