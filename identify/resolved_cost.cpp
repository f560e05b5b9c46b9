#include "identify/resolved_cost.h"

#include <ceres/cost_function.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/link_coordinates.h"

namespace uiclink {
namespace {

class ResolvedCost final : public ceres::CostFunction {
 public:
  /// @param smallest, largest  [m]; 0 for no wall on that side.
  ResolvedCost(int sliders, double smallest, double largest)
      : sliders_(sliders),
        log_smallest_(std::log(smallest)),
        log_largest_(largest > 0 ? std::log(largest) : std::numeric_limits<double>::infinity()) {
    set_num_residuals(sliders);
    mutable_parameter_block_sizes()->push_back(kLevels);
    if (sliders > 1) mutable_parameter_block_sizes()->push_back(2 * (sliders - 1));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    // So steep that a pull of 1e5 sums of squares per unit of the logarithm enters the wall by 1e-3.
    constexpr double kSteepness = 1e4;
    const Oscillator<double> link = ToOscillator(parameters[0], sliders_ > 1 ? parameters[1] : nullptr, sliders_, 1.0);
    for (int i = 0; i < sliders_; ++i) {
      const Slider<double>& slider = link.sliders()[static_cast<std::size_t>(i)];
      const double log_critical = std::log(slider.T0 / slider.k);
      // Distance behind a wall: negative behind the upper one.
      const double inside = std::max(0.0, log_smallest_ - log_critical) + std::min(0.0, log_largest_ - log_critical);
      residuals[i] = kSteepness * inside;
      if (jacobians == nullptr) continue;
      Eigen::RowVectorXd gradient = CalcLogGradient(link, 1 + i) - CalcLogGradient(link, 1 + sliders_ + i);
      gradient *= inside != 0 ? kSteepness : 0.0;
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
  double log_largest_;
};

}  // namespace

ceres::CostFunction* MakeResolvedCost(int sliders, double smallest, double largest) {
  return new ResolvedCost(sliders, smallest, largest);
}

FitData WidestLimits(std::span<const FitData> data) {
  FitData widest = data[0];
  for (const FitData& record : data) {
    widest.smallest = std::min(widest.smallest, record.smallest);
    widest.swing = widest.swing > 0 && record.swing > 0 ? std::max(widest.swing, record.swing) : 0;
  }
  return widest;
}

}  // namespace uiclink
