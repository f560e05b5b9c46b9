#include "identify/digitise/line_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/digitise/arc_band.h"
#include "identify/digitise/banded.h"

namespace uiclink::digitise {
namespace {

constexpr double kRobust = 0.20;    // difference of shares at which a pixel counts half, in the end
constexpr double kFloor = 0.06;     // what no noise of the pixels shows: rendering, frame, paper [px]
constexpr double kFarSearch = 2.8;  // across the line for its ink, before the fit is close [px]
constexpr int kIterations = 14;

/// The foot of a pixel on the curve near an arc step.
struct Foot {
  double x = 0;
  double s = 0;         ///< signed distance of the curve from the pixel along the curve's normal [px]
  double normal_x = 0;  ///< unit normal, downwards
  double normal_y = 0;
  UniformSpline::Basis basis;
};

Foot FindFoot(const UniformSpline& curve, const ArcStep& step, int px, int py) {
  // Along the tangent of the step to the foot, then the distance to the curve's own tangent there.
  const double c = 1 / std::hypot(1.0, step.slope);
  const double along = ((px - step.x) + (py - step.y) * step.slope) * c;
  Foot foot;
  foot.x = std::clamp(step.x + along * c, std::max(curve.first(), step.x - 1.0), std::min(curve.last(), step.x + 1.0));
  foot.basis = curve.At(foot.x);
  const double y = curve.Value(foot.basis), slope = curve.Slope(foot.basis);
  foot.normal_y = 1 / std::hypot(1.0, slope);
  foot.normal_x = -slope * foot.normal_y;
  foot.s = (foot.x - px) * foot.normal_x + (y - py) * foot.normal_y;
  return foot;
}

class Fitter {
 public:
  Fitter(const InkLayer& layer, const Inks& inks, const Trace& trace, const std::vector<double>& start, double spacing)
      : layer_(layer), inks_(inks), band_(trace, inks, start, 7 + 2 * HalfWidth(trace, layer)) {
    fit_.curve = UniformSpline(inks.x0, inks.x1, spacing);
    fit_.profile = {1, 2 * HalfWidth(trace, layer), 0.5};
    StartFrom(start);
  }

  LineFit Run() {
    noise_ = 0.1;
    for (int i = 0; i < kIterations; ++i) {
      Draw();
      FindDashes(i < 5 ? kFarSearch : 0);
      if (i >= 2 && i < kIterations - 2) fit_.profile = FitProfile(CollectProfile(), fit_.profile);
      robust_ = std::max(kRobust, 0.8 * std::pow(0.75, i));
      if (!Step(i < 2 ? 3.0 : 1.0) && i >= 8) break;
    }
    Draw();
    Finish();
    return std::move(fit_);
  }

 private:
  /// Least squares of the spline through the start, with just enough smoothing to be solvable.
  void StartFrom(const std::vector<double>& start) {
    UniformSpline& curve = fit_.curve;
    BandedEquations equations(curve.coefficients.size(), 4);
    for (std::size_t i = 0; i < start.size(); ++i) {
      const UniformSpline::Basis basis = curve.At(inks_.x0 + double(i));
      for (std::size_t a = 0; a < 4; ++a) {
        equations.AddRight(basis.first + a, basis.value[a] * start[i]);
        for (std::size_t b = 0; b <= a; ++b)
          equations.Add(basis.first + a, basis.first + b, basis.value[a] * basis.value[b]);
      }
    }
    AddSmoothing(std::vector<double>(curve.coefficients.size(), 1e-3), &equations);
    if (equations.Factor()) curve.coefficients = equations.Solve();
  }

  void Draw() {
    fit_.arc = Walk(fit_.curve);
    Splat(fit_.arc, fit_.profile.Reach(), &band_);
  }

  /// Precision of the fourth difference at each coefficient: the curve's own, twice its rms over 31 coefficients.
  std::vector<double> Smoothness() const {
    const std::vector<double>& c = fit_.curve.coefficients;
    std::vector<double> square(c.size()), precision(c.size());
    for (std::size_t i = 2; i + 2 < c.size(); ++i) {
      const double fourth = c[i - 2] - 4 * c[i - 1] + 6 * c[i] - 4 * c[i + 1] + c[i + 2];
      square[i] = fourth * fourth;
    }
    for (std::size_t i = 2; i + 2 < c.size(); ++i) {
      double sum = 0, count = 0;
      for (std::size_t k = i > 17 ? i - 15 : 2; k < std::min(c.size() - 2, i + 16); ++k) sum += square[k], count += 1;
      precision[i] = 1 / (4 * sum / count + 0.04);
    }
    return precision;
  }

