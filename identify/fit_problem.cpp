#include "identify/fit_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "model/event_solver.h"
#include "model/trajectory.h"

namespace uiclink {
namespace {

constexpr int kLevels = 3;
constexpr int kStart = 3;

/// Limits of the logarithms: stiffnesses between 1e-3 and 1e4 1/m, friction between 1e-7 and 1 of the load. A thousand
/// times beyond every link; they only keep a fit without information from running away.
constexpr std::array<double, kLevels> kLowest = {-6.9, -6.9, -16.1};
constexpr std::array<double, kLevels> kHighest = {9.2, 9.2, 0.0};
/// A slider of less than exp(-12) of the largest is not there.
constexpr double kWidestShape = 12;

std::vector<double> Shares(const double* logs, int n) {
  std::vector<double> shares(static_cast<std::size_t>(n));
  double largest = 0, sum = 0;
  for (int i = 1; i < n; ++i) largest = std::max(largest, logs[i - 1]);
  for (int i = 0; i < n; ++i) {
    shares[static_cast<std::size_t>(i)] = std::exp((i == 0 ? 0.0 : logs[i - 1]) - largest);
    sum += shares[static_cast<std::size_t>(i)];
  }
  for (double& share : shares) share /= sum;
  return shares;
}

Oscillator<double> MakeLink(const double* levels, const double* shape, int n, double g) {
  const std::vector<double> stiffness = Shares(shape, n);
  const std::vector<double> friction = Shares(shape + (n - 1), n);
  Oscillator<double> link;
  link.g = g;
  link.k = std::exp(levels[0]);
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
    link.Add({.k = std::exp(levels[1]) * stiffness[i], .T0 = std::exp(levels[2]) * friction[i]});
  return link;
}

struct Sums {
  double stiffness = 0;
  double friction = 0;
};

Sums SumSliders(const Oscillator<double>& link) {
  Sums sums;
  for (const Slider<double>& s : link.sliders()) {
    sums.stiffness += s.k;
    sums.friction += s.T0;
  }
  return sums;
}

SampleTimes TimesSince(const FitData& data, std::size_t size, double t0, std::vector<double>* scratch) {
  const std::vector<double>& t = data.record->t;
  if (data.record->uniform) return {.first = t[data.first] - t0, .step = 1.0 / data.record->sampling_hz, .size = size};
  scratch->resize(size);
  for (std::size_t i = 0; i < size; ++i) (*scratch)[i] = t[data.first + i] - t0;
  return {.size = size, .times = *scratch};
}

/// The link with its derivatives by the coordinates of the fit (levels, shape); the last dual is left to the start.
template <int n>
Oscillator<Dual<2 * n + 2>> SeedDerivatives(const Oscillator<double>& link) {
  using Scalar = Dual<2 * n + 2>;
  const Eigen::MatrixXd natural = CalcNaturalDerivatives(link);
  const auto seed = [&](double value, Eigen::Index row) {
    Scalar scalar(value);
    for (Eigen::Index c = 0; c < natural.cols(); ++c) scalar.v(c) = natural(row, c);
    return scalar;
  };
  Oscillator<Scalar> dual;
  dual.g = link.g;
  dual.k = seed(link.k, 0);
  for (int i = 0; i < n; ++i) {
    const Slider<double>& slider = link.sliders()[static_cast<std::size_t>(i)];
    dual.Add({.k = seed(slider.k, 1 + i), .T0 = seed(slider.T0, 1 + n + i)});
  }
  return dual;
}

/// Memory of one record's evaluations, kept from call to call.
template <int n>
struct Workspace {
  static constexpr int kDuals = 2 * n + 2;
  Trajectory<double> plain;
  Trajectory<Dual<kDuals>> dual;
  std::vector<double> y, v, dy, times;
  int evaluations = 0;
};

/// Residuals (model - reading)/sigma of one record over blocks levels, shape (absent for one slider), start.
template <int n>
class RecordCost final : public ceres::CostFunction {
 public:
  RecordCost(const FitData& data, std::size_t size, Workspace<n>* workspace)
      : data_(data), size_(size), workspace_(*workspace) {
    set_num_residuals(static_cast<int>(size));
    mutable_parameter_block_sizes()->push_back(kLevels);
    if constexpr (n > 1) mutable_parameter_block_sizes()->push_back(2 * (n - 1));
    mutable_parameter_block_sizes()->push_back(kStart);
    workspace_.y.resize(size);
    workspace_.v.resize(size);
    workspace_.dy.resize(size * Workspace<n>::kDuals);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    ++workspace_.evaluations;
    constexpr std::size_t kStartBlock = n > 1 ? 2 : 1;
    const double* start = parameters[kStartBlock];
    const Oscillator<double> link = MakeLink(parameters[0], n > 1 ? parameters[1] : nullptr, n, data_.g);
    const SampleTimes times = TimesSince(data_, size_, start[1], &workspace_.times);
    const double duration = std::max(0.0, times[size_ - 1]);
    if (jacobians == nullptr) {
      if (Solve(link, AtExtremum(link, start[0]), duration, &workspace_.plain) != SolveStatus::kOk) return false;
      CalcDisplacements(workspace_.plain, times, workspace_.y);
    } else {
      constexpr int N = Workspace<n>::kDuals;
      const Oscillator<Dual<N>> dual = SeedDerivatives<n>(link);
      const State<Dual<N>> state = AtExtremum(dual, Dual<N>(start[0], N - 1));
      if (Solve(dual, state, duration, &workspace_.dual) != SolveStatus::kOk) return false;
      CalcDisplacements(workspace_.dual, times, workspace_.y, workspace_.v, workspace_.dy);
      FillJacobians(jacobians[0], n > 1 ? jacobians[1] : nullptr, jacobians[kStartBlock]);
    }
    const double* reading = data_.record->y.data() + data_.first;
    const double weight = 1 / data_.sigma;
    for (std::size_t i = 0; i < size_; ++i) residuals[i] = weight * (start[2] + workspace_.y[i] - reading[i]);
    return true;
  }

