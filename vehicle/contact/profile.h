#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace uiclink {

/// A cross-section at one place.
struct ProfilePoint {
  double z = 0;       ///< height [m]
  double slope = 0;   ///< dz/dy [-]
  double second = 0;  ///< d2z/dy2 [1/m]

  /// Curvature of the curve [1/m], > 0 where its centre lies above:  z'' / (1 + z'^2)^(3/2).
  double Curvature() const;
};

/// Which limit is meant where two pieces meet: that of the piece at smaller or at greater y.
enum class JointSide { kBelow, kAbove };

/// A smooth stretch of a cross-section: a polynomial or a circular arc over [y_begin, y_end].
class ProfilePiece {
 public:
  static constexpr int kMaxDegree = 8;

  /// z = sum c_k (y - origin)^k. @param coefficients c_0, c_1, ... [m^(1-k)], at most kMaxDegree + 1.
  static ProfilePiece Polynomial(double y_begin, double y_end, double origin, std::span<const double> coefficients);
  /// Upper half of a circle (a convex rail):  z = z_centre + sqrt(R^2 - (y - y_centre)^2).
  static ProfilePiece UpperArc(double y_begin, double y_end, double y_centre, double z_centre, double radius);
  /// Lower half (the tip of a flange).
  static ProfilePiece LowerArc(double y_begin, double y_end, double y_centre, double z_centre, double radius);
  /// Quintic that takes height, slope and second derivative of both ends.
  static ProfilePiece Hermite(double y_begin, const ProfilePoint& begin, double y_end, const ProfilePoint& end);

  double y_begin() const { return y_begin_; }
  double y_end() const { return y_end_; }
  ProfilePoint Eval(double y) const;
  /// Eval(y).slope at less cost.
  double CalcSlope(double y) const;

  /// With a straight line added: `at_begin` and `at_end` [m] at its ends.
  ProfilePiece WithLine(double at_begin, double at_end) const;
  /// The same stretch between other ends. @pre y_begin() <= y_begin < y_end <= y_end().
  ProfilePiece Cut(double y_begin, double y_end) const;
  /// Mirrored at y = 0.
  ProfilePiece Mirrored() const;
  ProfilePiece Shifted(double dy, double dz) const;
  /// Turned by `angle` [rad] about the origin (from y towards z), then shifted: appended to `pieces`. Arcs and straight
  /// lines stay exact; other curves become quintics no longer than 0.5 mm that agree to second order at their ends.
  void AppendTurned(double angle, double dy, double dz, std::vector<ProfilePiece>& pieces) const;

 private:
  enum class Kind { kPolynomial, kArc };
  ProfilePiece(Kind kind, double y_begin, double y_end) : kind_(kind), y_begin_(y_begin), y_end_(y_end) {}

  Kind kind_;
  int degree_ = 0;
  double y_begin_;
  double y_end_;
  double origin_ = 0;                          ///< of the polynomial; the circle's centre
  double sign_ = 0;                            ///< arc: +1 upper half, -1 lower half
  double radius_ = 0;                          ///< arc
  double line_slope_ = 0;                      ///< arc: of a line added to it, zero at the circle's centre
  std::array<double, kMaxDegree + 1> c_ = {};  ///< polynomial; arc: c_[0] is the height of the centre
};

/// A cross-section of wheel or rail as a curve z(y) [m], z up, made of smooth pieces from the left to the right.
///
/// Wheels: y = 0 at the tape circle, positive to the field side (flange at y < 0), z = 0 at the tape circle, so the
/// rolling radius is r0 - z(y). The wheel's material lies above the curve.
/// Rails: y positive to the field side (gauge face at y < 0); their material lies below the curve.
/// Height and slope may have steps where pieces meet; the curvature usually has. Const, shared between threads.
class Profile {
 public:
  /// @throws std::invalid_argument unless each piece begins where the one before ends and is longer than nothing.
  Profile(std::string name, std::vector<ProfilePiece> pieces);

  const std::string& name() const { return name_; }
  double y_min() const { return pieces_.front().y_begin(); }
  double y_max() const { return pieces_.back().y_end(); }
  bool Contains(double y) const { return y >= y_min() && y <= y_max(); }
  const std::vector<ProfilePiece>& pieces() const { return pieces_; }

  /// @param y within [y_min, y_max]; elsewhere all members are NaN.
  /// @param side the limit taken at a joint; without meaning elsewhere.
  ProfilePoint Eval(double y, JointSide side = JointSide::kAbove) const;

  /// Eval(y).slope at less cost. @pre Contains(y).
  double CalcSlope(double y) const { return pieces_[FindPiece(y)].CalcSlope(y); }

  /// Between other ends. @throws std::invalid_argument when nothing is left.
  Profile Cut(double y_begin, double y_end) const;
  Profile Mirrored() const;
  /// Without steps in height: a piece ends half a step higher or lower, and so does the next one begin; a line over the
  /// piece takes it up. For profiles whose printed coefficients are rounded: a step of 0.1 um would else be an edge
  /// that catches the contact.
  Profile WithoutSteps() const;
  Profile Shifted(double dy, double dz) const;
  /// Turned by `angle` [rad] about the origin (from y towards z), then shifted. Ends that would become steeper than
  /// atan(kSteepest) are cut off.
  Profile Moved(double angle, double dy, double dz) const;

  static constexpr double kSteepest = 60;  ///< steepest slope kept by Moved()

 private:
  std::size_t FindPiece(double y) const;

  std::string name_;
  std::vector<ProfilePiece> pieces_;
  std::vector<std::size_t> first_piece_;  ///< by equal cells over [y_min, y_max], so that finding a piece is O(1)
  double cells_per_metre_ = 0;
};

/// Standard cross-sections (standard_profiles.cpp), in the axes above.

/// Wheel S1002 (EN 13715, e = 32.5 mm, h = 28 mm): polynomials and arcs, y from -70 to 60 mm. The steps that its
/// rounded coefficients leave (0.12 um at y = -35 mm, 0.04 um at -26 mm) are closed by WithoutSteps().
const Profile& WheelS1002();
/// Rail head UIC60, arcs 300/80/13 mm with the limits 21.0 and 52.0 mm, sides 1:20. Upright, y = 0 on its axis, top z =
/// 0.
const Profile& RailUic60();
/// Rail head 60E1 of EN 13674-1, limits 20.456 and 52.053 mm.
const Profile& Rail60E1();
/// By name: "S1002", "UIC60", "60E1"; nullptr for any other.
const Profile* FindStandardProfile(const std::string& name);

}  // namespace uiclink
