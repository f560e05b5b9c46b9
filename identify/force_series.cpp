#include "identify/force_series.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "identify/local_fit.h"

namespace uiclink {
namespace {

// Steps between two samples: enough that corners of the sliders' forces are integrated, not sampled.
constexpr std::size_t kFine = 4;

// Half widths as phase angles of the stuck link [rad]. The smoothed motion only steers the sliders: a narrow window, as
// the fourth derivative jumps where they turn. The windows of the force: a tenth of a second for the thesis's lateral
// link.
constexpr double kSmoothingPhase = 0.35;
constexpr double kWindowPhase = 0.55;
// Distance of windows [half widths]. Twice as far, a friction is seen half as well.
constexpr double kWindowStep = 0.25;
constexpr std::size_t kFewestNodes = 5;     // samples in half a window
constexpr std::size_t kFewestWindows = 10;  // fewer cannot be judged beside what the link absorbs

// Relative change of a parameter for its direction; the sliders' forces are piecewise linear in it.
constexpr double kStep = 1e-4;
// A direction counts when this share of it is independent of those before.
constexpr double kIndependent = 1e-5;

double StuckFrequency(const Oscillator<double>& link) {
  double stiffness = link.k;
  for (const Slider<double>& s : link.sliders()) stiffness += s.k;
  return std::sqrt(link.g * stiffness);
}

bool IsUsable(const MissingForceInput& in) {
  return in.record != nullptr && in.sigma > 0 && in.link.k > 0 && in.link.g > 0 && in.size > 2 * kFewestNodes &&
         in.first + in.size <= in.record->t.size() && std::isfinite(in.offset) && std::isfinite(in.y0);
}

/// Displacement and velocity at every sample, each from its own neighbourhood; at the ends of the record from the last
/// neighbourhood that is whole.
std::vector<Moment> SmoothSamples(const MissingForceInput& in) {
  const double w = StuckFrequency(in.link), half_width = kSmoothingPhase / w;
  const std::vector<double>&t = in.record->t, &y = in.record->y;
  std::vector<std::optional<LocalFit>> fits(in.size);
  for (std::size_t i = 0; i < in.size; ++i) fits[i] = FitLocally(t, y, in.first + i, half_width, w);
  const auto has_fit = [](const std::optional<LocalFit>& fit) { return fit.has_value(); };
  const auto begin = std::find_if(fits.begin(), fits.end(), has_fit);
  if (begin == fits.end()) return {};
  std::fill(fits.begin(), begin, *begin);
  std::vector<Moment> moments;
  for (std::size_t i = 0; i < in.size; ++i) {
    if (!fits[i]) fits[i] = fits[i - 1];
    const double time = t[in.first + i];
    moments.push_back({.t = time - in.t0, .y = fits[i]->y(time) - in.offset, .v = fits[i]->v(time)});
  }
  return moments;
}

/// Cubic through two instants and their velocities.
Moment Interpolate(const Moment& a, const Moment& b, double x) {
  const double h = b.t - a.t, d = (b.y - a.y) / h, c2 = 3 * d - 2 * a.v - b.v, c3 = a.v + b.v - 2 * d;
  return {.t = a.t + x * h, .y = a.y + h * x * (a.v + x * (c2 + x * c3)), .v = a.v + x * (2 * c2 + x * 3 * c3)};
}

std::vector<Moment> Refine(const std::vector<Moment>& samples) {
  std::vector<Moment> fine;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    for (std::size_t j = 0; j < kFine; ++j) {
      fine.push_back(Interpolate(samples[i], samples[i + 1], static_cast<double>(j) / kFine));
    }
  }
  fine.push_back(samples.back());
  return fine;
}

/// One slider along the motion.
struct SliderPath {
  std::vector<double> T;
  std::vector<bool> slides;
  std::size_t last_slip = 0;
};

SliderPath FollowSlider(const Slider<double>& slider, double y0, const std::vector<Moment>& motion) {
  SliderPath path;
  path.T.reserve(motion.size());
  const double side = y0 < 0 ? -1 : 1;
  // From the measured extremum, which lies at or just before the first sample (y0 of a fit may be off by more).
  const Moment& start = motion.front();
  const double before = start.t > 0 ? side * 0.5 * std::abs(start.v) * start.t : 0;
  double T = std::clamp(-side * slider.T0 + slider.k * before, -slider.T0, slider.T0);
  double last_y = start.y;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const double free = T - slider.k * (motion[i].y - last_y);
    T = std::clamp(free, -slider.T0, slider.T0);
    last_y = motion[i].y;
    path.T.push_back(T);
    path.slides.push_back(T != free);
    if (T != free) path.last_slip = i;
  }
  return path;
}

