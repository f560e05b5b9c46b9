#include "identify/extended_fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "identify/compressed_rows.h"
#include "identify/extended_columns.h"
#include "identify/resolved_cost.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr int kStart = 3;

/// Residuals (model - reading)/sigma of one record over the blocks levels, shape, start, shared, own (those of no size
/// are absent), compressed to as many rows as there are unknowns and one more.
class ExtendedCost final : public ceres::CostFunction {
 public:
  ExtendedCost(const FitData& data, std::size_t size, std::size_t stride, const Extension& extension, int sliders,
               ExtendedColumns* columns)
      : data_(data), size_(size), stride_(stride), columns_(*columns) {
    widths_ = {kLevels, 2 * (sliders - 1), kStart, static_cast<int>(extension.shared().size()),
               static_cast<int>(extension.own().size())};
    for (const int width : widths_)
      if (width > 0) mutable_parameter_block_sizes()->push_back(width);
    set_num_residuals(columns_.CountUnknowns() + 1);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    std::array<const double*, 5> block{};
    std::array<double*, 5> jacobian{};
    for (std::size_t b = 0, next = 0; b < widths_.size(); ++b) {
      if (widths_[b] == 0) continue;
      block[b] = parameters[next];
      if (jacobians != nullptr) jacobian[b] = jacobians[next];
      ++next;
    }
    if (!columns_.Evaluate(data_, size_, stride_, block[0], block[1], block[2], block[3], block[4],
                           jacobians != nullptr))
      return false;
    const Eigen::Index p = columns_.CountUnknowns();
    Eigen::Map<Eigen::VectorXd> rows(residuals, p + 1);
    const auto columns = columns_.Map();
    if (jacobians == nullptr) {
      rows.setZero();
      rows(p) = columns.col(p).norm() / data_.sigma;
      return std::isfinite(rows(p));
    }
    Eigen::MatrixXd gram(p + 1, p + 1);
    for (Eigen::Index j = 0; j <= p; ++j)
      gram.col(j).tail(p + 1 - j).noalias() = columns.rightCols(p + 1 - j).transpose() * columns.col(j);
    gram /= data_.sigma * data_.sigma;
    const CompressedRows<Eigen::Dynamic> compressed = Compress<Eigen::Dynamic>(gram);
    rows << compressed.residuals, compressed.rest;
    Eigen::Index first = 0;
    for (std::size_t b = 0; b < widths_.size(); first += widths_[b++])
      CopyColumns(compressed, first, widths_[b], jacobian[b]);
    return rows.allFinite();
  }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  static void CopyColumns(const CompressedRows<Eigen::Dynamic>& compressed, Eigen::Index first, Eigen::Index width,
                          double* block) {  // NOLINT(readability-non-const-parameter): the map writes
    if (block == nullptr || width == 0) return;
    const Eigen::Index p = compressed.jacobian.cols();
    Eigen::Map<RowMajor> rows(block, p + 1, width);
    rows.topRows(p) = compressed.jacobian.middleCols(first, width);
    rows.bottomRows(1).setZero();
  }

  FitData data_;
  std::size_t size_, stride_;
  ExtendedColumns& columns_;
  std::array<int, 5> widths_{};
};

/// A fit in progress: the unknowns and the memory of all evaluations.
class ExtendedFitter {
 public:
  ExtendedFitter(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                 const ExtendedState& initial)
      : data_(data), sharing_(sharing), extension_(extension), sliders_(CountSliders(initial.link.shape)) {
    outcome_.state = initial;
    for (std::size_t r = 0; r < data.size(); ++r) columns_.emplace_back(extension_, sliders_);
  }

  ExtendedOutcome Run(const ExtendedControl& control) {
    for (ExtendedColumns& columns : columns_) columns.SetTolerance(control.step_tolerance);
    const auto fewest = static_cast<std::size_t>(columns_[0].CountUnknowns() + 1) * control.stride;
    std::vector<std::size_t> sizes(data_.size());
    for (const double window : control.window_s) {
      bool shorter = false;
      for (std::size_t r = 0; r < data_.size(); ++r) {
        sizes[r] = std::min(data_[r].size, std::max(fewest, SamplesWithin(data_[r], window)));
        shorter |= sizes[r] < data_[r].size;
      }
      if (shorter) Minimise(sizes, control, /*last=*/false);
    }
    for (std::size_t r = 0; r < data_.size(); ++r) sizes[r] = data_[r].size;
    Minimise(sizes, control, /*last=*/true);
    return outcome_;
  }

