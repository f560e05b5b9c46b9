#include "identify/force_refit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/statistics.h"

namespace uiclink {
namespace {

constexpr int kAloneRounds = 4;    // before anything is named
constexpr int kMostRounds = 12;    // it settles in five to eight
constexpr double kSettled = 1e-3;  // relative change of every parameter

/// A function through the values at the knots.
AlongMotion Through(const FittedFunction& function, Knots knots, DependsOn on) {
  std::vector<double> f;
  for (const FittedFunction::Knot& knot : function.knots) f.push_back(knot.f);
  return [f, knots = std::move(knots), on](const Moment& m) {
    const double x = on == DependsOn::kDisplacement ? m.y : on == DependsOn::kVelocity ? m.v : m.t;
    double value = 0;
    for (std::size_t i = 0; i < f.size(); ++i) value += f[i] * knots.Hat(i, x);
    return value * (on == DependsOn::kStiffnessInTime ? m.y : 1.0);
  };
}

/// The force that one named dependence stands for, along the motion of each record.
std::vector<AlongMotion> Explain(const ForceRegression& regression, const DependenceSearch& search, std::size_t named) {
  const Dependence& d = search.all[named];
  const Eigen::MatrixXd others =
      NamedBasis(regression, search, [&d](const Dependence& other) { return other.on != d.on; });
  const std::size_t records = regression.series().size();
  if (d.on != DependsOn::kDryFriction && d.on != DependsOn::kViscous && d.on != DependsOn::kStiffnessOscillating) {
    const FittedFunction function = regression.Fit(d.on, others, search.dispersion);
    return std::vector<AlongMotion>(records, Through(function, regression.KnotsOf(d.on), d.on));
  }
  Eigen::MatrixXd columns = ColumnsOf(regression, d);
  columns -= others * (others.transpose() * columns);
  const Eigen::VectorXd a = columns.colPivHouseholderQr().solve(regression.force());
  std::vector<AlongMotion> functions;
  for (std::size_t r = 0; r < records; ++r) {
    if (d.on == DependsOn::kViscous) {
      functions.emplace_back([c = a[0]](const Moment& m) { return c * m.v; });
    } else if (d.on == DependsOn::kDryFriction) {
      functions.emplace_back([c = a[0]](const Moment& m) { return m.v > 0 ? c : -c; });
    } else {
      const auto column = static_cast<Eigen::Index>(2 * r);
      functions.emplace_back([c = a[column], s = a[column + 1], w = 2 * std::numbers::pi * d.frequency](
                                 const Moment& m) { return m.y * (c * std::cos(w * m.t) + s * std::sin(w * m.t)); });
    }
  }
  return functions;
}

void Rebuild(ForceAnalysis* analysis) {
  for (std::size_t r = 0; r < analysis->inputs.size(); ++r) {
    if (std::optional<ForceSeries> series = ForceSeries::Make(analysis->inputs[r]))
      analysis->series[r] = std::move(*series);
  }
}

/// Refits every link beside what is named. @returns the largest relative change of a parameter.
double RefitLinks(std::span<const MissingForceInput> given, bool beside_named, ForceAnalysis* analysis) {
  const ForceRegression regression(analysis->series);
  std::vector<Eigen::VectorXd> explained;
  for (const ForceSeries& s : analysis->series) {
    explained.emplace_back(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(s.size())));
  }
  for (const std::size_t named : beside_named ? analysis->search.named : std::vector<std::size_t>()) {
    const std::vector<AlongMotion> functions = Explain(regression, analysis->search, named);
    for (std::size_t r = 0; r < functions.size(); ++r) explained[r] += analysis->series[r].Average(functions[r]);
  }
  double change = 0;
  for (std::size_t r = 0; r < analysis->series.size(); ++r) {
    const MissingForceInput& at_first = given[analysis->usable[r]];
    change = std::max(change, analysis->series[r].Refit(explained[r], at_first, &analysis->inputs[r]));
  }
  Rebuild(analysis);
  return change;
}

}  // namespace

double CalcNoiseProbability(const DependenceSearch& search, int dof) { return CalcChiSquareTail(search.chi2, dof); }

ForceAnalysis AnalyseForce(std::span<const MissingForceInput> records) {
  ForceAnalysis analysis;
  for (std::size_t r = 0; r < records.size(); ++r) {
    std::optional<ForceSeries> series = ForceSeries::Make(records[r]);
    if (!series) continue;
    analysis.inputs.push_back(records[r]);
    analysis.usable.push_back(r);
    analysis.series.push_back(std::move(*series));
  }
  if (analysis.series.empty()) return analysis;
  const auto search = [&analysis] {
    const ForceRegression regression(analysis.series);
    analysis.search = SearchDependences(regression);
    analysis.dof = regression.dof();
  };
  search();
  if (analysis.search.named.empty() && CalcNoiseProbability(analysis.search, analysis.dof) > kFalseAlarm)
    return analysis;
  for (int round = 0; round < kMostRounds; ++round) {
    const double change = RefitLinks(records, round >= kAloneRounds, &analysis);
    if (round + 1 >= kAloneRounds) search();
    if (round > kAloneRounds && change < kSettled) break;
  }
  return analysis;
}

}  // namespace uiclink