/// Integral of function(fine index) under the hat of each sample (1 there, 0 at its neighbours), by the trapezoidal
/// rule on the fine steps; the first and the last sample have half a hat.
template <typename F>
Eigen::VectorXd IntegrateHats(const std::vector<Moment>& motion, const F& function) {
  const std::size_t nodes = (motion.size() - 1) / kFine + 1;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes));
  for (std::size_t i = 0; i + 1 < nodes; ++i) {
    const double step = (motion[(i + 1) * kFine].t - motion[i * kFine].t) / kFine;
    double rising = 0, all = 0;
    for (std::size_t j = 0; j <= kFine; ++j) {
      const double end = j == 0 || j == kFine ? 0.5 : 1.0, x = static_cast<double>(j) / kFine;
      const double value = end * step * function(i * kFine + j);
      rising += value * x, all += value;
    }
    sums[static_cast<Eigen::Index>(i)] += all - rising;
    sums[static_cast<Eigen::Index>(i + 1)] += rising;
  }
  return sums;
}

/// The integral of y'' under each hat: slope after the sample less slope before it.
Eigen::VectorXd IntegrateAcceleration(const MissingForceInput& in) {
  const double *t = in.record->t.data() + in.first, *y = in.record->y.data() + in.first;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(in.size));
  for (std::size_t i = 1; i + 1 < in.size; ++i) {
    sums[static_cast<Eigen::Index>(i)] = (y[i + 1] - y[i]) / (t[i + 1] - t[i]) - (y[i] - y[i - 1]) / (t[i] - t[i - 1]);
  }
  return sums;
}

}  // namespace

void ForceSeries::PlaceWindows(const std::vector<double>& t) {
  // Not the first and last sample: they have no slope on one side.
  const double mean_step = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  half_width_ = std::max(half_width_, static_cast<double>(kFewestNodes) * mean_step);
  const auto step =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kWindowStep * half_width_ / mean_step)));
  for (std::size_t c = 1; c + 1 < t.size(); c += step) {
    if (t[c] - half_width_ < t.front() || t[c] + half_width_ > t.back()) continue;
    Span span{.first = c, .weights = {}};
    while (span.first > 1 && t[c] - t[span.first - 1] < half_width_) --span.first;
    double integral = 0;
    for (std::size_t i = span.first; i + 1 < t.size() && t[i] - t[c] < half_width_; ++i) {
      const double s = (t[i] - t[c]) / half_width_, weight = (1 - s * s) * (1 - s * s);
      span.weights.push_back(weight);
      integral += weight * 0.5 * (t[i + 1] - t[i - 1]);
    }
    for (double& weight : span.weights) weight /= integral;
    spans_.push_back(std::move(span));
    windows_.push_back({.at = motion_[c * kFine]});
  }
}

Eigen::VectorXd ForceSeries::WindowSums(const Eigen::VectorXd& node_sums) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(spans_.size()));
  for (std::size_t a = 0; a < spans_.size(); ++a) {
    const auto size = static_cast<Eigen::Index>(spans_[a].weights.size());
    sums[static_cast<Eigen::Index>(a)] = Eigen::Map<const Eigen::VectorXd>(spans_[a].weights.data(), size)
                                             .dot(node_sums.segment(static_cast<Eigen::Index>(spans_[a].first), size));
  }
  return sums;
}

Eigen::VectorXd ForceSeries::Average(const AlongMotion& function) const {
  return WindowSums(IntegrateHats(motion_, [&](std::size_t i) { return function(motion_[i]); }));
}

