#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "model/scalar.h"
#include "vehicle/contact/contact_table.h"

namespace uiclink {

/// What the motion needs of the left wheel's contact, as functions of the lateral displacement y of the wheelset.  The
/// forces follow from the approach q [m] of wheel and rail beyond touching (Hertz: N ~ q^1.5, a_e b_e ~ q):
///   N = n q^1.5,   Kalker: -F_x = f11 q xi_x,   -F_y = f22 q xi_y + f23 q^1.5 xi_s.
template <typename T>
struct WheelContact {
  T a{};          ///< lateral distance of the contact point from the wheelset's centre [m]
  T r{};          ///< rolling radius [m]
  T sin_delta{};  ///< of the contact angle, wheelset frame
  T cos_delta{};
  T n{};    ///< n0 / q0^1.5 [N/m^1.5]
  T f11{};  ///< G c11 a_e b_e / q0 [N/m]
  T f22{};  ///< G c22 a_e b_e / q0 [N/m]
  T f23{};  ///< G c23 (a_e b_e / q0)^1.5 [N/m^0.5]
};

/// Where the wheelset stands when both wheels just touch.
template <typename T>
struct KinematicPose {
  T z{};    ///< height of its centre above r0 over the rail tops [m]
  T phi{};  ///< roll [rad]
};

/// A contact table between its rows: cubic polynomials on equal cells, shape-preserving (no overshoot where the
/// curvature of a profile steps) and with a continuous slope wherever the contact does not jump.  A cell is as wide as
/// the closest rows are apart; a table of equal distances has a row at each end of a cell, but for those of its jumps.
///
/// Height and roll of the wheelset are made symmetric: it stands the same displaced to the left and to the right. Where
/// the table reaches further to one side, they come from that side alone.
///
/// A cell in which the contact jumps has both contacts, before and after; over the width of the cell the load goes over
/// from the one to the other.  A contact point between the two is never invented.  Of several jumps in one cell the
/// first "before" and the last "after" count.
class ContactCurve {
 public:
  static constexpr std::size_t kQuantities = 8;                  ///< members of WheelContact, in that order
  using Cubic = std::array<std::array<double, kQuantities>, 4>;  ///< coefficients of 1, t, t^2, t^3, 0 <= t <= 1
  using PoseCubic = std::array<std::array<double, 2>, 4>;

  ContactCurve() = default;
  /// @throws std::invalid_argument unless the table has rows at two displacements at least.
  explicit ContactCurve(const ContactTable& table);

  double y_min() const { return y_min_; }
  double y_max() const { return y_min_ + static_cast<double>(cells_.size()) * width_; }
  double r0() const { return r0_; }
  std::size_t cells() const { return cells_.size(); }
  double width() const { return width_; }

  /// The cell of a displacement; those beyond the table belong to its first or last cell, one that is no number to the
  /// first.
  struct Place {
    std::size_t cell = 0;
    double t = 0;
  };
  Place Find(double y) const {
    const double s = std::min(std::max(0.0, (y - y_min_) * per_width_), last_);  // in this order: 0 for NaN
    const auto cell = static_cast<std::size_t>(s);
    return {cell, s - static_cast<double>(cell)};
  }

  const Cubic& cubic(std::size_t cell) const { return cells_[cell]; }
  const PoseCubic& pose_cubic(std::size_t cell) const { return poses_[cell]; }
  /// Where the contact jumps: the one after the jump. Null elsewhere.
  const Cubic* after_jump(std::size_t cell) const {
    return after_[cell] < 0 ? nullptr : &jumps_[static_cast<std::size_t>(after_[cell])];
  }
  /// Share of the load on the contact after the jump: 0 to 1 over the cell, with zero slope at both ends.
  template <typename T>
  static T ShareAfter(const T& t) {
    return t * t * (3.0 - 2.0 * t);
  }

  template <typename T>
  static WheelContact<T> Evaluate(const Cubic& c, const T& t) {
    std::array<T, kQuantities> q;
    for (std::size_t i = 0; i < kQuantities; ++i) q[i] = ((c[3][i] * t + c[2][i]) * t + c[1][i]) * t + c[0][i];
    return {q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7]};
  }
  template <typename T>
  static KinematicPose<T> Evaluate(const PoseCubic& c, const T& t) {
    return {((c[3][0] * t + c[2][0]) * t + c[1][0]) * t + c[0][0],
            ((c[3][1] * t + c[2][1]) * t + c[1][1]) * t + c[0][1]};
  }
  /// The place in its cell as a scalar with derivatives; beyond the table nothing changes with y any more.
  template <typename T>
  T Local(const T& y, const Place& place) const {
    if (Value(y) < y_min() || Value(y) > y_max()) return T(place.t);
    T t = (y - y_min_) * per_width_ - static_cast<double>(place.cell);
    SetValue(t, place.t);
    return t;
  }

  /// q0 of the table at y [m]: what the printed form of the penetration starts from. Linear within a cell; in one with
  /// a jump from the one before it to the one after it.
  template <typename T>
  T CalcStaticApproach(const T& y) const {
    return Interpolate(static_approach_, y);
  }
  /// a_rail of the table at y [m], in the same way.
  template <typename T>
  T CalcRailDistance(const T& y) const {
    return Interpolate(rail_distance_, y);
  }

 private:
  template <typename T>
  T Interpolate(const std::vector<double>& f, const T& y) const {
    const Place p = Find(Value(y));
    return f[p.cell] + Local(y, p) * (f[p.cell + 1] - f[p.cell]);
  }

  void MakeCells(std::span<const ContactRow> rows, std::size_t cells, double shear_modulus);
  void MakeStaticQuantities(std::span<const ContactRow> rows);

  double y_min_ = 0;
  double width_ = 1;      ///< of a cell [m]
  double per_width_ = 1;  ///< 1/width
  double last_ = 0;       ///< largest place: just inside the last cell
  double r0_ = 0;
  std::vector<Cubic> cells_;
  std::vector<PoseCubic> poses_;
  std::vector<Cubic> jumps_;
  std::vector<int> after_;  ///< by cell: index into jumps_, or -1
  std::vector<double> static_approach_;
  std::vector<double> rail_distance_;
};

}  // namespace uiclink
