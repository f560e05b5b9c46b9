#include "identify/joint_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "identify/parallel.h"

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
    const Sharing sharing = result_.shared ? Sharing::kLink : Sharing::kShape;
    if (used_.size() == 1) {
      outcome_ = Record(0).own;
    } else if (!result_.shared && result_.sliders == 1) {
      Collect();  // one slider has no shape: the joint fit falls apart into the records' own fits
    } else {
      outcome_ = BestOfShapes(sharing);
    }
    SortSliders(&outcome_.state);
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const RecordResult& record = Record(r);
      informations_.push_back(CalcInformation(data_[r], outcome_.state.LevelsOf(r), outcome_.state.shape,
                                              outcome_.state.starts[r], CalcPeriod(record.phases)));
    }
    result_.shared || used_.size() == 1 ? FinishShared() : FinishHierarchical();
    FinishRecords();
  }

 private:
  RecordResult& Record(std::size_t r) { return result_.records[used_[r]]; }

  FitState StateFrom(const Shape& shape, bool shared) {
    FitState state;
    state.shape = shape;
    Levels mean{};
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const FitState& own = Record(r).own.state;
      state.starts.push_back(own.starts[0]);
      if (!shared) state.levels.push_back(own.levels[0]);
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += own.levels[0][i] / static_cast<double>(used_.size());
    }
    if (shared) state.levels = {mean};
    return state;
  }

  void Collect() {
    outcome_.state = StateFrom({}, /*shared=*/false);
    outcome_.converged = true;
    for (std::size_t r = 0; r < used_.size(); ++r) {
      outcome_.chi2_of_record.push_back(Record(r).own.chi2);
      outcome_.chi2 += Record(r).own.chi2;
      outcome_.converged &= Record(r).own.converged;
    }
  }

  /// Joint fits from the shapes of two records (the best described one and the middle one): one shape alone may be a
  /// bad start, since single records hardly determine it.
  FitOutcome BestOfShapes(Sharing sharing) {
    std::vector<std::size_t> order(used_.size());
    for (std::size_t r = 0; r < order.size(); ++r) order[r] = r;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return Record(a).own.chi2 / static_cast<double>(data_[a].size) <
             Record(b).own.chi2 / static_cast<double>(data_[b].size);
    });
    FitOutcome best;
    const std::size_t tries = result_.sliders == 1 ? 1 : std::min<std::size_t>(2, order.size());
    for (std::size_t i = 0; i < tries; ++i) {
      const Shape& shape = Record(order[i * (order.size() / 2)]).own.state.shape;
      KeepBetter(Fit(data_, sharing, StateFrom(shape, sharing == Sharing::kLink),
                     {.max_iterations = kSloppyIterations,
                      .function_tolerance = kSloppyTolerance,
                      .threads = CountThreads(threads_)}),
                 &best);
    }
    return best;
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
    Profile(Sharing::kLink, covariance, factor);
    FinishCovariance(covariance);
  }

  /// Bounds of every quantity of the shared link from its profile; the profiles are independent of each other.
  void Profile(Sharing sharing, const Eigen::MatrixXd& covariance, double factor) {
    const int n = result_.sliders;
    result_.quantities.assign(static_cast<std::size_t>(CountQuantities(n)), {});
    std::mutex counting;
    ParallelFor(result_.quantities.size(), threads_, [&](std::size_t q) {
      const int quantity = static_cast<int>(q);
      if (n == 1 && quantity > 2) return;
      int evaluations = 0;
      result_.quantities[q] = ProfileQuantity(data_, sharing, outcome_, quantity,
                                              CalcLogStd(result_.link, covariance, quantity), factor, &evaluations);
      const std::lock_guard lock(counting);
      outcome_.evaluations += evaluations;
    });
    if (n == 1) {
      result_.quantities[3] = result_.quantities[1];
      result_.quantities[4] = result_.quantities[2];
    }
  }

  /// A link per record: means and spreads of the levels; the shape, where there is one, is common.
  void FinishHierarchical() {
    const int n = result_.sliders;
    const std::size_t records = used_.size();
    Population populations[3];
    Eigen::MatrixXd logs(static_cast<Eigen::Index>(records), 3);
    Levels mean{};
    for (std::size_t j = 0; j < 3; ++j) {
      std::vector<double> values, errors;
      for (std::size_t r = 0; r < records; ++r) {
        const LinkInformation& information = informations_[r];
        // Errors at the level of the noise: what the model lacks shifts all records alike and is no scatter.
        const Eigen::MatrixXd covariance = CalcCovariance(information.information, 1);
        values.push_back(outcome_.state.levels[r][j]);
        errors.push_back(std::sqrt(covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(j))));
        logs(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(j)) = values.back();
      }
      populations[j] = EstimatePopulation(values, errors);
      mean[j] = populations[j].mean;
    }
    result_.link = ToOscillator(mean, outcome_.state.shape, result_.g);

    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3 + 2 * (n - 1), 3 + 2 * (n - 1));
    const Eigen::MatrixXd centred = logs.rowwise() - logs.colwise().mean();
    const Eigen::MatrixXd sample = centred.transpose() * centred;
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index j = 0; j < 3; ++j)
        covariance(i, j) =
            populations[i].std * populations[j].std * sample(i, j) / std::sqrt(sample(i, i) * sample(j, j));
    double factor = 1;
    if (n > 1) {
      const Eigen::MatrixXd shape = ShapeInformation(&factor);
      covariance.bottomRightCorner(2 * (n - 1), 2 * (n - 1)) = CalcCovariance(shape, factor);
    }
    FinishPopulation(populations, covariance, factor);
    FinishCovariance(covariance);
  }

  /// Information on the common shape, levels of the records eliminated, and its variance factor: the records are
  /// clusters, so that a shape that differs between them widens the bounds.
  Eigen::MatrixXd ShapeInformation(double* factor) {
    const Eigen::Index size = 2 * (result_.sliders - 1);
    Eigen::MatrixXd total = Eigen::MatrixXd::Zero(size, size);
    Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t r = 0; r < used_.size(); ++r) {
      const Linearisation at =
          Linearise(data_[r], outcome_.state.LevelsOf(r), outcome_.state.shape, outcome_.state.starts[r]);
      Eigen::MatrixXd nuisance(at.jacobian.rows(), 6);
      nuisance << at.jacobian.leftCols(3), at.jacobian.rightCols(3);
      const auto by_shape = at.jacobian.middleCols(3, size);
      const Eigen::MatrixXd absorbed = (nuisance.transpose() * nuisance).ldlt().solve(nuisance.transpose() * by_shape);
      const Eigen::MatrixXd projected = by_shape - nuisance * absorbed;
      const Eigen::VectorXd score = projected.transpose() * at.residuals;
      total += projected.transpose() * projected;
      scores += score * score.transpose();
    }
    const Eigen::MatrixXd unit = CalcCovariance(total, 1);
    const double records = static_cast<double>(used_.size());
    const double clusters = (unit * scores).trace() / static_cast<double>(size) * records / (records - 1);
    *factor = std::max(MeanVarianceFactor(), clusters);
    return total;
  }

  void FinishPopulation(const Population populations[3], const Eigen::MatrixXd& covariance, double factor) {
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
    if (n == 1) {
      from_level(1, 1);
      from_level(2, 2);
      return;
    }
    // A slider is its share, profiled, times the mean of the sum: relative errors add in quadrature.
    std::mutex counting;
    ParallelFor(static_cast<std::size_t>(2 * n), threads_, [&](std::size_t i) {
      const int quantity = 1 + static_cast<int>(i);
      const int share = ShareOf(n, quantity);
      int evaluations = 0;
      const Estimate profile = ProfileQuantity(data_, Sharing::kShape, outcome_, share,
                                               CalcLogStd(result_.link, covariance, share), factor, &evaluations);
      const Population& sum = populations[quantity <= n ? 1 : 2];
      Estimate estimate{.value = CalcQuantity(result_.link, quantity)};
      estimate.std = estimate.value * CalcLogStd(result_.link, covariance, quantity);
      estimate.low = estimate.value * std::exp(-std::hypot(std::log(profile.value / profile.low), sum.half_width));
      estimate.high = estimate.value * std::exp(std::hypot(std::log(profile.high / profile.value), sum.half_width));
      estimate.low_open = profile.low_open;
      estimate.high_open = profile.high_open;
      estimate.spread = estimate.value * sum.spread;
      result_.quantities[static_cast<std::size_t>(quantity)] = estimate;
      const std::lock_guard lock(counting);
      outcome_.evaluations += evaluations;
    });
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
      record.link = ToOscillator(outcome_.state.LevelsOf(r), outcome_.state.shape, record.record.g);
      record.start = outcome_.state.starts[r];
      record.rms = informations_[r].rms;
      const double n = static_cast<double>(data_[r].size);
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
      result_.warnings.push_back("the fit has not settled on its values; they may still move within their bounds");
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
