#include "identify/force_dependence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "identify/statistics.h"

namespace uiclink {
namespace {

// Odd numbers, so that zero is a knot. Displacement: 2.5 mm apart at 25 mm, which the windows resolve outside the
// fastest part of the first swings; velocity and time have less to tell.
constexpr std::size_t kDisplacementKnots = 21;
constexpr std::size_t kVelocityKnots = 13;
constexpr std::size_t kTimeKnots = 9;

// Frequencies at which a stiffness may be modulated [Hz]: slower is a change in time, faster is blurred by the windows.
constexpr double kSlowest = 0.1, kFastest = 4.0;
// Near twice the frequency of the motion a modulation pumps it, and is no different from a damping.
constexpr double kPumpingShare = 0.12;

// A column counts when this share of it is independent of those before.
constexpr double kIndependentShare = 1e-5;
// Prior of a fitted function: its values are below some M g, and its second differences between a whole M g and 1e-6.
constexpr double kWeakPrior = 0.1, kRoughest = 0, kSmoothest = 12;
constexpr std::size_t kMostNamed = 3;
constexpr int kGaugeRounds = 50;  // of the reweighting; it settles in a dozen

double Sign(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; }

double LongestTime(std::span<const ForceSeries> series) {
  double longest = 0;
  for (const ForceSeries& s : series) longest = std::max(longest, s.motion().back().t);
  return longest;
}

Eigen::Index CountWindows(std::span<const ForceSeries> series) {
  std::size_t windows = 0;
  for (const ForceSeries& s : series) windows += s.size();
  return static_cast<Eigen::Index>(windows);
}

}  // namespace

double Knots::Hat(std::size_t i, double x) const {
  x = std::clamp(x, at.front(), at.back());
  if (i > 0 && x < at[i]) return std::max(0.0, (x - at[i - 1]) / (at[i] - at[i - 1]));
  if (i + 1 < at.size() && x > at[i]) return std::max(0.0, (at[i + 1] - x) / (at[i + 1] - at[i]));
  return x == at[i] ? 1.0 : 0.0;
}

Knots Knots::Spread(double low, double high, std::size_t count) {
  Knots knots;
  for (std::size_t i = 0; i < count; ++i) {
    knots.at.push_back(low + (high - low) * static_cast<double>(i) / static_cast<double>(count - 1));
  }
  return knots;
}

ForceRegression::ForceRegression(std::span<const ForceSeries> series)
    : series_(series), force_(CountWindows(series)), dof_(static_cast<int>(force_.size())) {
  double largest = 0, fastest = 0;
  Eigen::Index row = 0;
  for (const ForceSeries& s : series) {
    const auto size = static_cast<Eigen::Index>(s.size());
    force_.segment(row, size) = s.JudgeForce();
    row += size;
    dof_ -= s.absorbed();
    for (const Moment& m : s.motion()) {
      largest = std::max(largest, std::abs(m.y));
      fastest = std::max(fastest, std::abs(m.v));
    }
  }
  displacement_ = Knots::Spread(-largest, largest, kDisplacementKnots);
  velocity_ = Knots::Spread(-fastest, fastest, kVelocityKnots);
  time_ = Knots::Spread(0, LongestTime(series), kTimeKnots);
}

Eigen::VectorXd ForceRegression::Column(const AlongMotion& function) const {
  Eigen::VectorXd column(force_.size());
  Eigen::Index row = 0;
  for (const ForceSeries& s : series_) {
    const auto size = static_cast<Eigen::Index>(s.size());
    column.segment(row, size) = s.Judge(s.Average(function));
    row += size;
  }
  return column;
}

const Knots& ForceRegression::KnotsOf(DependsOn on) const {
  if (on == DependsOn::kDisplacement) return displacement_;
  return on == DependsOn::kVelocity ? velocity_ : time_;
}

Eigen::MatrixXd ForceRegression::Columns(DependsOn on) const {
  if (on == DependsOn::kDryFriction) return Column([](const Moment& m) { return Sign(m.v); });
  if (on == DependsOn::kViscous) return Column([](const Moment& m) { return m.v; });
  const Knots& knots = KnotsOf(on);
  Eigen::MatrixXd columns(force_.size(), static_cast<Eigen::Index>(knots.at.size()));
  for (std::size_t i = 0; i < knots.at.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = Column([&](const Moment& m) {
      if (on == DependsOn::kDisplacement) return knots.Hat(i, m.y);
      if (on == DependsOn::kVelocity) return knots.Hat(i, m.v);
      return knots.Hat(i, m.t) * (on == DependsOn::kStiffnessInTime ? m.y : 1.0);
    });
  }
  return columns;
}

Eigen::MatrixXd ForceRegression::Oscillating(double frequency) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(force_.size(), 2 * static_cast<Eigen::Index>(series_.size()));
  const double w = 2 * std::numbers::pi * frequency;
  Eigen::Index row = 0, column = 0;
  for (const ForceSeries& s : series_) {
    const auto size = static_cast<Eigen::Index>(s.size());
    columns.block(row, column++, size, 1) =
        s.Judge(s.Average([w](const Moment& m) { return m.y * std::cos(w * m.t); }));
    columns.block(row, column++, size, 1) =
        s.Judge(s.Average([w](const Moment& m) { return m.y * std::sin(w * m.t); }));
    row += size;
  }
  return columns;
}