 private:
  const double* Column(int dual) const { return workspace_.dy.data() + static_cast<std::size_t>(dual) * size_; }

  /// From columns to the rows that Ceres wants.
  void FillRows(int first_dual, int width, double* rows) const {
    const double weight = 1 / data_.sigma;
    for (int c = 0; c < width; ++c) {
      const double* column = Column(first_dual + c);
      for (std::size_t i = 0; i < size_; ++i)
        rows[i * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)] = weight * column[i];
    }
  }

  void FillJacobians(double* levels, double* shape, double* start) const {
    constexpr int kShape = 2 * (n - 1);
    if (levels != nullptr) FillRows(0, kLevels, levels);
    if (n > 1 && shape != nullptr) FillRows(kLevels, kShape, shape);
    if (start == nullptr) return;
    const double weight = 1 / data_.sigma;
    const double* by_y0 = Column(kLevels + kShape);
    for (std::size_t i = 0; i < size_; ++i) {
      start[kStart * i] = weight * by_y0[i];
      start[kStart * i + 1] = -weight * workspace_.v[i];
      start[kStart * i + 2] = weight;
    }
  }

  FitData data_;
  std::size_t size_;
  Workspace<n>& workspace_;
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
    const Oscillator<double> link = MakeLink(parameters[0], sliders_ > 1 ? parameters[1] : nullptr, sliders_, 1.0);
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

/// A wall at critical displacements below what the record resolves; nothing above it.
class ResolvedCost final : public ceres::CostFunction {
 public:
  ResolvedCost(int sliders, double smallest) : sliders_(sliders), log_smallest_(std::log(smallest)) {
    set_num_residuals(sliders);
    mutable_parameter_block_sizes()->push_back(kLevels);
    if (sliders > 1) mutable_parameter_block_sizes()->push_back(2 * (sliders - 1));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    // So steep that a pull of 1e5 sums of squares per unit of the logarithm enters the wall by 1e-3.
    constexpr double kSteepness = 1e4;
    const Oscillator<double> link = MakeLink(parameters[0], sliders_ > 1 ? parameters[1] : nullptr, sliders_, 1.0);
    for (int i = 0; i < sliders_; ++i) {
      const Slider<double>& slider = link.sliders()[static_cast<std::size_t>(i)];
      const double inside = log_smallest_ - std::log(slider.T0 / slider.k);
      residuals[i] = kSteepness * std::max(0.0, inside);
      if (jacobians == nullptr) continue;
      Eigen::RowVectorXd gradient = CalcLogGradient(link, 1 + i) - CalcLogGradient(link, 1 + sliders_ + i);
      gradient *= inside > 0 ? kSteepness : 0.0;
      const int shape = 2 * (sliders_ - 1);
      if (jacobians[0] != nullptr)
        for (int j = 0; j < kLevels; ++j) jacobians[0][i * kLevels + j] = gradient(j);
      if (sliders_ > 1 && jacobians[1] != nullptr)
        for (int j = 0; j < shape; ++j) jacobians[1][i * shape + j] = gradient(kLevels + j);
    }
    return true;
  }

