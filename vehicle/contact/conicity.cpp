#include "vehicle/contact/conicity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace uiclink {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSameDisplacement = 1e-13;  // [m] between a turning point and a point of the polygon
constexpr double kNoDifference = 1e-9;  // [m] of delta_r: a restoring force below is the rounding of the contact search

/// The potential  W(y) = integral from the first point to y of delta_r dy'  of the polygon; piecewise quadratic,
/// continuous.
class Potential {
 public:
  explicit Potential(const RollingRadiusDifference& d) : y_(d.y), delta_r_(d.delta_r), w_(d.y.size(), 0.0) {
    if (y_.size() != delta_r_.size() || y_.size() < 2 || !std::is_sorted(y_.begin(), y_.end())) {
      throw std::invalid_argument("rolling radius difference: at least two points by increasing y");
    }
    for (std::size_t i = 1; i < y_.size(); ++i) {
      w_[i] = w_[i - 1] + 0.5 * (y_[i] - y_[i - 1]) * (delta_r_[i] + delta_r_[i - 1]);
    }
  }

  double y_min() const { return y_.front(); }
  double y_max() const { return y_.back(); }

  double Eval(double y) const {
    const std::size_t i = FindSegment(y);
    const double u = y - y_[i];
    return w_[i] + u * (delta_r_[i] + 0.5 * u * Slope(i));
  }

  double Rise(double from, double to) const { return Eval(to) - Eval(from); }

  /// Where delta_r rises through zero (or jumps over it), nearest to y = 0. Where it vanishes over a stretch: the point
  /// of the stretch nearest to 0. NaN if nowhere.
  double FindEquilibrium() const {
    double nearest = kNan;
    for (std::size_t i = 0; i + 1 < y_.size(); ++i) {
      if (delta_r_[i] > kNoDifference || delta_r_[i + 1] < -kNoDifference) continue;
      const double low = ZeroAfter(i, -kNoDifference);
      const double high = ZeroAfter(i, kNoDifference);
      const double root = delta_r_[i] < 0 && delta_r_[i + 1] > 0 ? ZeroAfter(i, 0) : std::clamp(0.0, low, high);
      if (!(std::abs(root) >= std::abs(nearest))) nearest = root;
    }
    return nearest;
  }

  /// integral from y_low to y_high of dy / sqrt(W_end - W(y)), W_end >= W. NaN where the motion is turned back inside.
  double IntegratePassage(double y_low, double y_high, double w_end) const {
    const double rounding = 1e-12 * std::abs(*std::min_element(w_.begin(), w_.end()));
    double sum = 0;
    std::size_t i = FindSegment(y_low);
    for (double y = y_low; y < y_high;) {
      while (i + 2 < y_.size() && y_[i + 1] - y < kSameDisplacement) ++i;
      const double next = y_high - y_[i + 1] < kSameDisplacement ? y_high : y_[i + 1];
      const double s_begin = y == y_low ? 0 : w_end - Eval(y);
      const double s_end = next == y_high ? 0 : w_end - Eval(next);
      if (std::min(s_begin, s_end) < -rounding) return kNan;
      sum += IntegrateSegment(next - y, std::max(s_begin, 0.0), std::max(s_end, 0.0), -0.5 * Slope(i));
      y = next;
    }
    return sum;
  }

 private:
  std::size_t FindSegment(double y) const {
    const auto after = std::upper_bound(y_.begin() + 1, y_.end() - 1, y);
    return static_cast<std::size_t>(after - y_.begin()) - 1;
  }
  double Slope(std::size_t i) const {
    const double h = y_[i + 1] - y_[i];
    return h > 0 ? (delta_r_[i + 1] - delta_r_[i]) / h : 0;
  }
  /// Where a segment that does not fall has the value, or its nearer end.
  double ZeroAfter(std::size_t i, double value) const {
    const double rise = delta_r_[i + 1] - delta_r_[i];
    const double share = rise > 0 ? std::clamp((value - delta_r_[i]) / rise, 0.0, 1.0) : (value < 0 ? 0.0 : 1.0);
    return y_[i] + share * (y_[i + 1] - y_[i]);
  }
  /// integral_0^h du / sqrt(S), S = S_begin + ... + curvature u^2 with S(h) = S_end: closed form for any quadratic.
  static double IntegrateSegment(double h, double s_begin, double s_end, double curvature) {
    const double roots = std::sqrt(s_begin) + std::sqrt(s_end);
    const double root = std::sqrt(std::abs(curvature));
    if (root * h < 1e-5 * roots) return 2 * h / roots * (1 + curvature * h * h / (3 * roots * roots));
    if (curvature < 0) return 2 / root * std::atan2(root * h, roots);
    return 2 / root * std::atanh(root * h / roots);
  }

  const std::vector<double>& y_;
  const std::vector<double>& delta_r_;
  std::vector<double> w_;
};