void ForceSeries::CalcCovariance(const MissingForceInput& input, const std::vector<double>& t,
                                 const std::vector<double>& stiffness) {
  // Weights of the readings in each window: second differences of the window's weights, and its springs.
  std::vector<std::vector<double>> rows;
  for (const Span& span : spans_) {
    std::vector<double> row(span.weights.size() + 2, 0.0);  // from reading span.first - 1
    for (std::size_t j = 0; j < span.weights.size(); ++j) {
      const std::size_t i = span.first + j;
      const double before = 1 / (t[i] - t[i - 1]), after = 1 / (t[i + 1] - t[i]), p = span.weights[j] / input.link.g;
      row[j] += p * before;
      row[j + 1] += -p * (before + after) + span.weights[j] * stiffness[i] * 0.5 * (t[i + 1] - t[i - 1]);
      row[j + 2] += p * after;
    }
    rows.push_back(std::move(row));
  }
  const double variance = input.sigma * input.sigma;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    covariance_.emplace_back();
    for (std::size_t b = a; b < rows.size() && spans_[b].first < spans_[a].first + rows[a].size(); ++b) {
      const std::size_t shift = spans_[b].first - spans_[a].first;
      double sum = 0;
      for (std::size_t j = shift; j < rows[a].size() && j - shift < rows[b].size(); ++j)
        sum += rows[a][j] * rows[b][j - shift];
      covariance_[a].push_back(variance * sum);
    }
    covariance_[a][0] += kReconstructionFloor * kReconstructionFloor;
    windows_[a].error = std::sqrt(covariance_[a][0]);
  }
}

double ForceSeries::Covariance(std::size_t a, std::size_t b) const {
  if (a > b) std::swap(a, b);
  return b - a < covariance_[a].size() ? covariance_[a][b - a] : 0.0;
}

Eigen::VectorXd ForceSeries::Whiten(Eigen::VectorXd values) const {
  for (std::size_t a = 0; a < factor_.size(); ++a) {
    const std::vector<double>& row = factor_[a];
    double value = values[static_cast<Eigen::Index>(a)];
    for (std::size_t j = 1; j < row.size(); ++j)
      value -= row[row.size() - 1 - j] * values[static_cast<Eigen::Index>(a - j)];
    values[static_cast<Eigen::Index>(a)] = value / row.back();
  }
  return values - memory_ * (memory_shrink_.asDiagonal() * (memory_.transpose() * values));
}

Eigen::VectorXd ForceSeries::Colour(Eigen::VectorXd white) const {
  const Eigen::VectorXd grow = memory_shrink_.array() / (1 - memory_shrink_.array());
  white += memory_ * (grow.asDiagonal() * (memory_.transpose() * white)).eval();
  Eigen::VectorXd values(white.size());
  for (std::size_t a = 0; a < factor_.size(); ++a) {
    const std::vector<double>& row = factor_[a];
    double value = 0;
    for (std::size_t j = 0; j < row.size(); ++j)
      value += row[row.size() - 1 - j] * white[static_cast<Eigen::Index>(a - j)];
    values[static_cast<Eigen::Index>(a)] = value;
  }
  return values;
}

namespace {

/// Cholesky factor of a banded symmetric matrix, row by row; the last element of a row is on the diagonal.
std::vector<std::vector<double>> FactorBand(const ForceSeries& series, std::size_t bandwidth) {
  std::vector<std::vector<double>> factor(series.size());
  const auto element = [&factor](std::size_t a, std::size_t b) {
    const std::size_t back = a - b;
    return back < factor[a].size() ? factor[a][factor[a].size() - 1 - back] : 0.0;
  };
  for (std::size_t a = 0; a < series.size(); ++a) {
    const std::size_t from = a < bandwidth ? 0 : a - bandwidth;
    factor[a].assign(a - from + 1, 0.0);
    for (std::size_t b = from; b <= a; ++b) {
      double sum = series.Covariance(a, b);
      for (std::size_t c = from; c < b; ++c) sum -= element(a, c) * element(b, c);
      factor[a][b - from] = a == b ? std::sqrt(sum) : sum / element(b, b);
    }
  }
  return factor;
}

}  // namespace

