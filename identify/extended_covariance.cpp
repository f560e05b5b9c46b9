#include "identify/extended_covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "identify/screen.h"
#include "model/parameter_set.h"

namespace uiclink {
namespace {

constexpr double kRounding = 1e-12;  // eigenvalues below are directions that the data do not see
constexpr double kMostCorrelated = 1 - 1e-12;

/// One natural parameter: its name, its stated standard deviation, its value, its derivatives by all unknowns.
struct Row {
  std::string symbol;
  double std = 0;
  double value = 0;
  Eigen::RowVectorXd derivatives;
};

/// Parameters of the link: the shared one, or means over the records.
void AddLinkRows(std::span<const FitData> data, const ExtendedResult& result, const UnknownMap& map,
                 std::vector<Row>* rows) {
  const ExtendedState& state = result.outcome.state;
  const int n = CountSliders(state.link.shape);
  const std::vector<std::string> symbols = ParameterSymbols(n);
  const std::size_t links = result.sharing == Sharing::kLink ? 1 : data.size();
  for (int q = 0; q < 2 * n + 1; ++q) {
    const auto index = static_cast<std::size_t>(q);
    Row row{.symbol = symbols[index],
            .std = result.quantities[index].std,
            .value = result.quantities[index].value,
            .derivatives = Eigen::RowVectorXd::Zero(map.size())};
    for (std::size_t r = 0; r < links; ++r) {
      const Oscillator<double> link = ToOscillator(state.link.LevelsOf(r), state.link.ShapeOf(r), data[r].g);
      const Eigen::RowVectorXd gradient = CalcLogGradient(link, q);
      const std::vector<Eigen::Index> columns = map.Columns(r);
      for (Eigen::Index i = 0; i < gradient.size(); ++i)
        row.derivatives(columns[static_cast<std::size_t>(i)]) += gradient(i) / static_cast<double>(links);
    }
    row.derivatives *= result.quantities[index].value;
    rows->push_back(std::move(row));
  }
}

/// k, k1..kn, T01..T0n of each record's link: a row per record.
Eigen::MatrixXd CalcLinksByRecord(std::span<const FitData> data, const ExtendedState& state) {
  const auto records = static_cast<Eigen::Index>(data.size());
  const Eigen::Index quantities = 2 * CountSliders(state.link.shape) + 1;
  Eigen::MatrixXd values(records, quantities);
  for (Eigen::Index r = 0; r < records; ++r) {
    const auto record = static_cast<std::size_t>(r);
    const Oscillator<double> link =
        ToOscillator(state.link.LevelsOf(record), state.link.ShapeOf(record), data[record].g);
    for (Eigen::Index q = 0; q < quantities; ++q) values(r, q) = CalcQuantity(link, static_cast<int>(q));
  }
  return values;
}

/// What the scatter of the links between records adds to the covariance of their means: a record's links differ in k
/// and k_i by chance, each for itself, which is another thing than the errors of a fit, that bind the two together.
Eigen::MatrixXd CalcScatterOfMeans(Eigen::MatrixXd values) {
  const auto records = static_cast<double>(values.rows());
  values.rowwise() -= values.colwise().mean().eval();
  return values.transpose() * values / (records * (records - 1));
}

/// Covariance of all unknowns that errors of the effects' shared parameters make: all of it less what is left when
/// these are known. In units of the noise.
Eigen::MatrixXd CalcCommon(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& all, Eigen::Index first_shared,
                           Eigen::Index shared) {
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < gram.rows(); ++i)
    if (i < first_shared || i >= first_shared + shared) others.push_back(i);
  Eigen::MatrixXd common = all;
  const Eigen::MatrixXd given = InvertDetermined(gram(others, others), kRounding);
  for (std::size_t i = 0; i < others.size(); ++i)
    for (std::size_t j = 0; j < others.size(); ++j)
      common(others[i], others[j]) -= given(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return common;
}

void AddEffectRows(const ExtendedResult& result, const UnknownMap& map, std::vector<Row>* rows) {
  const ExtendedState& state = result.outcome.state;
  const std::span<const Extension::Unknown> shared = result.extension.shared();
  const std::size_t first = 3 + state.link.shape.size() + 3;  // levels, shape, start
  const std::vector<Eigen::Index> columns = map.Columns(0);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const EffectParameter& parameter = shared[i].Parameter();
    const auto told = std::find_if(result.effects.begin(), result.effects.end(), [&](const EffectEstimate& e) {
      return e.effect == shared[i].effect && e.symbol == parameter.symbol;
    });
    if (told == result.effects.end()) continue;
    Row row{.symbol = std::string(shared[i].effect->id) + "." + std::string(parameter.symbol),
            .std = told->std,
            .value = told->value,
            .derivatives = Eigen::RowVectorXd::Zero(map.size())};
    row.derivatives(columns[first + i]) = CalcSlope(parameter, state.shared[i]);
    rows->push_back(std::move(row));
  }
}

}  // namespace

ExtendedCovariance CalcExtendedCovariance(std::span<const FitData> data, const ExtendedResult& result) {
  const UnknownMap map(result.extension, result.sharing, CountSliders(result.outcome.state.link.shape), data.size(),
                       !result.outcome.state.link.shapes.empty());
  std::vector<Row> rows;
  AddLinkRows(data, result, map, &rows);
  AddEffectRows(result, map, &rows);
  std::erase_if(rows, [](const Row& row) { return !std::isfinite(row.std) || !row.derivatives.allFinite(); });
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd derivatives(n, map.size());
  ExtendedCovariance covariance;
  for (Eigen::Index i = 0; i < n; ++i) {
    derivatives.row(i) = rows[static_cast<std::size_t>(i)].derivatives;
    covariance.order.push_back(rows[static_cast<std::size_t>(i)].symbol);
  }
  const Normal normal = CalcNormal(data, result.sharing, result.extension, result.outcome.state, 1);
  const Eigen::MatrixXd all = InvertDetermined(normal.gram, kRounding);
  Eigen::MatrixXd linear = derivatives * all * derivatives.transpose();
  if (result.sharing != Sharing::kLink && data.size() > 1) {
    const Eigen::MatrixXd links = CalcLinksByRecord(data, result.outcome.state);
    if (links.cols() <= n) {  // all of them are told
      linear.topLeftCorner(links.cols(), links.cols()) += CalcScatterOfMeans(links);
      covariance.by_record = Eigen::MatrixXd::Zero(links.rows(), n);
      covariance.by_record.leftCols(links.cols()) = links;
      for (Eigen::Index i = links.cols(); i < n; ++i)
        covariance.by_record.col(i).setConstant(rows[static_cast<std::size_t>(i)].value);
      const auto shared = static_cast<Eigen::Index>(result.extension.shared().size());
      covariance.common = result.variance_factor * derivatives *
                          CalcCommon(normal.gram, all, map.first_shared(), shared) * derivatives.transpose();
    }
  }
  covariance.matrix = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double scale = std::sqrt(linear(i, i) * linear(j, j));
      const double correlation = i == j      ? 1
                                 : scale > 0 ? std::clamp(linear(i, j) / scale, -kMostCorrelated, kMostCorrelated)
                                             : 0;
      const double std_i = rows[static_cast<std::size_t>(i)].std, std_j = rows[static_cast<std::size_t>(j)].std;
      covariance.matrix(i, j) = covariance.matrix(j, i) = correlation * std_i * std_j;
    }
  return covariance;
}

}  // namespace uiclink
