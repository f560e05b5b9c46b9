#include "vehicle/contact/contact_curve.h"

#include <limits>
#include <stdexcept>
#include <utility>

namespace uiclink {
namespace {

constexpr std::size_t kQuantities = ContactCurve::kQuantities;
using Values = std::array<double, kQuantities>;

/// One stretch of the table without jumps: rows [first, last].
struct Branch {
  std::size_t first = 0;
  std::size_t last = 0;
};

std::vector<Branch> FindBranches(std::span<const ContactRow> rows) {
  std::vector<Branch> branches{{0, 0}};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].y == rows[i - 1].y) branches.push_back({i, i});
    branches.back().last = i;
  }
  return branches;
}

Values CalcQuantities(const ContactRow& row, double shear_modulus) {
  const double area = row.a_e * row.b_e / row.q0;
  return {row.a_wheel,
          row.r,
          std::sin(row.delta),
          std::cos(row.delta),
          row.n0 / (row.q0 * std::sqrt(row.q0)),
          shear_modulus * row.c11 * area,
          shear_modulus * row.c22 * area,
          shear_modulus * row.c23 * area * std::sqrt(area)};
}

/// Slope at the middle of three points that keeps the shape (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984):
/// zero at an extremum, between the slopes of both sides elsewhere.
double CalcShapeSlope(double h0, double h1, double slope0, double slope1) {
  if (slope0 * slope1 <= 0) return 0;
  const double w0 = 2 * h1 + h0;
  const double w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / slope0 + w1 / slope1);
}

/// A quantity along one branch, continued beyond its ends by straight lines.
class ShapeSpline {
 public:
  ShapeSpline(std::vector<double> x, std::vector<double> f) : x_(std::move(x)), f_(std::move(f)), d_(x_.size(), 0.0) {
    const std::size_t n = x_.size();
    if (n < 2) return;
    const auto h = [&](std::size_t i) { return x_[i + 1] - x_[i]; };
    const auto slope = [&](std::size_t i) { return (f_[i + 1] - f_[i]) / h(i); };
    for (std::size_t i = 1; i + 1 < n; ++i) d_[i] = CalcShapeSlope(h(i - 1), h(i), slope(i - 1), slope(i));
    d_[0] = n > 2 ? EndSlope(h(0), h(1), slope(0), slope(1)) : slope(0);
    d_[n - 1] = n > 2 ? EndSlope(h(n - 2), h(n - 3), slope(n - 2), slope(n - 3)) : slope(0);
  }

  struct Point {
    double f = 0;
    double slope = 0;
  };
  Point At(double x) const {
    const std::size_t n = x_.size();
    if (x <= x_.front()) return {f_.front() + d_.front() * (x - x_.front()), d_.front()};
    if (x >= x_.back()) return {f_.back() + d_.back() * (x - x_.back()), d_.back()};
    const std::size_t i =
        std::min(static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin()) - 1, n - 2);
    const double h = x_[i + 1] - x_[i];
    const double t = (x - x_[i]) / h;
    const double a = f_[i];
    const double b = h * d_[i];
    const double e = h * d_[i + 1];
    const double c = 3 * (f_[i + 1] - a) - 2 * b - e;
    const double g = 2 * (a - f_[i + 1]) + b + e;
    return {((g * t + c) * t + b) * t + a, ((3 * g * t + 2 * c) * t + b) / h};
  }

 private:
  /// Three-point slope at an end, limited so that the shape is kept.
  static double EndSlope(double h0, double h1, double slope0, double slope1) {
    const double d = ((2 * h0 + h1) * slope0 - h0 * slope1) / (h0 + h1);
    if (d * slope0 <= 0) return 0;
    if (slope0 * slope1 <= 0 && std::abs(d) > 3 * std::abs(slope0)) return 3 * slope0;
    return d;
  }

  std::vector<double> x_, f_, d_;
};

/// The cubic of one cell from values and slopes at its ends.
template <std::size_t n>
std::array<std::array<double, n>, 4> MakeCubic(const std::array<ShapeSpline::Point, n>& left,
                                               const std::array<ShapeSpline::Point, n>& right, double width) {
  std::array<std::array<double, n>, 4> cubic{};
  for (std::size_t i = 0; i < n; ++i) {
    const double b = width * left[i].slope;
    const double e = width * right[i].slope;
    cubic[0][i] = left[i].f;
    cubic[1][i] = b;
    cubic[2][i] = 3 * (right[i].f - left[i].f) - 2 * b - e;
    cubic[3][i] = 2 * (left[i].f - right[i].f) + b + e;
  }
  return cubic;
}