Eigen::MatrixXd Independent(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& without) {
  Eigen::MatrixXd scaled = columns;
  for (Eigen::Index i = 0; i < scaled.cols(); ++i) {
    const double norm = scaled.col(i).norm();
    if (norm > 0) scaled.col(i) /= norm;
  }
  // Twice, against rounding where nearly everything is taken away.
  for (int i = 0; i < 2 && without.cols() > 0; ++i) scaled -= without * (without.transpose() * scaled);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  // The threshold of Eigen is relative to the largest column that is left; ours to the columns as they came.
  Eigen::Index rank = 0;
  while (rank < qr.matrixQR().diagonalSize() && std::abs(qr.matrixQR()(rank, rank)) > kIndependentShare) ++rank;
  return qr.householderQ() * Eigen::MatrixXd::Identity(scaled.rows(), rank);
}

namespace {

/// Least squares with a prior on the second differences of the values at the knots, a ~ N(0, (s P + e I)^-1).
struct Smoother {
  Eigen::MatrixXd normal;     // X'X/dispersion
  Eigen::VectorXd right;      // X'z/dispersion
  Eigen::MatrixXd roughness;  // P = D'D

  Eigen::MatrixXd Prior(double strength) const {
    return strength * roughness + kWeakPrior * Eigen::MatrixXd::Identity(roughness.rows(), roughness.cols());
  }
  /// Logarithm of the likelihood of the record with the values integrated out, up to a constant.
  double LogEvidence(double strength) const {
    const Eigen::LLT<Eigen::MatrixXd> prior(Prior(strength)), posterior(normal + Prior(strength));
    const auto half_log_determinant = [](const Eigen::LLT<Eigen::MatrixXd>& llt) {
      return Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
    };
    return 0.5 * right.dot(posterior.solve(right)) + half_log_determinant(prior) - half_log_determinant(posterior);
  }
  double FindStrength() const {
    double best = 0, highest = -std::numeric_limits<double>::infinity();
    for (double decade = kRoughest; decade <= kSmoothest; decade += 0.25) {
      const double evidence = LogEvidence(std::pow(10, decade));
      if (evidence > highest) highest = evidence, best = std::pow(10, decade);
    }
    return best;
  }
};

Eigen::MatrixXd SecondDifferences(Eigen::Index n) {
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n - 2, n);
  for (Eigen::Index i = 0; i + 2 < n; ++i) d(i, i) = d(i, i + 2) = 1, d(i, i + 1) = -2;
  return d;
}

/// Takes away the constant and, on demand, the straight line.
Eigen::MatrixXd RemoveUnseen(Eigen::Index n, bool line) {
  Eigen::MatrixXd unseen(n, line ? 2 : 1);
  unseen.col(0).setConstant(1 / std::sqrt(static_cast<double>(n)));
  if (line) unseen.col(1) = Eigen::VectorXd::LinSpaced(n, -1, 1).normalized();
  return Eigen::MatrixXd::Identity(n, n) - unseen * unseen.transpose();
}