/// Zero of a function that grows, in [low, high]; NaN where it has none.
double FindZero(const std::function<double(double)>& value, double low, double high) {
  if (!(low <= high) || value(low) > 0 || value(high) < 0) return kNan;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (value(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// integrals of delta_r(y_c + A sin t) and of delta_r(...) sin t over -pi/2 < t < pi/2, exact for the polygon.
struct Harmonics {
  double mean = 0;
  double sine = 0;
};

Harmonics IntegrateHarmonics(const RollingRadiusDifference& d, double centre, double amplitude) {
  Harmonics sum;
  const auto angle = [&](double y) { return std::asin(std::clamp((y - centre) / amplitude, -1.0, 1.0)); };
  for (std::size_t i = 0; i + 1 < d.y.size(); ++i) {
    const double h = d.y[i + 1] - d.y[i];
    if (h <= 0 || d.y[i + 1] <= centre - amplitude || d.y[i] >= centre + amplitude) continue;
    const double from = angle(d.y[i]);
    const double to = angle(d.y[i + 1]);
    const double slope = (d.delta_r[i + 1] - d.delta_r[i]) / h;
    const double constant = d.delta_r[i] + slope * (centre - d.y[i]);
    const double cosines = std::cos(from) - std::cos(to);                                       // of sin t
    const double squares = 0.5 * (to - from) - 0.25 * (std::sin(2 * to) - std::sin(2 * from));  // of sin^2 t
    sum.mean += constant * (to - from) + slope * amplitude * cosines;
    sum.sine += constant * cosines + slope * amplitude * squares;
  }
  return sum;
}

}  // namespace

RollingRadiusDifference CalcRollingRadiusDifference(const WheelsetOnRails& wheelset, double y_max, double step,
                                                    const ContactSearchOptions& options) {
  if (!(y_max > 0) || !(step > 0)) throw std::invalid_argument("rolling radius difference: y_max, step > 0");
  std::vector<Jump> jumps = FindJumps(wheelset, -y_max, y_max, options);
  RollingRadiusDifference d;
  const auto add = [&](double y, double delta_r) {
    d.y.push_back(y);
    d.delta_r.push_back(delta_r);
  };
  std::size_t next_jump = 0;
  double phi = 0;
  const int steps = std::max(2, static_cast<int>(std::lround(2 * y_max / step)));
  for (int i = 0; i <= steps; ++i) {
    const double y = y_max * (2.0 * i / steps - 1);
    for (; next_jump < jumps.size() && jumps[next_jump].y <= y; ++next_jump) {
      const Jump& jump = jumps[next_jump];
      const KinematicContact tie = FindKinematicContact(wheelset, jump.y, options, jump.phi_roll);
      const bool left = jump.side == WheelSide::kLeft;
      const double other = left ? tie.right[0].r : tie.left[0].r;
      add(jump.y, left ? jump.before.r - other : other - jump.before.r);
      add(jump.y, left ? jump.after.r - other : other - jump.after.r);
    }
    const KinematicContact contact = FindKinematicContact(wheelset, y, options, phi);
    phi = contact.phi_roll;
    if (d.y.empty() || y > d.y.back()) add(y, contact.left[0].r - contact.right[0].r);
  }
  return d;
}

double CalcEquivalentConicity(const RollingRadiusDifference& difference, double amplitude) {
  const Potential potential(difference);
  const double y_0 = potential.FindEquilibrium();
  if (!(amplitude > 0) || std::isnan(y_0)) return kNan;
  const double flat = kNoDifference * amplitude;
  if (potential.Rise(y_0, y_0 - amplitude) <= flat && potential.Rise(y_0, y_0 + amplitude) <= flat) return 0;
  const double low = std::max(y_0, potential.y_min() + 2 * amplitude);
  const double high = std::min(y_0 + 2 * amplitude, potential.y_max());
  const double y_high =
      FindZero([&](double y) { return potential.Eval(y) - potential.Eval(y - 2 * amplitude); }, low, high);
  if (std::isnan(y_high)) return kNan;
  const double y_low = y_high - 2 * amplitude;
  const double w_end = std::max(potential.Eval(y_high), potential.Eval(y_low));
  // Half a wavelength is the integral of dy/y' with y'^2 = 2 (W_end - W)/(e r0).
  const double passage = potential.IntegratePassage(y_low, y_high, w_end);
  return std::numbers::pi * std::numbers::pi / (passage * passage);
}

double CalcHarmonicConicity(const RollingRadiusDifference& difference, double amplitude) {
  const Potential potential(difference);
  const double y_0 = potential.FindEquilibrium();
  if (!(amplitude > 0) || std::isnan(y_0)) return kNan;
  const double low = std::max(y_0 - amplitude, potential.y_min() + amplitude);
  const double high = std::min(y_0 + amplitude, potential.y_max() - amplitude);
  const auto mean = [&](double centre) { return IntegrateHarmonics(difference, centre, amplitude).mean; };
  const double centre = FindZero(mean, low, high);
  if (std::isnan(centre)) return kNan;
  return IntegrateHarmonics(difference, centre, amplitude).sine / (std::numbers::pi * amplitude);
}

}  // namespace uiclink
