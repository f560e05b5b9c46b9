#pragma once

#include <span>
#include <vector>

#include "identify/fit_problem.h"
#include "model/effect.h"

namespace uiclink {

/// Where a fit of one effect starts: coordinates of its shared and own unknowns.
struct StartPoint {
  std::vector<double> shared, own;
};

/// A size that is neutral at infinity (the level of a sensor that clips) has no sensitivity there.
bool HasNoScore(const Effect& effect);

/// All combinations of the start values of an effect's parameters, in coordinates.
class StartGrid {
 public:
  StartGrid(std::span<const FitData> data, const FitState& link, std::span<const std::vector<float>> residuals)
      : data_(data), link_(link), residuals_(residuals) {}

  std::vector<StartPoint> Make(const Effect& effect) const;

  /// Where the size is linearised. Sizes of one sign only (losses) just beside the neutral value: without any loss a
  /// link with k1 < k slips for ever, ever less, and the least loss ends that, so that the tangent at zero knows
  /// nothing of the tail of the record.
  double NearNeutral(const Effect& effect) const;

  /// Start values of a parameter, in coordinates.
  std::vector<double> Values(const Effect& effect, const EffectParameter& parameter) const;

 private:
  double Frequency() const;

  std::span<const FitData> data_;
  const FitState& link_;
  std::span<const std::vector<float>> residuals_;
};

/// Lines of the spectrum of some series of residuals between two frequencies [Hz], strongest first, all series
/// together.
/// @param decay  residuals are weighted with exp(-decay t) first, to find lines that die away [1/s].
std::vector<double> FindLines(std::span<const std::vector<float>> residuals, double sampling_hz, double low_hz,
                              double high_hz, double decay, std::size_t count);

}  // namespace uiclink
