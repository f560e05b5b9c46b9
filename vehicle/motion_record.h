#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/simulation.h"

namespace uiclink {

/// What a run leaves behind: extremes of its motions, guidance contacts, and evenly spaced values for spectra.
///
/// Extremes are found within steps, by the cubic through values and rates at both ends, so that they do not depend on
/// any sampling.
class MotionRecord {
 public:
  /// @param window  of the figures "in the window": the last so many seconds before the end.
  MotionRecord(const Wagon& wagon, double start, double end, double window);

  void Begin(const StateVector<double>& x);
  void Add(const Integrator& integrator);  ///< after every step
  void Summarise(SimulationResult* result) const;

 private:
  static constexpr double kSpectrumHz = 200;                ///< far above all that hunts (1 to 6 Hz and multiples)
  static constexpr std::size_t kStops = kAxles + kCorners;  ///< lateral by axle, longitudinal by corner

  struct Point {
    double value = 0, rate = 0;
  };
  struct Extreme {
    double t = 0, value = 0;
  };
  struct Stop {
    bool touches = false;
    GuidanceUse use;
  };

  Point CalcMotion(std::size_t motion, const StateVector<double>& x) const;
  Point CalcStop(std::size_t stop, const std::array<CornerDeflection<double>, kCorners>& d) const;
  double ClearanceOf(std::size_t stop) const;
  double StiffnessOf(std::size_t stop) const;  ///< N per m beyond the clearance
  void SeeStop(std::size_t stop, double value, double t);
  void LeaveStop(std::size_t stop, double value);
  void SampleStep(const Integrator& integrator);
  void ForgetOld(double t);
  std::vector<double> CollectSamples(std::size_t motion) const;
  MotionFigures CalcFigures(std::size_t motion, double t_end) const;

  const Wagon& wagon_;
  double start_, window_start_, window_;
  double t_ = 0;
  std::array<Point, kMotionCount> motions_{};
  std::array<Point, kStops> stop_points_{};
  std::array<std::vector<Extreme>, kMotionCount> extremes_;
  std::array<Stop, kStops> stops_{};
  std::size_t ring_size_ = 0, sampled_ = 0;  ///< samples of all motions at start + i/kSpectrumHz, the newest kept
  std::vector<std::array<double, kMotionCount>> ring_;
};

}  // namespace uiclink