/// The splines of the quantities along one branch.
class BranchCurves {
 public:
  BranchCurves(std::span<const ContactRow> rows, double shear_modulus) {
    std::vector<double> y;
    std::vector<Values> values;
    for (const ContactRow& row : rows) {
      y.push_back(row.y);
      values.push_back(CalcQuantities(row, shear_modulus));
    }
    for (std::size_t i = 0; i < kQuantities; ++i) {
      std::vector<double> f;
      for (const Values& v : values) f.push_back(v[i]);
      quantities_.emplace_back(y, std::move(f));
    }
  }

  ContactCurve::Cubic Quantities(double left, double right) const {
    std::array<ShapeSpline::Point, kQuantities> at_left, at_right;
    for (std::size_t i = 0; i < kQuantities; ++i) {
      at_left[i] = quantities_[i].At(left);
      at_right[i] = quantities_[i].At(right);
    }
    return MakeCubic(at_left, at_right, right - left);
  }

 private:
  std::vector<ShapeSpline> quantities_;
};

/// Height and roll of the wheelset over y. Both are continuous, with a kink wherever one of the wheels changes its
/// contact: at the jumps of the table and at their mirror images, where the other wheel jumps.
class PoseCurves {
 public:
  /// @param near  rows closer than this are one [m].
  PoseCurves(std::span<const ContactRow> rows, double near) : near_(near) {
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      poses.push_back({rows[i].y, rows[i].z_lift, rows[i].phi_roll});
      poses.push_back({-rows[i].y, rows[i].z_lift, -rows[i].phi_roll});
      if (i == 0 || rows[i].y != rows[i - 1].y) continue;
      kinks_.push_back(rows[i].y);
      kinks_.push_back(-rows[i].y);
    }
    std::ranges::sort(kinks_);
    std::ranges::sort(poses, {}, &Pose::y);
    Merge(&poses, near);
    std::size_t first = 0;
    for (std::size_t k = 0; k <= kinks_.size(); ++k) {
      std::size_t last = first;
      while (last + 1 < poses.size() && (k == kinks_.size() || poses[last].y < kinks_[k] - near)) ++last;
      Append({poses.data() + first, last - first + 1});
      first = last;
    }
  }

  /// Values and slopes at both ends of a cell.
  ContactCurve::PoseCubic Cell(double left, double right) const {
    return MakeCubic(At(left, false), At(right, true), right - left);
  }

 private:
  struct Pose {
    double y, z, phi;
  };

  /// One pose for all that are near each other: their mean.
  static void Merge(std::vector<Pose>* poses, double near) {
    std::vector<Pose> merged;
    for (std::size_t i = 0; i < poses->size();) {
      Pose sum{0, 0, 0};
      double n = 0;
      for (const double y = (*poses)[i].y; i < poses->size() && (*poses)[i].y <= y + near; ++i, ++n) {
        sum.y += (*poses)[i].y;
        sum.z += (*poses)[i].z;
        sum.phi += (*poses)[i].phi;
      }
      merged.push_back({sum.y / n, sum.z / n, sum.phi / n});
    }
    *poses = std::move(merged);
  }

  void Append(std::span<const Pose> poses) {
    std::vector<double> y, z, phi;
    for (const Pose& pose : poses) {
      y.push_back(pose.y);
      z.push_back(pose.z);
      phi.push_back(pose.phi);
    }
    z_.emplace_back(y, std::move(z));
    phi_.emplace_back(y, std::move(phi));
  }

  /// The stretch between kinks that ends at y or goes on there (`from_left`), or else that begins there or has begun. A
  /// kink within a cell so lies between the two stretches of its ends; one at the end of a cell, up to rounding, is
  /// passed by the next.
  std::array<ShapeSpline::Point, 2> At(double y, bool from_left) const {
    const auto kink =
        from_left ? std::ranges::lower_bound(kinks_, y - near_) : std::ranges::upper_bound(kinks_, y + near_);
    const auto piece = static_cast<std::size_t>(kink - kinks_.begin());
    return {z_[piece].At(y), phi_[piece].At(y)};
  }

  double near_;
  std::vector<double> kinks_;
  std::vector<ShapeSpline> z_, phi_;  ///< between the kinks
};

