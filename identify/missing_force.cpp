#include "identify/missing_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "identify/force_refit.h"

namespace uiclink {
namespace {

constexpr std::size_t kMapCells = 9;  // along each axis, odd: one holds the rest

std::vector<MissingForce::Sample> Decimate(const ForceSeries& series) {
  std::vector<MissingForce::Sample> samples;
  double next = 0;
  for (const ForceSeries::Window& w : series.windows()) {
    if (!samples.empty() && w.at.t < next) continue;
    samples.push_back({.t = w.at.t, .y = w.at.y, .v = w.at.v, .f = w.f, .left = w.left, .error = w.error});
    next = w.at.t + series.half_width() * (1 - 1e-9);
  }
  return samples;
}

/// Mean and its error of the windows listed, all of one record.
struct Sum {
  double f = 0, variance = 0;
  int count = 0;
};

void AddCell(const ForceSeries& series, const std::vector<std::size_t>& windows, Sum* sum) {
  for (std::size_t i = 0; i < windows.size(); ++i) {
    sum->f += series.windows()[windows[i]].left;
    sum->variance += series.Covariance(windows[i], windows[i]);
    // Windows are in order of time, and covariance ends where they no longer overlap.
    for (std::size_t j = i + 1; j < windows.size(); ++j) {
      const double covariance = series.Covariance(windows[i], windows[j]);
      if (covariance == 0) break;
      sum->variance += 2 * covariance;
    }
  }
  sum->count += static_cast<int>(windows.size());
}

std::size_t CellOf(double x, double largest) {
  const double share = (x / largest + 1) / 2 * static_cast<double>(kMapCells);
  return static_cast<std::size_t>(std::clamp(share, 0.0, static_cast<double>(kMapCells) - 1));
}

std::vector<MissingForce::Cell> CalcMap(std::span<const ForceSeries> series, double largest, double fastest) {
  std::vector<Sum> sums(kMapCells * kMapCells);
  for (const ForceSeries& s : series) {
    std::vector<std::vector<std::size_t>> windows(sums.size());
    for (std::size_t a = 0; a < s.size(); ++a) {
      const Moment& at = s.windows()[a].at;
      windows[CellOf(at.y, largest) * kMapCells + CellOf(at.v, fastest)].push_back(a);
    }
    for (std::size_t c = 0; c < sums.size(); ++c) AddCell(s, windows[c], &sums[c]);
  }
  std::vector<MissingForce::Cell> map;
  const auto middle = [](std::size_t i) { return (2 * static_cast<double>(i) + 1) / kMapCells - 1; };
  for (std::size_t c = 0; c < sums.size(); ++c) {
    if (sums[c].count == 0) continue;
    map.push_back({.y = largest * middle(c / kMapCells),
                   .v = fastest * middle(c % kMapCells),
                   .f = sums[c].f / sums[c].count,
                   .error = std::sqrt(sums[c].variance) / sums[c].count,
                   .count = sums[c].count});
  }
  return map;
}

/// Which of a dependence's kinds a curve must not be freed from.
bool IsSameKind(DependsOn a, DependsOn b) {
  const auto is_velocity = [](DependsOn on) {
    return on == DependsOn::kVelocity || on == DependsOn::kViscous || on == DependsOn::kDryFriction;
  };
  return a == b || (is_velocity(a) && is_velocity(b));
}

double ValueOf(DependsOn on, const Moment& m) {
  if (on == DependsOn::kDisplacement) return m.y;
  return on == DependsOn::kVelocity ? m.v : m.t;
}

std::vector<MissingForce::Bin> FitBins(const ForceRegression& regression, const DependenceSearch& search,
                                       DependsOn on) {
  const Eigen::MatrixXd others =
      NamedBasis(regression, search, [on](const Dependence& d) { return !IsSameKind(on, d.on); });
  const FittedFunction function = regression.Fit(on, others, search.dispersion);
  const std::vector<double>& at = regression.KnotsOf(on).at;
  const double step = at[1] - at[0];
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::vector<int> count(at.size(), 0);
  for (const ForceSeries& s : regression.series()) {
    for (const Moment& m : s.motion()) low = std::min(low, ValueOf(on, m)), high = std::max(high, ValueOf(on, m));
    for (const ForceSeries::Window& w : s.windows()) {
      const double nearest = std::round((ValueOf(on, w.at) - at[0]) / step);
      ++count[static_cast<std::size_t>(std::clamp(nearest, 0.0, static_cast<double>(at.size()) - 1))];
    }
  }
  std::vector<MissingForce::Bin> bins;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (at[i] < low - 0.5 * step || at[i] > high + 0.5 * step) continue;  // the motion never gets there
    const FittedFunction::Knot& knot = function.knots[i];
    bins.push_back({.at = at[i], .f = knot.f, .error = knot.error, .count = count[i]});
  }
  return bins;
}

/// Coefficient of one function, and its error.
std::pair<double, double> FitOne(const ForceRegression& regression, DependsOn on, double dispersion) {
  const Eigen::VectorXd column = regression.Columns(on).col(0);
  const double square = column.squaredNorm();
  if (!(square > 0)) return {0, 0};
  return {column.dot(regression.force()) / square, std::sqrt(dispersion / square)};
}

/// Three errors of a force that acts between one knot and its neighbours only; median over displacement.
double CalcSmallestSeen(const ForceRegression& regression, double dispersion) {
  const Eigen::MatrixXd columns = regression.Columns(DependsOn::kDisplacement);
  std::vector<double> norms;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) norms.push_back(columns.col(i).norm());
  const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
  std::nth_element(norms.begin(), middle, norms.end());
  return *middle > 0 ? 3 * std::sqrt(dispersion) / *middle : 0;
}