 private:
  int sliders_;
  double log_smallest_;
};

/// True when the sum of squares hardly fell any more when the iterations ran out: along a direction that the data do not
/// determine a fit creeps for ever, and nothing that they do determine changes.
bool CreptAtLast(const ceres::Solver::Summary& summary) {
  constexpr std::size_t kLast = 10;
  constexpr double kHardly = 1e-3;
  const std::size_t n = summary.iterations.size();
  if (summary.termination_type != ceres::NO_CONVERGENCE || n <= kLast) return false;
  return summary.iterations[n - kLast - 1].cost - summary.final_cost < kHardly * summary.final_cost;
}

std::size_t SamplesWithin(const FitData& data, double seconds) {
  const auto begin = data.record->t.begin() + static_cast<std::ptrdiff_t>(data.first);
  const auto end = begin + static_cast<std::ptrdiff_t>(data.size);
  return static_cast<std::size_t>(std::upper_bound(begin, end, data.record->t[data.first] + seconds) - begin);
}

/// A fit in progress: the unknowns and the memory of all evaluations.
template <int n>
class Fitter {
 public:
  Fitter(std::span<const FitData> data, Sharing sharing, const FitState& initial)
      : data_(data), sharing_(sharing), workspaces_(data.size()), outcome_{.state = initial} {}

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
          new RecordCost<n>(data_[r], std::min(sizes[r], data_[r].size), &workspaces_[r]), nullptr, parameters));
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
      problem.AddResidualBlock(new HoldCost(n, control.held->first, control.held->second, 1e6), nullptr, link);
    for (std::size_t r = 0; r < outcome_.state.levels.size(); ++r) {
      if (!(data_[r].smallest > 0)) continue;
      link[0] = LevelsBlock(r);
      problem.AddResidualBlock(new ResolvedCost(n, data_[r].smallest), nullptr, link);
    }
    ceres::Solver::Options options;
    options.minimizer_type = ceres::TRUST_REGION;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = last ? control.max_iterations : 20;
    options.function_tolerance = last ? control.function_tolerance : 1e-3;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = last ? 1e-12 : 1e-5;
    options.num_threads = control.threads;
    if (data_.size() == 1) {
      options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;  // a dozen well scaled columns, thousands of rows
    } else {
      options.linear_solver_type = ceres::DENSE_SCHUR;
      options.linear_solver_ordering = ordering;
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    outcome_.window_levels.push_back(outcome_.state.levels[0]);
    if (!last) return;
    outcome_.evaluations = 0;
    for (const Workspace<n>& workspace : workspaces_) outcome_.evaluations += workspace.evaluations;
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
  std::vector<Workspace<n>> workspaces_;
  FitOutcome outcome_;
};

template <int n>
Linearisation LineariseWith(const FitData& data, const Levels& levels, const Shape& shape, const Start& start) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto rows = static_cast<Eigen::Index>(data.size);
  Workspace<n> workspace;
  const RecordCost<n> cost(data, data.size, &workspace);
  RowMajor by_levels(rows, kLevels), by_shape(rows, std::max(1, 2 * (n - 1))), by_start(rows, kStart);
  Linearisation result;
  result.residuals.resize(rows);
  std::vector<const double*> parameters = {levels.data()};
  std::vector<double*> jacobians = {by_levels.data()};
  if (n > 1) {
    parameters.push_back(shape.data());
    jacobians.push_back(by_shape.data());
  }
  parameters.push_back(start.data());
  jacobians.push_back(by_start.data());
  result.jacobian.setZero(rows, kLevels + 2 * (n - 1) + kStart);
  if (!cost.Evaluate(parameters.data(), result.residuals.data(), jacobians.data())) {
    result.residuals.setConstant(std::numeric_limits<double>::infinity());
    return result;
  }
  result.jacobian.leftCols(kLevels) = by_levels;
  if (n > 1) result.jacobian.middleCols(kLevels, 2 * (n - 1)) = by_shape.leftCols(2 * (n - 1));
  result.jacobian.rightCols(kStart) = by_start;
  return result;
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

int CountSliders(const Shape& shape) { return static_cast<int>(shape.size() / 2) + 1; }

Oscillator<double> ToOscillator(const Levels& levels, const Shape& shape, double g) {
  return MakeLink(levels.data(), shape.data(), CountSliders(shape), g);
}

void FromOscillator(const Oscillator<double>& oscillator, Levels* levels, Shape* shape) {
  const std::size_t n = oscillator.sliders().size();
  const Sums sums = SumSliders(oscillator);
  *levels = {std::log(oscillator.k), std::log(sums.stiffness), std::log(sums.friction)};
  shape->assign(2 * (n - 1), 0.0);
  for (std::size_t i = 1; i < n; ++i) {
    (*shape)[i - 1] = std::log(oscillator.sliders()[i].k / oscillator.sliders()[0].k);
    (*shape)[n - 1 + i - 1] = std::log(oscillator.sliders()[i].T0 / oscillator.sliders()[0].T0);
  }
}

Eigen::MatrixXd CalcNaturalDerivatives(const Oscillator<double>& link) {
  const int n = link.size();
  const Sums sums = SumSliders(link);
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(1 + 2 * n, kLevels + 2 * (n - 1));
  d(0, 0) = link.k;
  for (int i = 0; i < n; ++i) {
    const Slider<double>& s = link.sliders()[static_cast<std::size_t>(i)];
    d(1 + i, 1) = s.k;
    d(1 + n + i, 2) = s.T0;
    for (int j = 1; j < n; ++j) {
      const Slider<double>& other = link.sliders()[static_cast<std::size_t>(j)];
      d(1 + i, kLevels + j - 1) = s.k * ((i == j ? 1.0 : 0.0) - other.k / sums.stiffness);
      d(1 + n + i, kLevels + n - 1 + j - 1) = s.T0 * ((i == j ? 1.0 : 0.0) - other.T0 / sums.friction);
    }
  }
  return d;
}

int CountQuantities(int sliders) { return 2 * sliders + 3; }

double CalcQuantity(const Oscillator<double>& link, int quantity) {
  const int n = link.size();
  const Sums sums = SumSliders(link);
  if (quantity == SumOfStiffness(n)) return sums.stiffness;
  if (quantity == SumOfFriction(n)) return sums.friction;
  const int of_share = quantity - CountQuantities(n) + 1;
  if (of_share > 0) return CalcQuantity(link, of_share) / (of_share <= n ? sums.stiffness : sums.friction);
  if (quantity == 0) return link.k;
  return quantity <= n ? link.sliders()[static_cast<std::size_t>(quantity - 1)].k
                       : link.sliders()[static_cast<std::size_t>(quantity - 1 - n)].T0;
}

Eigen::RowVectorXd CalcLogGradient(const Oscillator<double>& link, int quantity) {
  const int n = link.size();
  const int of_share = quantity - CountQuantities(n) + 1;
  if (of_share > 0)
    return CalcLogGradient(link, of_share) -
           CalcLogGradient(link, of_share <= n ? SumOfStiffness(n) : SumOfFriction(n));
  Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(kLevels + 2 * (n - 1));
  if (quantity == SumOfStiffness(n)) {
    gradient(1) = 1;
  } else if (quantity == SumOfFriction(n)) {
    gradient(2) = 1;
  } else {
    gradient = CalcNaturalDerivatives(link).row(quantity) / CalcQuantity(link, quantity);
  }
  return gradient;
}

std::string QuantityName(int sliders, int quantity) {
  if (quantity == SumOfStiffness(sliders)) return "sum_ki";
  if (quantity == SumOfFriction(sliders)) return "sum_T0i";
  return ParameterSymbols(sliders)[static_cast<std::size_t>(quantity)];
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