  static void AddSmoothing(const std::vector<double>& precision, BandedEquations* equations) {
    constexpr std::array<double, 5> kFourth{1, -4, 6, -4, 1};
    for (std::size_t i = 2; i + 2 < precision.size(); ++i)
      for (std::size_t a = 0; a < 5; ++a)
        for (std::size_t b = 0; b <= a; ++b)
          equations->Add(i - 2 + a, i - 2 + b, precision[i] * kFourth[a] * kFourth[b]);
  }

  bool IsUsable(const Cell& cell) const {
    const auto drawn = [&](int step) {
      return step < 0 || usable_.empty() || usable_[std::min(std::size_t(step), usable_.size() - 1)];
    };
    return cell.step1 >= 0 && drawn(cell.step1) && (std::sqrt(cell.d2) > fit_.profile.Reach() || drawn(cell.step2));
  }

  /// What is drawn at a pixel and how it moves with the curve.
  struct Drawn {
    Foot first;
    std::optional<Foot> second;
    Shade shade;
    double second_sign = 1;
  };

  Drawn DrawPixel(int x, int y, const Cell& cell) const {
    Drawn drawn{FindFoot(fit_.curve, fit_.arc[std::size_t(cell.step1)], x, y), {}, {}};
    if (cell.step2 < 0 || std::sqrt(cell.d2) > fit_.profile.Reach()) {
      drawn.shade = ShadeOf(fit_.profile, drawn.first.s);
      return drawn;
    }
    drawn.second = FindFoot(fit_.curve, fit_.arc[std::size_t(cell.step2)], x, y);
    const Foot& a = drawn.first;
    const Foot& b = *drawn.second;
    drawn.second_sign = a.normal_x * b.normal_x + a.normal_y * b.normal_y >= 0 ? 1 : -1;
    drawn.shade = ShadeOf(fit_.profile, a.s, drawn.second_sign * b.s);
    return drawn;
  }

  template <typename Use>
  void ForEachPixel(Use use) {
    const double reach = fit_.profile.Reach();
    band_.ForEach([&](int x, int y, const Cell& cell) {
      const double known = layer_.weight.At(x, y);
      if (known <= 0 || std::sqrt(cell.d1) > reach || !IsUsable(cell)) return;
      use(DrawPixel(x, y, cell), double(layer_.share.At(x, y)), known);
    });
  }

  std::vector<std::pair<float, float>> CollectProfile() {
    std::vector<std::pair<float, float>> samples;
    const double reach = fit_.profile.Reach() + 1;
    band_.ForEach([&](int x, int y, const Cell& cell) {
      if (layer_.weight.At(x, y) < 0.99 || std::sqrt(cell.d1) > reach || !IsUsable(cell)) return;
      if (cell.step2 >= 0 && std::sqrt(cell.d2) < 2 * reach) return;
      const Foot foot = FindFoot(fit_.curve, fit_.arc[std::size_t(cell.step1)], x, y);
      samples.emplace_back(static_cast<float>(foot.s), layer_.share.At(x, y));
    });
    return samples;
  }

