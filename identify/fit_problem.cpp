#include "identify/fit_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "identify/compressed_rows.h"
#include "identify/record_columns.h"
#include "identify/resolved_cost.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr int kStart = 3;

/// Residuals (model - reading)/sigma of one record over blocks levels, shape (absent for one slider), start, compressed
/// to as many rows as there are unknowns and one more.
template <int n>
class RecordCost final : public ceres::CostFunction {
 public:
  RecordCost(const FitData& data, std::size_t size, RecordColumns<n>* columns)
      : data_(data), size_(size), columns_(*columns) {
    set_num_residuals(kUnknowns + 1);
    mutable_parameter_block_sizes()->push_back(kLevels);
    if constexpr (n > 1) mutable_parameter_block_sizes()->push_back(2 * (n - 1));
    mutable_parameter_block_sizes()->push_back(kStart);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    constexpr std::size_t kStartBlock = n > 1 ? 2 : 1;
    const double* start = parameters[kStartBlock];
    const Oscillator<double> link = ToOscillator(parameters[0], n > 1 ? parameters[1] : nullptr, n, data_.g);
    Eigen::Map<Eigen::Matrix<double, kUnknowns + 1, 1>> rows(residuals);
    if (jacobians == nullptr) {  // only the sum of squares is asked for
      if (!columns_.Evaluate(data_, size_, link, start)) return false;
      rows.setZero();
      rows(kUnknowns) = columns_.Map().col(kUnknowns).norm() / data_.sigma;
      return true;
    }
    if (!columns_.EvaluateWithDerivatives(data_, size_, link, start)) return false;
    const CompressedRows<kUnknowns> compressed = Compress<kUnknowns>(CalcGram());
    rows << compressed.residuals, compressed.rest;
    CopyColumns<0, kLevels>(compressed, jacobians[0]);
    if constexpr (n > 1) CopyColumns<kLevels, 2 * (n - 1)>(compressed, jacobians[1]);
    CopyColumns<kUnknowns - kStart, kStart>(compressed, jacobians[kStartBlock]);
    return true;
  }

 private:
  static constexpr int kUnknowns = RecordColumns<n>::kUnknowns;

  /// Lower triangle of [J r]'[J r], in units of sigma.
  Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1> CalcGram() const {
    Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1> gram =
        Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1>::Zero();
    const auto columns = columns_.Map();
    for (int j = 0; j <= kUnknowns; ++j)
      gram.col(j).tail(kUnknowns + 1 - j).noalias() = columns.rightCols(kUnknowns + 1 - j).transpose() * columns.col(j);
    return gram / (data_.sigma * data_.sigma);
  }

  /// Columns of R and a row of zeros for the rest, the way Ceres wants them; nothing for a block that is held.
  template <int first, int width>
  static void CopyColumns(const CompressedRows<kUnknowns>& compressed,
                          double* block) {  // NOLINT(readability-non-const-parameter): the map writes
    if (block == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, kUnknowns + 1, width, Eigen::RowMajor>> rows(block);
    rows.template topRows<kUnknowns>() = compressed.jacobian.template middleCols<width>(first);
    rows.template bottomRows<1>().setZero();
  }

  FitData data_;
  std::size_t size_;
  RecordColumns<n>& columns_;
};

/// Keeps the logarithm of a quantity near a value. At the minimum the point lies on the profile of the quantity, at
/// the value that it has there, whatever the weight.
class HoldCost final : public ceres::CostFunction {
 public:
  HoldCost(int sliders, int quantity, double log_value, double weight)
      : sliders_(sliders), quantity_(quantity), log_value_(log_value), weight_(weight) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(kLevels);
    if (sliders > 1) mutable_parameter_block_sizes()->push_back(2 * (sliders - 1));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Oscillator<double> link = ToOscillator(parameters[0], sliders_ > 1 ? parameters[1] : nullptr, sliders_, 1.0);
    const double value = CalcQuantity(link, quantity_);
    residuals[0] = weight_ * (std::log(value) - log_value_);
    if (jacobians == nullptr) return true;
    const Eigen::RowVectorXd gradient = weight_ * CalcLogGradient(link, quantity_);
    if (jacobians[0] != nullptr)
      for (int i = 0; i < kLevels; ++i) jacobians[0][i] = gradient(i);
    if (sliders_ > 1 && jacobians[1] != nullptr)
      for (int i = 0; i < 2 * (sliders_ - 1); ++i) jacobians[1][i] = gradient(kLevels + i);
    return true;
  }

 private:
  int sliders_;
  int quantity_;
  double log_value_;
  double weight_;
};

/// True when the sum of squares hardly fell any more when the iterations ran out: along a direction that the data do
/// not determine a fit creeps for ever, and nothing that they do determine changes.
bool CreptAtLast(const ceres::Solver::Summary& summary) {
  constexpr std::size_t kLast = 10;
  constexpr double kHardly = 1e-3;
  const std::size_t n = summary.iterations.size();
  if (summary.termination_type != ceres::NO_CONVERGENCE || n <= kLast) return false;
  return summary.iterations[n - kLast - 1].cost - summary.final_cost < kHardly * summary.final_cost;
}