void ForceSeries::CalcMemoryErrors(const MissingForceInput& input) {
  memory_.resize(static_cast<Eigen::Index>(size()), 0);
  memory_shrink_.resize(0);
  // Samples in the smoothing window, and the error of the level at which it has the motion turn.
  const double mean_step = (motion_.back().t - motion_.front().t) * kFine / static_cast<double>(motion_.size() - 1);
  const double samples = std::max(5.0, 1 + 2 * kSmoothingPhase / StuckFrequency(input.link) / mean_step);
  const double level_error = 1.5 * input.sigma / std::sqrt(samples);
  std::vector<Eigen::VectorXd> columns;
  for (const Slider<double>& slider : input.link.sliders()) {
    const SliderPath path = FollowSlider(slider, input.y0, motion_);
    for (std::size_t i = 0; i < motion_.size();) {
      std::size_t end = i;
      while (end < motion_.size() && path.slides[end] == path.slides[i]) ++end;
      if (!path.slides[i]) {
        const Eigen::VectorXd column =
            Whiten(WindowSums(IntegrateHats(motion_, [&](std::size_t n) { return n >= i && n < end ? 1.0 : 0.0; })));
        columns.push_back(slider.k * level_error * column);
      }
      i = end;
    }
  }
  if (columns.empty()) return;
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(size()), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) matrix.col(static_cast<Eigen::Index>(i)) = columns[i];
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::HouseholderQRPreconditioner> svd(matrix, Eigen::ComputeThinU);
  memory_ = svd.matrixU();
  memory_shrink_ = 1 - (1 + svd.singularValues().array().square()).rsqrt();
}

void ForceSeries::CalcAbsorbed(const MissingForceInput& input) {
  const auto rows = static_cast<Eigen::Index>(size());
  directions_.resize(rows, 2 + 3 * input.link.size());
  Eigen::Index column = 0;
  const auto add = [&](const auto& function) {
    directions_.col(column++) = Whiten(WindowSums(IntegrateHats(motion_, function)));
  };
  add([&](std::size_t) { return -input.link.k; });
  add([this](std::size_t i) { return motion_[i].y; });
  for (const Slider<double>& slider : input.link.sliders()) {
    const SliderPath path = FollowSlider(slider, input.y0, motion_);
    const double dk = kStep * slider.k, dT0 = kStep * slider.T0;
    const SliderPath stiffer = FollowSlider({.k = slider.k + dk, .T0 = slider.T0}, input.y0, motion_);
    const SliderPath stronger = FollowSlider({.k = slider.k, .T0 = slider.T0 + dT0}, input.y0, motion_);
    add([&](std::size_t i) { return dk > 0 ? -(stiffer.T[i] - path.T[i]) / dk : 0.0; });
    add([&](std::size_t i) { return dT0 > 0 ? -(stronger.T[i] - path.T[i]) / dT0 : 0.0; });
    add([&](std::size_t i) { return i > path.last_slip ? 1.0 : 0.0; });
  }
  Eigen::MatrixXd matrix = directions_;
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) {
    if (matrix.col(i).norm() > 0) matrix.col(i).normalize();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(matrix);
  qr.setThreshold(kIndependent);
  absorbed_ = Eigen::MatrixXd(qr.householderQ() * Eigen::MatrixXd::Identity(rows, qr.rank()));
}