  /// One step of Gauss-Newton. False when nothing moves any more.
  /// @param widen  of the line's blur, for far starts
  bool Step(double widen) {
    const Profile sharp = fit_.profile;
    fit_.profile.blur *= widen;
    const double reach = fit_.profile.Reach();
    const auto width = static_cast<std::size_t>(std::ceil(2 * (reach + 1) / fit_.curve.spacing())) + 5;
    BandedEquations equations(fit_.curve.coefficients.size(), std::max<std::size_t>(width, 5));
    if (widen > 1) Draw();
    double square = 0, count = 0;
    ForEachPixel([&](const Drawn& drawn, double seen, double known) {
      const double off = seen - drawn.shade.share;
      const double weight = known / (1 + off * off / (robust_ * robust_));
      square += weight * off * off, count += weight;
      AddPixel(drawn, off, weight / (noise_ * noise_), &equations);
    });
    fit_.profile = sharp;
    noise_ = std::clamp(std::sqrt(square / std::max(1.0, count)), 0.01, 0.2);
    const std::vector<double> precision = Smoothness();
    AddSmoothing(precision, &equations);
    AddSmoothingGradient(precision, &equations);
    for (std::size_t i = 0; i < fit_.curve.coefficients.size(); ++i) equations.Add(i, i, 1e-9);
    if (!equations.Factor()) return false;
    const std::vector<double> change = equations.Solve();
    double largest = 0;
    for (std::size_t i = 0; i < change.size(); ++i) {
      const double limited = std::clamp(change[i], -12.0, 12.0);
      fit_.curve.coefficients[i] += limited;
      largest = std::max(largest, std::abs(limited));
    }
    return largest > 0.02;
  }

  static void AddPixel(const Drawn& drawn, double off, double weight, BandedEquations* equations) {
    struct Part {
      const UniformSpline::Basis* basis;
      double by_row;
    };
    std::array<Part, 2> parts{Part{&drawn.first.basis, drawn.shade.by_first * drawn.first.normal_y}, Part{nullptr, 0}};
    if (drawn.second)
      parts[1] = {&drawn.second->basis, drawn.shade.by_second * drawn.second_sign * drawn.second->normal_y};
    std::array<std::pair<std::size_t, double>, 8> row;
    std::size_t size = 0;
    for (const Part& part : parts) {
      if (part.basis == nullptr) continue;
      for (std::size_t i = 0; i < 4; ++i) row[size++] = {part.basis->first + i, part.basis->value[i] * part.by_row};
    }
    for (std::size_t a = 0; a < size; ++a) {
      equations->AddRight(row[a].first, weight * row[a].second * off);
      for (std::size_t b = 0; b < size; ++b) {
        if (row[b].first > row[a].first || row[a].first - row[b].first > equations->band()) continue;
        if (row[a].first == row[b].first && a < b) continue;  // both orders of equal indices are one element
        const double both = row[a].first == row[b].first && a != b ? 2 : 1;
        equations->Add(row[a].first, row[b].first, both * weight * row[a].second * row[b].second);
      }
    }
  }

  void AddSmoothingGradient(const std::vector<double>& precision, BandedEquations* equations) const {
    constexpr std::array<double, 5> kFourth{1, -4, 6, -4, 1};
    const std::vector<double>& c = fit_.curve.coefficients;
    for (std::size_t i = 2; i + 2 < c.size(); ++i) {
      double fourth = 0;
      for (std::size_t a = 0; a < 5; ++a) fourth += kFourth[a] * c[i - 2 + a];
      for (std::size_t a = 0; a < 5; ++a) equations->AddRight(i - 2 + a, -precision[i] * kFourth[a] * fourth);
    }
  }

  /// Where along the arc the line is drawn: the median share of five steps against 0.4 of the full one.
  /// @param search  how far across the line its ink may lie [px]: the first readings are that far off
  void FindDashes(double search) {
    std::vector<ArcStep>& arc = fit_.arc;
    std::vector<double> seen(arc.size(), -1);
    for (std::size_t i = 0; i < arc.size(); ++i) seen[i] = LargestShare(arc[i], search);
    const double full = std::max(0.3, ShadeOf(fit_.profile, 0).share);
    for (std::size_t i = 0; i < arc.size(); ++i) {
      std::vector<double> near;
      for (std::size_t k = i > 2 ? i - 2 : 0; k < std::min(arc.size(), i + 3); ++k)
        if (seen[k] > -1) near.push_back(seen[k]);
      arc[i].known = !near.empty();
      if (near.empty()) continue;
      std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2), near.end());
      arc[i].inked = near[near.size() / 2] > 0.4 * full;
    }
    // Ends of dashes are drawn half: pixels within half a width and one pixel of a hole do not count.
    usable_.assign(arc.size(), 1);
    const auto margin = static_cast<std::size_t>((0.5 * fit_.profile.width + 1 + fit_.profile.blur) / kArcStep);
    for (std::size_t i = 0; i < arc.size(); ++i) {
      if (!arc[i].known || arc[i].inked) continue;
      for (std::size_t k = i > margin ? i - margin : 0; k < std::min(arc.size(), i + margin + 1); ++k) usable_[k] = 0;
    }
  }