/// A fit in progress: the unknowns and the memory of all evaluations.
template <int n>
class Fitter {
 public:
  Fitter(std::span<const FitData> data, Sharing sharing, const FitState& initial)
      : data_(data), sharing_(sharing), columns_(data.size()), outcome_{.state = initial} {}

  FitOutcome Run(const FitControl& control) {
    for (const double window : control.window_s) {
      bool shorter = false;
      std::vector<std::size_t> sizes;
      for (const FitData& record : data_) {
        sizes.push_back(std::max<std::size_t>(kLevels + kStart + 1, SamplesWithin(record, window)));
        shorter |= sizes.back() < record.size;
      }
      if (shorter) Minimise(sizes, control, /*last=*/false);
    }
    std::vector<std::size_t> sizes;
    for (const FitData& record : data_) sizes.push_back(record.size);
    Minimise(sizes, control, /*last=*/true);
    return outcome_;
  }

 private:
  double* LevelsBlock(std::size_t record) {
    return outcome_.state.levels[sharing_ == Sharing::kLink ? 0 : record].data();
  }

  void Minimise(const std::vector<std::size_t>& sizes, const FitControl& control, bool last) {
    ceres::Problem::Options ownership;
    ownership.disable_all_safety_checks = true;
    ceres::Problem problem(ownership);
    std::vector<ceres::ResidualBlockId> blocks;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t r = 0; r < data_.size(); ++r) {
      std::vector<double*> parameters = {LevelsBlock(r)};
      if (n > 1) parameters.push_back(outcome_.state.shape.data());
      parameters.push_back(outcome_.state.starts[r].data());
      blocks.push_back(problem.AddResidualBlock(
          new RecordCost<n>(data_[r], std::min(sizes[r], data_[r].size), &columns_[r]), nullptr, parameters));
      // The starts of the records are independent of each other given the link: they are eliminated first.
      ordering->AddElementToGroup(parameters.back(), 0);
      for (std::size_t i = 0; i + 1 < parameters.size(); ++i) ordering->AddElementToGroup(parameters[i], 1);
    }
    SetBounds(last, &problem);
    if (control.fix_link) FixLink(&problem);
    if (n > 1 && control.fix_shape) problem.SetParameterBlockConstant(outcome_.state.shape.data());
    std::vector<double*> link = {LevelsBlock(0)};
    if (n > 1) link.push_back(outcome_.state.shape.data());
    if (control.held)  // a pull that moves the quantity by far less than its distance from the minimum; see HoldCost
      problem.AddResidualBlock(new HoldCost(n, control.held->first, control.held->second, control.held_weight), nullptr,
                               link);
    for (std::size_t r = 0; r < outcome_.state.levels.size(); ++r) {
      const FitData limits = WidestLimits(sharing_ == Sharing::kLink ? data_ : data_.subspan(r, 1));
      if (!(limits.smallest > 0) && !(limits.swing > 0)) continue;
      link[0] = LevelsBlock(r);
      problem.AddResidualBlock(MakeResolvedCost(n, limits.smallest, limits.swing), nullptr, link);
    }
    ceres::Solver::Options options;
    options.minimizer_type = ceres::TRUST_REGION;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = last ? control.max_iterations : 20;
    options.function_tolerance = last ? control.function_tolerance : 1e-3;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = last ? 1e-12 : 1e-5;
    options.num_threads = std::min(CountThreads(control.threads), CountThreads(0));  // more end up in Ceres' log
    if (data_.size() == 1) {
      options.linear_solver_type = ceres::DENSE_QR;  // a dozen rows and columns
    } else {
      options.linear_solver_type = ceres::DENSE_SCHUR;
      options.linear_solver_ordering = ordering;
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    outcome_.window_levels.push_back(outcome_.state.levels[0]);
    if (!last) return;
    outcome_.evaluations = 0;
    for (const RecordColumns<n>& columns : columns_) outcome_.evaluations += columns.evaluations();
    outcome_.converged = summary.termination_type == ceres::CONVERGENCE || CreptAtLast(summary);
    outcome_.message = outcome_.converged ? "" : summary.message;
    outcome_.chi2_of_record.clear();
    outcome_.chi2 = 0;
    for (const ceres::ResidualBlockId block : blocks) {
      double half = std::numeric_limits<double>::infinity();
      problem.EvaluateResidualBlock(block, false, &half, nullptr, nullptr);
      outcome_.chi2_of_record.push_back(2 * half);
      outcome_.chi2 += 2 * half;
    }
  }

