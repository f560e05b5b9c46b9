#include "identify/joint_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "identify/random_effects.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr double kSharingLevel = 0.01;  // below this p-value the records do not share their link
constexpr double kDoubtLevel = 0.05;    // below this one their disagreement widens the bounds of the shared link

/// Information on the levels alone, the shape eliminated as far as the record determines it. At the level of the noise,
/// also where the model lacks something: what it lacks is much the same in every record and would hide the scatter.
Eigen::Matrix3d LevelInformation(const LinkInformation& record) {
  const Eigen::MatrixXd covariance = CalcCovariance(record.information, 1);
  const Eigen::Matrix3d levels = covariance.topLeftCorner<3, 3>();
  return levels.inverse();
}

/// The joint fit of all records of a direction, in the making.
class JointFit {
 public:
  JointFit(int threads, Identification* result) : result_(*result), used_(result->UsedIndices()), threads_(threads) {
    for (const std::size_t i : used_) data_.push_back(result->records[i].Data());
  }

  void Run() {
    if (used_.size() == 1) {
      outcome_ = Record(0).own;
    } else if (result_.shared || MayShareAfterAll()) {
      outcome_ = FitShared();
      SortSliders(&outcome_.state);
      if (!result_.shared) CompareWithOwnFits();
    }
    if (!result_.shared) CollectOwnFits();
    for (std::size_t r = 0; r < used_.size(); ++r) Take(r);
    result_.shared ? FinishShared() : FinishHierarchical();
    FinishRecords();
  }

 private:
  RecordResult& Record(std::size_t r) { return result_.records[used_[r]]; }

  /// Several sliders: the sum of squares is far from a parabola along what single records hardly determine, and a
  /// distance in units of the covariance is then too large. Links that really differ are farther apart than that.
  bool MayShareAfterAll() const {
    constexpr double kFarApart = 20;  // statistic per degree of freedom: 2 % of scatter give thousands
    return result_.sliders > 1 && result_.sharing.statistic < kFarApart * result_.sharing.dof;
  }

  /// Likelihood ratio of one link against a link per record, which needs no parabola.
  void CompareWithOwnFits() {
    double statistic = outcome_.chi2;
    for (std::size_t r = 0; r < used_.size(); ++r) statistic -= Record(r).own.chi2;
    SharingTest test;
    test.statistic = std::max(0.0, statistic);
    test.dof = (1 + 2.0 * result_.sliders) * static_cast<double>(used_.size() - 1);
    test.p_value = CalcChiSquareTail(test.statistic, test.dof);
    test.shared = test.p_value >= kSharingLevel;
    if (test.shared) result_.sharing = test;
    result_.shared = test.shared;
  }

  /// A link per record needs no joint fit: each record's own fit is its best.
  void CollectOwnFits() {
    const int evaluations = outcome_.evaluations;
    outcome_ = {};
    outcome_.evaluations = evaluations;
    outcome_.converged = true;
    for (std::size_t r = 0; r < used_.size(); ++r) outcome_.converged &= Record(r).own.converged;
  }