double ForceSeries::Refit(const Eigen::VectorXd& explained, const MissingForceInput& given,
                          MissingForceInput* input) const {
  Eigen::VectorXd f(explained.size());
  for (std::size_t a = 0; a < size(); ++a) f[static_cast<Eigen::Index>(a)] = windows_[a].f;
  const Eigen::VectorXd white = Whiten(f - explained);
  // Priors, and how far from their middle the parameters are; the force where a slider is left is within its T0.
  const Eigen::Index n = directions_.cols();
  Eigen::VectorXd scale(n), away = Eigen::VectorXd::Zero(n);
  scale[0] = kOffsetPrior, away[0] = input->offset - given.offset;
  scale[1] = kLinkPrior * given.link.k, away[1] = input->link.k - given.link.k;
  Eigen::Index column = 2;
  for (std::size_t i = 0; i < given.link.sliders().size(); ++i, column += 3) {
    const Slider<double>&now = input->link.sliders()[i], &then = given.link.sliders()[i];
    scale[column] = kLinkPrior * then.k, away[column] = now.k - then.k;
    scale[column + 1] = kLinkPrior * then.T0, away[column + 1] = now.T0 - then.T0;
    scale[column + 2] = then.T0;
  }
  const Eigen::MatrixXd scaled = directions_ * scale.asDiagonal();
  const Eigen::MatrixXd normal = scaled.transpose() * scaled + Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd pull = away.cwiseQuotient(scale.cwiseMax(1e-300));
  const Eigen::VectorXd step = -scale.cwiseProduct(normal.llt().solve(scaled.transpose() * white + pull));
  double change = 0;
  const auto move = [&change](double by, double* value) {
    if (!(*value > 0) || !std::isfinite(by)) return;
    const double factor = std::clamp(1 + by / *value, 0.5, 2.0);
    change = std::max(change, std::abs(factor - 1));
    *value *= factor;
  };
  if (std::isfinite(step[0])) input->offset += std::clamp(step[0], -kOffsetPrior, kOffsetPrior);
  move(step[1], &input->link.k);
  column = 2;
  for (Slider<double>& slider : input->link.sliders()) {
    move(step[column], &slider.k);
    move(step[column + 1], &slider.T0);
    column += 3;
  }
  return change;
}

Eigen::VectorXd ForceSeries::Judge(const Eigen::VectorXd& values) const {
  const Eigen::VectorXd white = Whiten(values);
  return white - absorbed_ * (absorbed_.transpose() * white);
}

Eigen::VectorXd ForceSeries::JudgeForce() const {
  Eigen::VectorXd f(static_cast<Eigen::Index>(size()));
  for (std::size_t a = 0; a < size(); ++a) f[static_cast<Eigen::Index>(a)] = windows_[a].f;
  return Judge(f);
}

std::optional<ForceSeries> ForceSeries::Make(const MissingForceInput& input) {
  if (!IsUsable(input)) return std::nullopt;
  const std::vector<Moment> samples = SmoothSamples(input);
  if (samples.empty()) return std::nullopt;
  ForceSeries series;
  series.motion_ = Refine(samples);
  series.half_width_ = kWindowPhase / StuckFrequency(input.link);
  series.frequency_ = StuckFrequency(input.link) / (2 * std::numbers::pi);
  const auto begin = input.record->t.begin() + static_cast<std::ptrdiff_t>(input.first);
  const std::vector<double> t(begin, begin + static_cast<std::ptrdiff_t>(input.size));
  series.PlaceWindows(t);
  if (series.size() < kFewestWindows) return std::nullopt;

  std::vector<double> force(series.motion_.size()), stiffness(t.size(), input.link.k);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] = input.link.k * series.motion_[i].y;
  for (const Slider<double>& slider : input.link.sliders()) {
    const SliderPath path = FollowSlider(slider, input.y0, series.motion_);
    for (std::size_t i = 0; i < force.size(); ++i) force[i] -= path.T[i];
    for (std::size_t i = 0; i < t.size(); ++i) stiffness[i] += path.slides[i * kFine] ? 0 : slider.k;
  }
  const Eigen::VectorXd f = series.WindowSums(IntegrateAcceleration(input) / input.link.g +
                                              IntegrateHats(series.motion_, [&](std::size_t i) { return force[i]; }));
  for (std::size_t a = 0; a < series.size(); ++a) series.windows_[a].f = f[static_cast<Eigen::Index>(a)];

  series.CalcCovariance(input, t, stiffness);
  std::size_t bandwidth = 0;
  for (const auto& row : series.covariance_) bandwidth = std::max(bandwidth, row.size() - 1);
  series.factor_ = FactorBand(series, bandwidth);
  series.CalcMemoryErrors(input);
  series.CalcAbsorbed(input);
  const Eigen::VectorXd left = series.Colour(series.JudgeForce());
  for (std::size_t a = 0; a < series.size(); ++a) series.windows_[a].left = left[static_cast<Eigen::Index>(a)];
  return series;
}

}  // namespace uiclink