  void FixLink(ceres::Problem* problem) {
    for (Levels& levels : outcome_.state.levels) problem->SetParameterBlockConstant(levels.data());
    if constexpr (n > 1) problem->SetParameterBlockConstant(outcome_.state.shape.data());
  }

  /// In the growing windows the zero stays close to the centre of the late motion: over a few swings a shifted zero and
  /// a slider that never slides look alike, and a fit that has gone there does not come back.
  void SetBounds(bool last, ceres::Problem* problem) {
    const std::size_t blocks = sharing_ == Sharing::kLink ? 1 : data_.size();
    for (std::size_t r = 0; r < blocks; ++r)
      for (std::size_t i = 0; i < kLevels; ++i) {
        double& level = outcome_.state.levels[r][i];
        level = std::clamp(level, kLowest[i], kHighest[i]);
        problem->SetParameterLowerBound(LevelsBlock(r), static_cast<int>(i), kLowest[i]);
        problem->SetParameterUpperBound(LevelsBlock(r), static_cast<int>(i), kHighest[i]);
      }
    for (std::size_t r = 0; r < data_.size(); ++r) {
      if (!(data_[r].swing > 0)) continue;
      double& zero = outcome_.state.starts[r][2];
      const double reach = (last ? kZeroReach : kZeroReachOfWindows) * data_[r].swing;
      zero = std::clamp(zero, data_[r].centre - reach, data_[r].centre + reach);
      problem->SetParameterLowerBound(outcome_.state.starts[r].data(), 2, data_[r].centre - reach);
      problem->SetParameterUpperBound(outcome_.state.starts[r].data(), 2, data_[r].centre + reach);
    }
    if constexpr (n > 1) {
      Shape& shape = outcome_.state.shape;
      for (int i = 0; i < 2 * (n - 1); ++i) {
        double& s = shape[static_cast<std::size_t>(i)];
        s = std::clamp(s, -kWidestShape, kWidestShape);
        problem->SetParameterLowerBound(shape.data(), i, -kWidestShape);
        problem->SetParameterUpperBound(shape.data(), i, kWidestShape);
      }
    }
  }

  std::span<const FitData> data_;
  Sharing sharing_;
  std::vector<RecordColumns<n>> columns_;
  FitOutcome outcome_;
};

template <int n>
Linearisation LineariseWith(const FitData& data, const Levels& levels, const Shape& shape, const Start& start) {
  RecordColumns<n> columns;
  const Oscillator<double> link = ToOscillator(levels, shape, data.g);
  const bool solved = columns.EvaluateWithDerivatives(data, data.size, link, start.data());
  constexpr int kUnknowns = RecordColumns<n>::kUnknowns;
  if (!solved) {
    const auto rows = static_cast<Eigen::Index>(data.size);
    return {.jacobian = Eigen::MatrixXd::Zero(rows, kUnknowns),
            .residuals = Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::infinity())};
  }
  return {.jacobian = columns.Map().template leftCols<kUnknowns>() / data.sigma,
          .residuals = columns.Map().col(kUnknowns) / data.sigma};
}

/// Calls use.template operator()<n>() for the number of sliders.
template <typename Use>
auto WithSliders(int sliders, Use use) {
  switch (sliders) {
    case 1:
      return use.template operator()<1>();
    case 2:
      return use.template operator()<2>();
    case 3:
      return use.template operator()<3>();
    default:
      return use.template operator()<4>();
  }
}

}  // namespace

std::size_t SamplesWithin(const FitData& data, double seconds) {
  const auto begin = data.record->t.begin() + static_cast<std::ptrdiff_t>(data.first);
  const auto end = begin + static_cast<std::ptrdiff_t>(data.size);
  return static_cast<std::size_t>(std::upper_bound(begin, end, data.record->t[data.first] + seconds) - begin);
}

FitOutcome Fit(std::span<const FitData> data, Sharing sharing, const FitState& initial, const FitControl& control) {
  return WithSliders(CountSliders(initial.shape),
                     [&]<int n>() { return Fitter<n>(data, sharing, initial).Run(control); });
}

Linearisation Linearise(const FitData& data, const Levels& levels, const Shape& shape, const Start& start) {
  return WithSliders(CountSliders(shape), [&]<int n>() { return LineariseWith<n>(data, levels, shape, start); });
}

std::vector<double> CalcResiduals(const FitData& data, const Levels& levels, const Shape& shape, const Start& start) {
  const Oscillator<double> link = ToOscillator(levels, shape, data.g);
  std::vector<double> scratch, y(data.size);
  const SampleTimes times = TimesSince(data, data.size, start[1], &scratch);
  Trajectory<double> run;
  Solve(link, AtExtremum(link, start[0]), std::max(0.0, times[data.size - 1]), &run);
  CalcDisplacements(run, times, y);
  for (std::size_t i = 0; i < data.size; ++i) y[i] += start[2] - data.record->y[data.first + i];
  return y;
}

}  // namespace uiclink