  /// Joint fits from the links of two records (the best described one and the middle one): one alone may be a bad
  /// start, since single records hardly determine how stiffness and friction are spread.
  FitOutcome FitShared() {
    std::vector<std::size_t> order(used_.size());
    for (std::size_t r = 0; r < order.size(); ++r) order[r] = r;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return Record(a).own.chi2 / static_cast<double>(data_[a].size) <
             Record(b).own.chi2 / static_cast<double>(data_[b].size);
    });
    FitOutcome best;
    const std::size_t tries = result_.sliders == 1 ? 1 : 2;
    for (std::size_t i = 0; i < tries; ++i) {
      FitState state = Record(order[i * (order.size() / 2)]).own.state;
      state.starts.clear();
      for (std::size_t r = 0; r < used_.size(); ++r) state.starts.push_back(Record(r).own.state.starts[0]);
      KeepBetter(
          Fit(data_, Sharing::kLink, state,
              {.max_iterations = kSloppyIterations, .function_tolerance = kSloppyTolerance, .threads = threads_}),
          &best);
    }
    return best;
  }

  /// The final link, start and misfit of a record.
  void Take(std::size_t r) {
    RecordResult& record = Record(r);
    const FitState& own = record.own.state;
    const Levels& levels = result_.shared ? outcome_.state.levels[0] : own.levels[0];
    const Shape& shape = result_.shared ? outcome_.state.shape : own.shape;
    record.start = result_.shared ? outcome_.state.starts[r] : own.starts[0];
    record.link = ToOscillator(levels, shape, record.record.g);
    informations_.push_back(result_.shared
                                ? CalcInformation(data_[r], levels, shape, record.start, CalcPeriod(record.phases))
                                : record.information);
    record.rms = informations_[r].rms;
  }

  double MeanVarianceFactor() const {
    double sum = 0;
    for (const LinkInformation& information : informations_) sum += information.variance_factor;
    return sum / static_cast<double>(informations_.size());
  }

  /// One link for all: information adds up; what disagreement there is widens the bounds.
  void FinishShared() {
    Eigen::MatrixXd information = informations_[0].information;
    for (std::size_t r = 1; r < informations_.size(); ++r) information += informations_[r].information;
    double factor = MeanVarianceFactor();
    if (result_.sharing.p_value < kDoubtLevel) factor *= std::max(1.0, result_.sharing.statistic / result_.sharing.dof);
    const Eigen::MatrixXd covariance = CalcCovariance(information, factor);
    result_.link = ToOscillator(outcome_.state.levels[0], outcome_.state.shape, result_.g);
    Profile(covariance, factor);
    FinishCovariance(covariance);
  }

  /// Bounds of every quantity of the shared link from its profile; the profiles are independent of each other.
  void Profile(const Eigen::MatrixXd& covariance, double factor) {
    const int n = result_.sliders;
    result_.quantities.assign(static_cast<std::size_t>(CountQuantities(n)), {});
    std::mutex counting;
    ParallelFor(result_.quantities.size(), threads_, [&](std::size_t q) {
      const int quantity = static_cast<int>(q);
      if (n == 1 && quantity > 2) return;
      int evaluations = 0;
      result_.quantities[q] = ProfileQuantity(data_, outcome_, quantity, covariance, factor, &evaluations);
      const std::lock_guard lock(counting);
      outcome_.evaluations += evaluations;
    });
    if (n == 1) {
      result_.quantities[3] = result_.quantities[1];
      result_.quantities[4] = result_.quantities[2];
    }
  }

  /// A link per record: means and spreads of the levels, and of the shape where there is one.
  void FinishHierarchical() {
    const std::array<Population, 3> populations = {DescribeLevel(0), DescribeLevel(1), DescribeLevel(2)};
    const int n = result_.sliders;
    const Eigen::Index size = 2 * static_cast<Eigen::Index>(n - 1);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3 + size, 3 + size);
    covariance.topLeftCorner<3, 3>() = CorrelateLevels(populations);
    VectorPopulation shapes;
    Shape shape;
    if (n > 1) {
      shapes = DescribeShapes();
      shape.assign(shapes.mean.begin(), shapes.mean.end());
      covariance.bottomRightCorner(size, size) = shapes.covariance;
    }
    result_.link = ToOscillator({populations[0].mean, populations[1].mean, populations[2].mean}, shape, result_.g);
    DescribeSums(populations);
    for (int quantity = 1; n > 1 && quantity <= 2 * n; ++quantity)
      result_.quantities[static_cast<std::size_t>(quantity)] =
          DescribeSlider(quantity, populations[quantity <= n ? 1 : 2], shapes);
    FinishCovariance(covariance);
  }

  /// Errors at the level of the noise: what the model lacks shifts all records alike and is no scatter.
  Population DescribeLevel(std::size_t level) {
    std::vector<double> values, errors;
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const Eigen::MatrixXd covariance = CalcCovariance(informations_[r].information, 1);
      const auto j = static_cast<Eigen::Index>(level);
      values.push_back(Record(r).own.state.levels[0][level]);
      errors.push_back(std::sqrt(covariance(j, j)));
    }
    return EstimatePopulation(values, errors);
  }

  /// Covariance of the means of the levels: correlated as the levels of the records are.
  Eigen::Matrix3d CorrelateLevels(const std::array<Population, 3>& populations) {
    Eigen::MatrixXd logs(static_cast<Eigen::Index>(used_.size()), 3);
    for (std::size_t r = 0; r < used_.size(); ++r)
      logs.row(static_cast<Eigen::Index>(r)) =
          Eigen::Map<const Eigen::RowVector3d>(Record(r).own.state.levels[0].data());
    const Eigen::MatrixXd centred = logs.rowwise() - logs.colwise().mean();
    const Eigen::Matrix3d sample = centred.transpose() * centred;
    Eigen::Matrix3d covariance;
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index j = 0; j < 3; ++j)
        covariance(i, j) = populations[static_cast<std::size_t>(i)].std * populations[static_cast<std::size_t>(j)].std *
                           (i == j ? 1 : sample(i, j) / std::sqrt(sample(i, i) * sample(j, j)));
    return covariance;
  }

  /// Every joint seats by itself, all stiffnesses with the same relative scatter and all frictions with another one.
  /// In the shape, logarithms of ratios to the first slider, such scatter has the covariance s^2 (1 + delta_ij).
  VectorPopulation DescribeShapes() {
    const Eigen::Index block = result_.sliders - 1;
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(2 * block, 2 * block), friction = stiffness;
    stiffness.topLeftCorner(block, block).setOnes().diagonal().setConstant(2);
    friction.bottomRightCorner(block, block).setOnes().diagonal().setConstant(2);
    std::vector<Eigen::VectorXd> values;
    std::vector<Eigen::MatrixXd> errors;
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const Shape& shape = Record(r).own.state.shape;
      values.emplace_back(Eigen::Map<const Eigen::VectorXd>(shape.data(), 2 * block));
      errors.emplace_back(CalcCovariance(informations_[r].information, informations_[r].variance_factor)
                              .bottomRightCorner(2 * block, 2 * block));
    }
    return EstimateVectorPopulation(values, errors, {stiffness, friction});
  }

  void DescribeSums(const std::array<Population, 3>& populations) {
    const int n = result_.sliders;
    result_.quantities.assign(static_cast<std::size_t>(CountQuantities(n)), {});
    const auto from_level = [&](int quantity, std::size_t level) {
      const Population& population = populations[level];
      const double value = std::exp(population.mean);
      result_.quantities[static_cast<std::size_t>(quantity)] = {.value = value,
                                                                .std = value * population.std,
                                                                .low = value * std::exp(-population.half_width),
                                                                .high = value * std::exp(population.half_width),
                                                                .spread = value * population.spread};
    };
    from_level(0, 0);
    from_level(SumOfStiffness(n), 1);
    from_level(SumOfFriction(n), 2);
    if (n > 1) return;
    from_level(1, 1);
    from_level(2, 2);
  }

  /// A slider is its share times the sum: relative errors add in quadrature. Of the share's error the part that the
  /// readings make is normal, the part that the records' scatter makes is known from few records only.
  Estimate DescribeSlider(int quantity, const Population& sum, const VectorPopulation& shapes) {
    const int n = result_.sliders;
    const Eigen::RowVectorXd gradient = CalcLogGradient(result_.link, ShareOf(n, quantity)).tail(2 * (n - 1));
    const auto variance = [&](const Eigen::MatrixXd& c) { return (gradient * c * gradient.transpose())(0, 0); };
    const double total = variance(shapes.covariance), error = std::min(total, variance(shapes.error_covariance));
    const double normal = CalcStudentBound(0.95, std::numeric_limits<double>::infinity());
    const double student = CalcStudentBound(0.95, static_cast<double>(used_.size() - 1));
    const double half_width =
        std::sqrt(std::pow(sum.half_width, 2) + normal * normal * error + student * student * (total - error));
    const double seat = shapes.spread(quantity <= n ? 0 : 1);
    Estimate estimate{.value = CalcQuantity(result_.link, quantity)};
    estimate.std = estimate.value * std::hypot(sum.std, std::sqrt(total));
    estimate.low = estimate.value * std::exp(-half_width);
    estimate.high = estimate.value * std::exp(half_width);
    estimate.low_open = estimate.high_open = half_width > kUndetermined;
    estimate.spread = estimate.value * seat;
    return estimate;
  }

  /// Covariance, bounds and words, all widened by what the model lacks, as far as growing windows show it.
  void FinishCovariance(Eigen::MatrixXd covariance) {
    Levels drift{};
    for (std::size_t r = 0; r < used_.size(); ++r)
      for (std::size_t j = 0; j < drift.size(); ++j) drift[j] += Record(r).drift[j] / static_cast<double>(used_.size());
    for (std::size_t q = 0; q < result_.quantities.size(); ++q)
      Widen(drift[LevelOf(result_.sliders, q)], &result_.quantities[q]);
    for (Eigen::Index j = 0; j < 3; ++j) covariance(j, j) += std::pow(0.5 * drift[static_cast<std::size_t>(j)], 2);
    result_.covariance = CalcNaturalCovariance(result_.link, covariance);
    result_.unidentifiable = NameUnidentifiable(result_.link, covariance);
  }

  void FinishRecords() {
    double squares = 0, noise = 0, samples = 0;
    result_.whiteness_p = 1;
    for (std::size_t r = 0; r < used_.size(); ++r) {
      RecordResult& record = Record(r);
      const auto n = static_cast<double>(data_[r].size);
      squares += n * record.rms * record.rms;
      noise += n * data_[r].sigma * data_[r].sigma;
      samples += n;
      result_.whiteness_p = std::min(result_.whiteness_p, informations_[r].whiteness.p_value);
      result_.evaluations += record.own.evaluations;
    }
    result_.rms = std::sqrt(squares / samples);
    result_.noise = std::sqrt(noise / samples);
    if (used_.size() > 1) result_.evaluations += outcome_.evaluations;
    if (!outcome_.converged)
      result_.warnings.emplace_back("the fit has not settled on its values; they may still move within their bounds");
    WarnOfStrayedRecords();
  }

  /// A fit that leaves a fifth of the motion unexplained does not describe the record, whatever its bounds say.
  void WarnOfStrayedRecords() {
    constexpr double kStrayed = 0.2;
    std::string strayed;
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const FitData& data = data_[r];
      double squares = 0;
      for (std::size_t i = 0; i < data.size; ++i) {
        const double y = data.record->y[data.first + i] - Record(r).start[2];
        squares += y * y;
      }
      if (Record(r).rms < kStrayed * std::sqrt(squares / static_cast<double>(data.size))) continue;
      strayed += (strayed.empty() ? "" : ", ") + data.record->file;
    }
    if (!strayed.empty())
      result_.warnings.push_back("the model does not follow the motion of " + strayed +
                                 ": its parameters do not describe it");
  }

  Identification& result_;
  std::vector<std::size_t> used_;
  int threads_;
  std::vector<FitData> data_;
  FitOutcome outcome_;
  std::vector<LinkInformation> informations_;
};

}  // namespace

SharingTest TestSharing(const Identification& result) {
  const std::vector<std::size_t> used = result.UsedIndices();
  SharingTest test;
  if (used.size() < 2) return test;
  Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  std::vector<Eigen::Matrix3d> informations;
  std::vector<Eigen::Vector3d> levels;
  for (const std::size_t i : used) {
    const RecordResult& record = result.records[i];
    informations.push_back(LevelInformation(record.information));
    levels.emplace_back(record.own.state.levels[0].data());
    total += informations.back();
    weighted += informations.back() * levels.back();
  }
  const Eigen::Vector3d common = total.ldlt().solve(weighted);
  for (std::size_t i = 0; i < used.size(); ++i)
    test.statistic += (levels[i] - common).dot(informations[i] * (levels[i] - common));
  test.dof = 3.0 * static_cast<double>(used.size() - 1);
  test.p_value = CalcChiSquareTail(test.statistic, test.dof);
  test.shared = test.p_value >= kSharingLevel;
  return test;
}

void FitJointly(int threads, Identification* result) { JointFit(threads, result).Run(); }

}  // namespace uiclink
