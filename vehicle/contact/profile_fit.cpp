#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "vehicle/contact/profile_file.h"

namespace uiclink {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Index = Eigen::Index;

constexpr double kClosestKnots = 0.25e-3;  // [m] a quintic over it strays from the splines by 10 nm where R 13 begins
constexpr double kSmoothEnough = 1e-6;     // [m] standard deviation from which on 10 nm are nothing
constexpr double kSteepestFit = 20;        // ends where z(y) would be steeper are left out

/// Natural cubic splines through or near several columns of values over the same knots (Green and Silverman 1994,
/// section 2.3):  second derivatives  (R + lambda Q^T Q) gamma = Q^T values,  fitted  values - lambda Q gamma.
class SmoothingSpline {
 public:
  SmoothingSpline(std::vector<double> knots, Eigen::MatrixX2d values)
      : t_(std::move(knots)), values_(std::move(values)) {
    const Index n = values_.rows();
    std::vector<Eigen::Triplet<double>> q;
    std::vector<Eigen::Triplet<double>> r;
    for (Index j = 0; j < n - 2; ++j) {
      const double before = Width(j);
      const double after = Width(j + 1);
      q.emplace_back(j, j, 1 / before);
      q.emplace_back(j + 1, j, -1 / before - 1 / after);
      q.emplace_back(j + 2, j, 1 / after);
      r.emplace_back(j, j, (before + after) / 3);
      if (j + 1 < n - 2) {
        r.emplace_back(j, j + 1, after / 6);
        r.emplace_back(j + 1, j, after / 6);
      }
    }
    q_ = SparseMatrix(n, n - 2);
    r_ = SparseMatrix(n - 2, n - 2);
    q_.setFromTriplets(q.begin(), q.end());
    r_.setFromTriplets(r.begin(), r.end());
    qtq_ = q_.transpose() * q_;
    solver_.analyzePattern(SparseMatrix(r_ + qtq_));
    Solve(0);
  }

  /// Makes the mean square distance from the values sigma^2: it grows with lambda.
  void Smooth(double sigma) {
    double low = -60;  // ln of lambda [mm^3]
    double high = 60;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      Solve(std::exp(middle));
      (MeanSquare() < sigma * sigma ? low : high) = middle;
    }
  }

  Index size() const { return values_.rows(); }

  /// Value, first and second derivative of a column at a knot.
  struct Derivatives {
    double value, first, second;
  };
  Derivatives At(Index knot, Index column) const {
    const bool last = knot + 1 == size();
    const Index i = last ? knot - 1 : knot;
    const double h = Width(i);
    const double chord = (fitted_(i + 1, column) - fitted_(i, column)) / h;
    const double bend =
        last ? Second(i, column) + 2 * Second(i + 1, column) : -2 * Second(i, column) - Second(i + 1, column);
    return {fitted_(knot, column), chord + h / 6 * bend, Second(knot, column)};
  }

 private:
  double Width(Index i) const { return t_[static_cast<std::size_t>(i) + 1] - t_[static_cast<std::size_t>(i)]; }
  double Second(Index i, Index column) const { return i == 0 || i + 1 == size() ? 0.0 : gamma_(i - 1, column); }
  double MeanSquare() const { return (values_ - fitted_).squaredNorm() / static_cast<double>(size()); }

  void Solve(double lambda) {
    solver_.factorize(SparseMatrix(r_ + lambda * qtq_));
    if (solver_.info() != Eigen::Success) throw std::invalid_argument("smoothing spline: the points are too close");
    const Eigen::MatrixX2d bends = q_.transpose() * values_;
    gamma_ = solver_.solve(bends);
    fitted_ = values_ - lambda * (q_ * gamma_);
  }

  std::vector<double> t_;
  Eigen::MatrixX2d values_;
  SparseMatrix q_, r_, qtq_;
  Eigen::SimplicialLDLT<SparseMatrix> solver_;
  Eigen::MatrixX2d gamma_;
  Eigen::MatrixX2d fitted_;
};

constexpr double kMetre = 1000;  // millimetres inside: R and Q^T Q are then of one size

SmoothingSpline MakeSpline(const ProfilePoints& points) {
  std::vector<double> t{0.0};
  Eigen::MatrixX2d values(static_cast<Index>(points.size()), 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [y, z] = points[i];
    values.row(static_cast<Index>(i)) << kMetre * y, kMetre * z;
    if (i > 0) t.push_back(t.back() + kMetre * std::hypot(y - points[i - 1].first, z - points[i - 1].second));
  }
  return SmoothingSpline(std::move(t), std::move(values));
}

struct Knot {
  double y = 0;
  double dy_dt = 0;
  ProfilePoint point;
};

/// z(y) at a knot, from y(t) and z(t).
Knot MakeKnot(const SmoothingSpline& spline, Index i) {
  const auto y = spline.At(i, 0);
  const auto z = spline.At(i, 1);
  return {y.value / kMetre,
          y.first,
          {.z = z.value / kMetre,
           .slope = z.first / y.first,
           .second = kMetre * (z.second * y.first - z.first * y.second) / (y.first * y.first * y.first)}};
}

/// Measured points are often closer than a smoothed curve needs, and every piece costs time in the contact search.
std::vector<Knot> ThinOut(const std::vector<Knot>& knots) {
  std::vector<Knot> kept{knots.front()};
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    const Knot& last = kept.back();
    const double length = std::hypot(knots[i].y - last.y, knots[i].point.z - last.point.z);
    if (length >= kClosestKnots) kept.push_back(knots[i]);
  }
  kept.push_back(knots.back());
  return kept;
}

}  // namespace

Profile FitProfile(std::string name, const ProfilePoints& points, double sigma) {
  if (points.size() < 4 || !(sigma >= 0))
    throw std::invalid_argument("profile " + name + ": at least 4 points, sigma >= 0");
  SmoothingSpline spline = MakeSpline(points);
  if (sigma > 0) spline.Smooth(kMetre * sigma);

  std::vector<Knot> knots;
  for (Index i = 0; i < spline.size(); ++i) knots.push_back(MakeKnot(spline, i));
  const auto usable = [](const Knot& knot) { return knot.dy_dt > 0 && std::abs(knot.point.slope) < kSteepestFit; };
  const auto middle = knots.begin() + static_cast<std::ptrdiff_t>(knots.size() / 2);
  const auto end = std::find_if_not(middle, knots.end(), usable);
  const auto begin = std::find_if_not(std::make_reverse_iterator(middle), knots.rend(), usable).base();
  if (end - begin < 4) throw std::invalid_argument("profile " + name + ": too steep everywhere");

  std::vector<Knot> used(begin, end);
  if (sigma >= kSmoothEnough) used = ThinOut(used);
  std::vector<ProfilePiece> pieces;
  for (auto knot = used.begin(); knot + 1 != used.end(); ++knot) {
    pieces.push_back(ProfilePiece::Hermite(knot->y, knot->point, (knot + 1)->y, (knot + 1)->point));
  }
  return Profile(std::move(name), std::move(pieces));
}

}  // namespace uiclink