 private:
  FitState& link() { return outcome_.state.link; }
  double* LevelsBlock(std::size_t record) { return link().levels[sharing_ == Sharing::kLink ? 0 : record].data(); }

  double* ShapeBlock(std::size_t record) {
    return link().shapes.empty() ? link().shape.data() : link().shapes[record].data();
  }

  std::vector<double*> BlocksOf(std::size_t record) {
    std::vector<double*> blocks = {LevelsBlock(record)};
    if (sliders_ > 1) blocks.push_back(ShapeBlock(record));
    blocks.push_back(link().starts[record].data());
    if (!extension_.shared().empty()) blocks.push_back(outcome_.state.shared.data());
    if (!extension_.own().empty()) blocks.push_back(outcome_.state.own[record].data());
    return blocks;
  }

  void Minimise(const std::vector<std::size_t>& sizes, const ExtendedControl& control, bool last) {
    ceres::Problem::Options ownership;
    ownership.disable_all_safety_checks = true;
    ceres::Problem problem(ownership);
    std::vector<ceres::ResidualBlockId> blocks;
    for (std::size_t r = 0; r < data_.size(); ++r)
      blocks.push_back(problem.AddResidualBlock(
          new ExtendedCost(data_[r], sizes[r], control.stride, extension_, sliders_, &columns_[r]), nullptr,
          BlocksOf(r)));
    SetLinkBounds(last, &problem);
    SetEffectBounds(&problem);
    Fix(control, &problem);
    AddWalls(&problem);
    ceres::Solver::Options options;
    options.minimizer_type = ceres::TRUST_REGION;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = last ? control.max_iterations : 15;
    options.function_tolerance = last ? control.function_tolerance : 1e-3;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = last ? 1e-11 : 1e-5;
    options.num_threads = std::min(CountThreads(control.threads), CountThreads(0));  // more end up in Ceres' log
    options.linear_solver_type = ceres::DENSE_QR;                                    // a few dozen rows and columns
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!last) return;
    outcome_.evaluations = 0;
    for (const ExtendedColumns& columns : columns_) outcome_.evaluations += columns.evaluations();
    outcome_.converged = summary.termination_type == ceres::CONVERGENCE;
    outcome_.chi2_of_record.clear();
    outcome_.chi2 = 0;
    for (const ceres::ResidualBlockId block : blocks) {
      double half = std::numeric_limits<double>::infinity();
      if (!problem.EvaluateResidualBlock(block, false, &half, nullptr, nullptr))
        half = std::numeric_limits<double>::infinity();
      outcome_.chi2_of_record.push_back(2 * half);
      outcome_.chi2 += 2 * half;
    }
  }

  static void Bound(double low, double high, int index, double* block, ceres::Problem* problem) {
    block[index] = std::clamp(block[index], low, high);
    problem->SetParameterLowerBound(block, index, low);
    problem->SetParameterUpperBound(block, index, high);
  }

  void SetLinkBounds(bool last, ceres::Problem* problem) {
    for (std::size_t r = 0; r < link().levels.size(); ++r)
      for (int i = 0; i < kLevels; ++i)
        Bound(kLowest[static_cast<std::size_t>(i)], kHighest[static_cast<std::size_t>(i)], i, LevelsBlock(r), problem);
    for (std::size_t r = 0; r < data_.size(); ++r) {
      if (!(data_[r].swing > 0)) continue;
      const double reach = (last ? kZeroReach : kZeroReachOfWindows) * data_[r].swing;
      Bound(data_[r].centre - reach, data_[r].centre + reach, 2, link().starts[r].data(), problem);
    }
    for (std::size_t r = 0; r < std::max<std::size_t>(1, link().shapes.size()); ++r)
      for (int i = 0; i < 2 * (sliders_ - 1); ++i) Bound(-kWidestShape, kWidestShape, i, ShapeBlock(r), problem);
  }

  void SetEffectBounds(ceres::Problem* problem) {
    const auto bound = [&](std::span<const Extension::Unknown> unknowns, std::vector<double>& values) {
      for (std::size_t i = 0; i < unknowns.size(); ++i)
        Bound(unknowns[i].low, unknowns[i].high, static_cast<int>(i), values.data(), problem);
    };
    bound(extension_.shared(), outcome_.state.shared);
    if (extension_.own().empty()) return;
    for (std::vector<double>& own : outcome_.state.own) bound(extension_.own(), own);
  }

  /// One value of a block stays as it is.
  static void Hold(int index, int size, double* block, ceres::Problem* problem) {
    if (size == 1) {
      problem->SetParameterBlockConstant(block);
    } else {
      problem->SetManifold(block, new ceres::SubsetManifold(size, {index}));
    }
  }

  void Fix(const ExtendedControl& control, ceres::Problem* problem) {
    if (control.fix_shared && !extension_.shared().empty())
      problem->SetParameterBlockConstant(outcome_.state.shared.data());
    if (control.held_level >= 0) Hold(control.held_level, kLevels, LevelsBlock(0), problem);
    if (control.held_shared >= 0 && !control.fix_shared)
      Hold(control.held_shared, static_cast<int>(extension_.shared().size()), outcome_.state.shared.data(), problem);
    if (!control.fix_link) return;
    for (Levels& levels : link().levels) problem->SetParameterBlockConstant(levels.data());
    for (std::size_t r = 0; sliders_ > 1 && r < std::max<std::size_t>(1, link().shapes.size()); ++r)
      problem->SetParameterBlockConstant(ShapeBlock(r));
  }

  void AddWalls(ceres::Problem* problem) {
    for (std::size_t r = 0; r < link().levels.size(); ++r) {
      const FitData limits = WidestLimits(sharing_ == Sharing::kLink ? data_ : data_.subspan(r, 1));
      if (!(limits.smallest > 0) && !(limits.swing > 0)) continue;
      std::vector<double*> blocks = {LevelsBlock(r)};
      if (sliders_ > 1) blocks.push_back(ShapeBlock(r));
      problem->AddResidualBlock(MakeResolvedCost(sliders_, limits.smallest, limits.swing), nullptr, blocks);
    }
  }

  std::span<const FitData> data_;
  Sharing sharing_;
  const Extension& extension_;
  int sliders_;
  std::vector<ExtendedColumns> columns_;
  ExtendedOutcome outcome_;
};

