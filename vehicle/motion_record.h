#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/moving_wagon.h"
#include "vehicle/simulation.h"

namespace uiclink {

/// The largest of the values seen in the last so many seconds: of the values seen, those that a later one equals or
/// exceeds are forgotten.
class SlidingMaximum {
 public:
  SlidingMaximum() { kept_.reserve(256); }
  void See(double t, double value);
  void Forget(double before);           ///< values from before this time are not asked for any more
  double LargestSince(double t) const;  ///< 0 if none has been seen since

 private:
  struct Seen {
    double t, value;
  };
  std::vector<Seen> kept_;  ///< by increasing time, hence by falling value; from first_ on
  std::size_t first_ = 0;
};

/// What a run leaves behind: extremes of its motions, guidance contacts, and evenly spaced values for spectra.
///
/// Extremes are found within steps, by the cubic through values and rates at both ends, so that they do not depend on
/// any sampling.
class MotionRecord {
 public:
  /// @param end     when the run is to end; it may end earlier.
  /// @param window  of the figures "in the window": the last so many seconds that were run.
  MotionRecord(const Wagon& wagon, double start, double end, double window);

  void Begin(const StateVector<double>& x);
  /// After every step: where it ended, or where the run did within it.
  void Add(const MovingWagon& wagon, const WagonState& end);
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
    double used = 0;                 ///< largest |displacement| [m]
    int contacts = 0;                ///< that began
    SlidingMaximum recent;           ///< |displacement|
    std::vector<double> begun = {};  ///< when the contacts of the last window began [s]
  };

  Point CalcMotion(std::size_t motion, const StateVector<double>& x) const;
  Point CalcStop(std::size_t stop, const std::array<CornerDeflection<double>, kCorners>& d) const;
  double ClearanceOf(std::size_t stop) const;
  double StiffnessOf(std::size_t stop) const;  ///< N per m beyond the clearance
  void SeeStop(std::size_t stop, double value, double t);
  void LeaveStop(std::size_t stop, double value);
  Impacts CalcImpacts(std::size_t stop, int count, double used) const;
  GuidanceUse CalcUse(std::size_t stop) const;
  void SampleStep(const MovingWagon& wagon, double t);
  void ForgetOld(double t);
  std::vector<double> CollectSamples(std::size_t motion) const;
  MotionFigures CalcFigures(std::size_t motion, double t_end) const;

  const Wagon& wagon_;
  double start_, window_;
  double t_ = 0;
  std::array<Point, kMotionCount> motions_{};
  std::array<Point, kStops> stop_points_{};
  std::array<std::vector<Extreme>, kMotionCount> extremes_;
  std::array<Stop, kStops> stops_{};
  std::size_t ring_size_ = 0, sampled_ = 0;  ///< samples of all motions at start + i/kSpectrumHz, the newest kept
  std::vector<std::array<double, kMotionCount>> ring_;
};

}  // namespace uiclink