/// Takes a straight line away so that as much as can be is zero: least absolute deviations, by reweighting.
void RemoveLine(FittedFunction* function) {
  std::vector<FittedFunction::Knot>& knots = function->knots;
  std::vector<double> weight(knots.size(), 1.0);
  double a = 0, b = 0;
  for (int round = 0; round < kGaugeRounds; ++round) {
    double s = 0, sx = 0, sxx = 0, sf = 0, sxf = 0;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      const double x = knots[i].at, w = weight[i];
      s += w, sx += w * x, sxx += w * x * x, sf += w * knots[i].f, sxf += w * x * knots[i].f;
    }
    const double determinant = s * sxx - sx * sx;
    if (!(determinant > 0)) return;
    a = (sxx * sf - sx * sxf) / determinant, b = (s * sxf - sx * sf) / determinant;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      const double away = std::abs(knots[i].f - a - b * knots[i].at);
      weight[i] = 1 / (std::max(away, knots[i].error) * knots[i].error);
    }
  }
  for (FittedFunction::Knot& knot : knots) knot.f -= a + b * knot.at;
}

}  // namespace

FittedFunction ForceRegression::Fit(DependsOn on, const Eigen::MatrixXd& without, double dispersion) const {
  Eigen::MatrixXd columns = Columns(on);
  if (without.cols() > 0) columns -= without * (without.transpose() * columns);
  const Eigen::Index n = columns.cols();
  const Eigen::MatrixXd d = SecondDifferences(n);
  const Smoother smoother{.normal = columns.transpose() * columns / dispersion,
                          .right = columns.transpose() * force_ / dispersion,
                          .roughness = d.transpose() * d};
  const double strength = smoother.FindStrength();
  const Eigen::MatrixXd covariance =
      (smoother.normal + smoother.Prior(strength)).llt().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd seen = RemoveUnseen(n, on == DependsOn::kDisplacement);
  const Eigen::VectorXd f = seen * covariance * smoother.right;
  const Eigen::VectorXd variance = (seen * covariance * seen).diagonal();
  FittedFunction function;
  for (Eigen::Index i = 0; i < n; ++i) {
    function.knots.push_back(
        {.at = KnotsOf(on).at[static_cast<std::size_t>(i)], .f = f[i], .error = std::sqrt(std::max(0.0, variance[i]))});
  }
  if (on == DependsOn::kDisplacement) RemoveLine(&function);
  return function;
}

Eigen::MatrixXd ColumnsOf(const ForceRegression& regression, const Dependence& dependence) {
  return dependence.on == DependsOn::kStiffnessOscillating ? regression.Oscillating(dependence.frequency)
                                                           : regression.Columns(dependence.on);
}

namespace {

constexpr std::array kAll = {DependsOn::kDisplacement,
                             DependsOn::kDryFriction,
                             DependsOn::kViscous,
                             DependsOn::kVelocity,
                             DependsOn::kTime,
                             DependsOn::kStiffnessInTime,
                             DependsOn::kStiffnessOscillating};

struct Gain {
  double gain = 0;
  int terms = 0;
};

Gain CalcGain(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& without, const Eigen::VectorXd& left) {
  const Eigen::MatrixXd basis = Independent(columns, without);
  return {.gain = (basis.transpose() * left).squaredNorm(), .terms = static_cast<int>(basis.cols())};
}

/// Fall of the sum of squares by two columns.
double CalcGainOfTwo(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& left) {
  const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm(), al = a.dot(left), bl = b.dot(left);
  const double determinant = aa * bb - ab * ab;
  return determinant > 1e-9 * aa * bb ? (bb * al * al - 2 * ab * al * bl + aa * bl * bl) / determinant : 0.0;
}

/// The middle of each window stands for its mean: it only has to rank the frequencies.
double FindFrequency(const ForceRegression& regression, const Eigen::VectorXd& left, double step) {
  double best = 0, frequency = kSlowest;
  const double pumping = 2 * regression.series().front().frequency();
  for (double f = kSlowest; f <= kFastest; f += step) {
    if (std::abs(f - pumping) < kPumpingShare * pumping) continue;
    double gain = 0;
    Eigen::Index row = 0;
    for (const ForceSeries& s : regression.series()) {
      const auto size = static_cast<Eigen::Index>(s.size());
      Eigen::VectorXd a(size), b(size);
      for (Eigen::Index i = 0; i < size; ++i) {
        const Moment& m = s.windows()[static_cast<std::size_t>(i)].at;
        const double phase = 2 * std::numbers::pi * f * m.t;
        a[i] = m.y * std::cos(phase), b[i] = m.y * std::sin(phase);
      }
      gain += CalcGainOfTwo(s.Judge(a), s.Judge(b), left.segment(row, size));
      row += size;
    }
    if (gain > best) best = gain, frequency = f;
  }
  return frequency;
}

class Search {
 public:
  explicit Search(const ForceRegression& regression) : regression_(regression), left_(regression.force()) {
    const double longest = LongestTime(regression.series());
    frequency_step_ = 0.5 / longest;
    basis_.resize(left_.size(), 0);
    result_.chi2 = left_.squaredNorm();
    for (const DependsOn on : kAll) {
      Dependence d{.on = on};
      if (on == DependsOn::kStiffnessOscillating) d.frequency = FindFrequency(regression_, left_, frequency_step_);
      columns_.push_back(ColumnsOf(regression_, d));
      const Gain gain = CalcGain(columns_.back(), basis_, left_);
      d.gain = gain.gain, d.terms = gain.terms;
      d.share = Share(gain);
      d.p_value = PValue(on, gain);
      result_.all.push_back(d);
    }
  }