  double LargestShare(const ArcStep& step, double search) const {
    const double c = 1 / std::hypot(1.0, step.slope);
    double largest = -2;
    for (double off = -search; off <= search; off += 0.7)
      largest = std::max(largest, ShareAt(step.x - off * step.slope * c, step.y + off * c));
    return largest;
  }

  /// Share between pixels, -2 where it is not known.
  double ShareAt(double x, double y) const {
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    double sum = 0, weights = 0;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        if (x0 + i < inks_.x0 || x0 + i > inks_.x1 || y0 + j < inks_.y0 || y0 + j > inks_.y1) continue;
        if (layer_.weight.At(x0 + i, y0 + j) <= 0) continue;
        const double weight = (1 - std::abs(x - x0 - i)) * (1 - std::abs(y - y0 - j));
        sum += weight * layer_.share.At(x0 + i, y0 + j), weights += weight;
      }
    }
    return weights > 0.2 ? sum / weights : -2;
  }

  void Finish() {
    FindDashes(0);
    double square = 0, count = 0, outliers = 0;
    const auto width = static_cast<std::size_t>(std::ceil(2 * (fit_.profile.Reach() + 1) / fit_.curve.spacing())) + 5;
    BandedEquations equations(fit_.curve.coefficients.size(), width);
    ForEachPixel([&](const Drawn& drawn, double seen, double known) {
      const double off = seen - drawn.shade.share;
      square += off * off, count += 1, outliers += std::abs(off) > 0.4;
      AddPixel(drawn, 0, known / (1 + off * off / (robust_ * robust_)) / (noise_ * noise_ * Correlation()), &equations);
    });
    fit_.rms = std::sqrt(square / std::max(1.0, count));
    fit_.outliers = outliers / std::max(1.0, count);
    fit_.floor = kFloor;
    AddSmoothing(Smoothness(), &equations);
    for (std::size_t i = 0; i < fit_.curve.coefficients.size(); ++i) equations.Add(i, i, 1e-9);
    if (!equations.Factor()) return;
    fit_.band = width;
    fit_.covariance = equations.InverseInBand();
  }

  /// Pixels next to each other err together: over a blur's area.
  double Correlation() const { return 2 + 4 * fit_.profile.blur * fit_.profile.blur; }

  const InkLayer& layer_;
  const Inks& inks_;
  Band band_;
  LineFit fit_;
  std::vector<char> usable_;
  double noise_ = 0.1;
  double robust_ = kRobust;
};

}  // namespace

double LineFit::Deviation(double x) const {
  if (covariance.empty()) return 0;
  const UniformSpline::Basis basis = curve.At(x);
  double variance = 0;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b < 4; ++b) {
      const std::size_t i = std::max(a, b) + basis.first, j = std::min(a, b) + basis.first;
      variance += basis.value[a] * basis.value[b] * covariance[i * (band + 1) + (i - j)];
    }
  }
  const double slope = curve.Slope(basis);
  return std::sqrt(variance + floor * floor * (1 + slope * slope));
}

LineFit FitLine(const InkLayer& layer, const Inks& inks, const Trace& trace, const std::vector<double>& start,
                double spacing) {
  return Fitter(layer, inks, trace, start, spacing).Run();
}

Plane DistanceFromCurve(const LineFit& fit, int width, int height, double reach) {
  Plane plane(width, height, static_cast<float>(reach));
  const int r = static_cast<int>(std::ceil(reach));
  for (const ArcStep& step : fit.arc) {
    const int cx = static_cast<int>(std::lround(step.x)), cy = static_cast<int>(std::lround(step.y));
    for (int y = std::max(0, cy - r); y <= std::min(height - 1, cy + r); ++y)
      for (int x = std::max(0, cx - r); x <= std::min(width - 1, cx + r); ++x)
        plane.At(x, y) = std::min(plane.At(x, y), static_cast<float>(std::hypot(x - step.x, y - step.y)));
  }
  return plane;
}

}  // namespace uiclink::digitise