/// Evaluates one record at a state.
bool EvaluateRecord(const FitData& data, const ExtendedState& state, std::size_t record, std::size_t stride,
                    bool derivatives, ExtendedColumns* columns) {
  return columns->Evaluate(data, data.size, stride, state.link.LevelsOf(record).data(),
                           state.link.ShapeOf(record).data(), state.link.starts[record].data(), state.shared.data(),
                           state.own.empty() ? nullptr : state.own[record].data(), derivatives);
}

}  // namespace

ExtendedOutcome FitExtended(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                            const ExtendedState& initial, const ExtendedControl& control) {
  return ExtendedFitter(data, sharing, extension, initial).Run(control);
}

std::vector<double> CalcExtendedResiduals(const FitData& data, const Extension& extension, const ExtendedState& state,
                                          std::size_t record) {
  ExtendedColumns columns(extension, CountSliders(state.link.shape));
  if (!EvaluateRecord(data, state, record, 1, /*derivatives=*/false, &columns)) return {};
  return {columns.residuals().begin(), columns.residuals().end()};
}

Linearisation LineariseExtended(const FitData& data, const Extension& extension, const ExtendedState& state,
                                std::size_t record, std::size_t stride) {
  ExtendedColumns columns(extension, CountSliders(state.link.shape));
  const Eigen::Index p = columns.CountUnknowns();
  if (!EvaluateRecord(data, state, record, stride, /*derivatives=*/true, &columns)) {
    const auto rows = static_cast<Eigen::Index>((data.size + stride - 1) / stride);
    return {.jacobian = Eigen::MatrixXd::Zero(rows, p),
            .residuals = Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::infinity())};
  }
  return {.jacobian = columns.Map().leftCols(p) / data.sigma, .residuals = columns.Map().col(p) / data.sigma};
}

}  // namespace uiclink