/// The least distance of rows [m], those that jumps add between them left aside unless there are no others.
double FindRowDistance(std::span<const ContactRow> rows) {
  const auto jumps = [&](std::size_t i) {
    return (i > 0 && rows[i].y == rows[i - 1].y) || (i + 1 < rows.size() && rows[i].y == rows[i + 1].y);
  };
  double least = std::numeric_limits<double>::infinity(), least_of_all = least;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double distance = rows[i].y - rows[i - 1].y;
    if (distance > 0) least_of_all = std::min(least_of_all, distance);
    if (!jumps(i - 1) && !jumps(i)) least = std::min(least, distance);
  }
  return std::isfinite(least) ? least : least_of_all;
}

/// How many cells a table gets: those of its least row distance. A user's table may have rows that nearly coincide;
/// it gets no more than so many cells a row.
std::size_t CountCells(std::span<const ContactRow> rows) {
  constexpr double kMostCellsPerRow = 20;  // 256 bytes each
  const double length = rows.back().y - rows.front().y;
  const double distance = FindRowDistance(rows);
  const double most = kMostCellsPerRow * static_cast<double>(rows.size());
  return static_cast<std::size_t>(std::clamp(std::round(length / distance), 1.0, most));
}

std::vector<BranchCurves> MakeCurves(std::span<const ContactRow> rows, const std::vector<Branch>& branches,
                                     double shear_modulus) {
  std::vector<BranchCurves> curves;
  for (const Branch& branch : branches)
    curves.emplace_back(rows.subspan(branch.first, branch.last - branch.first + 1), shear_modulus);
  return curves;
}

}  // namespace

ContactCurve::ContactCurve(const ContactTable& table) {
  const std::span<const ContactRow> rows = table.rows;
  if (rows.empty() || !(rows.front().y < rows.back().y))
    throw std::invalid_argument("a contact table needs rows by increasing y");
  const std::size_t cells = CountCells(rows);
  r0_ = table.r0;
  y_min_ = rows.front().y;
  width_ = (rows.back().y - rows.front().y) / static_cast<double>(cells);
  per_width_ = 1 / width_;
  last_ = std::nextafter(static_cast<double>(cells), 0.0);
  MakeCells(rows, cells, table.shear_modulus);
  MakeStaticQuantities(rows);
}

void ContactCurve::MakeCells(std::span<const ContactRow> rows, std::size_t cells, double shear_modulus) {
  const std::vector<Branch> branches = FindBranches(rows);
  const std::vector<BranchCurves> curves = MakeCurves(rows, branches, shear_modulus);
  const PoseCurves poses(rows, 1e-6 * width_);

  cells_.resize(cells);
  poses_.resize(cells);
  after_.assign(cells, -1);
  std::size_t at_left = 0;  // the branch at the left end of the cell; a jump exactly there is behind it
  for (std::size_t i = 0; i < cells; ++i) {
    const double left = y_min_ + static_cast<double>(i) * width_;
    const double right = i + 1 < cells ? y_min_ + static_cast<double>(i + 1) * width_ : rows.back().y;
    // A cell's ends are rows up to rounding: a jump there belongs to the cell before.
    const double reach = right + 1e-9 * width_;
    std::size_t at_right = at_left;
    while (at_right + 1 < branches.size() && rows[branches[at_right + 1].first].y <= reach) ++at_right;
    cells_[i] = curves[at_left].Quantities(left, right);
    if (at_right != at_left) {
      after_[i] = static_cast<int>(jumps_.size());
      jumps_.push_back(curves[at_right].Quantities(left, right));
    }
    poses_[i] = poses.Cell(left, right);
    at_left = at_right;
  }
}

void ContactCurve::MakeStaticQuantities(std::span<const ContactRow> rows) {
  std::vector<double> y, q0, a_rail;
  for (const ContactRow& row : rows) {
    if (!y.empty() && row.y == y.back()) continue;
    y.push_back(row.y);
    q0.push_back(row.q0);
    a_rail.push_back(row.a_rail);
  }
  const ShapeSpline approach(y, q0), rail(y, a_rail);
  for (std::size_t i = 0; i <= cells_.size(); ++i) {
    const double at = y_min_ + static_cast<double>(i) * width_;
    static_approach_.push_back(approach.At(at).f);
    rail_distance_.push_back(rail.At(at).f);
  }
}

}  // namespace uiclink