  DependenceSearch Run() {
    while (result_.named.size() < kMostNamed && NameNext()) {
    }
    result_.chi2_left = left_.squaredNorm();
    result_.terms = static_cast<int>(basis_.cols());
    result_.dispersion = std::max(1.0, result_.chi2_left / std::max(1, regression_.dof() - result_.terms));
    return result_;
  }

 private:
  double Share(const Gain& gain) const {
    const double excess = result_.chi2 - regression_.dof();
    return excess > 0 ? std::clamp((gain.gain - gain.terms) / excess, 0.0, 1.0) : 0.0;
  }

  /// What is left after a candidate scales the noise against which it is judged.
  double Dispersion(const Gain& gain) const {
    const double dof = regression_.dof() - static_cast<double>(basis_.cols()) - gain.terms;
    return std::max(1.0, (left_.squaredNorm() - gain.gain) / std::max(1.0, dof));
  }

  double PValue(DependsOn on, const Gain& gain) const {
    if (gain.terms == 0) return 1;
    double tests = static_cast<double>(kAll.size());
    if (on == DependsOn::kStiffnessOscillating) tests *= (kFastest - kSlowest) / frequency_step_;
    return std::min(1.0, tests * CalcChiSquareTail(gain.gain / Dispersion(gain), gain.terms));
  }

  bool NameNext() {
    std::size_t best = kAll.size();
    double best_score = 0;
    Gain best_gain;
    for (std::size_t i = 0; i < kAll.size(); ++i) {
      if (result_.all[i].named) continue;
      const Gain gain = CalcGain(columns_[i], basis_, left_);
      if (PValue(kAll[i], gain) > kFalseAlarm || (!result_.named.empty() && Share(gain) < kLeastShare)) continue;
      // A frequency is one more unknown.
      const int unknowns = gain.terms + (kAll[i] == DependsOn::kStiffnessOscillating ? 1 : 0);
      const double score = gain.gain / Dispersion(gain) - unknowns * std::log(static_cast<double>(regression_.dof()));
      if (score > best_score) best_score = score, best = i, best_gain = gain;
    }
    if (best == kAll.size()) return false;
    Dependence& d = result_.all[best];
    d.named = true;
    d.p_value = PValue(d.on, best_gain);
    result_.named.push_back(best);
    const Eigen::MatrixXd more = Independent(columns_[best], basis_);
    basis_.conservativeResize(Eigen::NoChange, basis_.cols() + more.cols());
    basis_.rightCols(more.cols()) = more;
    left_ -= more * (more.transpose() * left_);
    return true;
  }

  const ForceRegression& regression_;
  Eigen::VectorXd left_;
  Eigen::MatrixXd basis_;
  std::vector<Eigen::MatrixXd> columns_;
  double frequency_step_ = 0;
  DependenceSearch result_;
};

}  // namespace

DependenceSearch SearchDependences(const ForceRegression& regression) { return Search(regression).Run(); }

}  // namespace uiclink