void Judge(const ForceRegression& regression, const DependenceSearch& search, MissingForce* force) {
  force->search = search;
  const auto share = [&search](DependsOn on) { return search.all[static_cast<std::size_t>(on)].share; };
  force->share_of_y = share(DependsOn::kDisplacement);
  force->share_of_v = share(DependsOn::kVelocity);
  force->share_of_sign_v = share(DependsOn::kDryFriction);
  force->share_of_t = share(DependsOn::kTime);
  force->share_of_stiffness_in_t = share(DependsOn::kStiffnessInTime);
  force->share_of_modulated_stiffness = share(DependsOn::kStiffnessOscillating);
  force->dof = regression.dof();
  force->p_value = CalcNoiseProbability(search, regression.dof());
  force->over_y = FitBins(regression, search, DependsOn::kDisplacement);
  force->over_v = FitBins(regression, search, DependsOn::kVelocity);
  force->over_t = FitBins(regression, search, DependsOn::kTime);
  force->stiffness_over_t = FitBins(regression, search, DependsOn::kStiffnessInTime);
  for (MissingForce::Bin& bin : force->stiffness_over_t) bin.f = -bin.f;  // f = -dk y
  force->smallest_seen = CalcSmallestSeen(regression, search.dispersion);
  const auto [friction, friction_error] = FitOne(regression, DependsOn::kDryFriction, search.dispersion);
  const auto [viscous, viscous_error] = FitOne(regression, DependsOn::kViscous, search.dispersion);
  force->dry_friction = -friction, force->dry_friction_error = friction_error;
  force->viscous = -viscous, force->viscous_error = viscous_error;
}

}  // namespace

MissingForce FindMissingForce(std::span<const MissingForceInput> records) {
  MissingForce force;
  force.records.resize(records.size());
  for (const MissingForceInput& input : records) force.links.push_back(input.link);
  const ForceAnalysis analysis = AnalyseForce(records);
  if (analysis.series.empty()) {
    force.words = "no record is long enough to show a missing force";
    return force;
  }
  double k = 0;
  for (std::size_t i = 0; i < analysis.series.size(); ++i) {
    force.records[analysis.usable[i]] = Decimate(analysis.series[i]);
    force.links[analysis.usable[i]] = analysis.inputs[i].link;
    k += analysis.inputs[i].link.k / static_cast<double>(analysis.series.size());
  }
  const ForceRegression regression(analysis.series);
  force.map = CalcMap(analysis.series, regression.KnotsOf(DependsOn::kDisplacement).at.back(),
                      regression.KnotsOf(DependsOn::kVelocity).at.back());
  Judge(regression, analysis.search, &force);
  force.words = DescribeMissingForce(force, k);
  return force;
}

}  // namespace uiclink
