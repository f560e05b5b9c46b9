#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/hunting/deviation_step.h"
#include "vehicle/hunting/parameter_slopes.h"
#include "vehicle/hunting/recorded_run.h"
#include "vehicle/rate_slopes.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// What becomes of small deviations from a run: deviations of the motions X and of the places P [m] where the springs
/// of the sliders are relaxed.
///
///   X' = J(x(t)) X + sum over joints that stick of  Q k_i g_link P_i,      P_i' = 0,
///
/// J and g_link = d rate / d force of the link exact (rate_slopes.h). Runge-Kutta of order 4 on the steps of the run,
/// their middle from the cubic through both ends. At events:
///   a joint begins to slide   P_i is forgotten. Where the force falls (static friction) the moment of the event moves,
///                             X += (f+ - f-) (grad h . deviation) / (grad h . f-)
///   a joint sticks            where the link turns round, at v = 0, or where its limit L(v) outruns it, at L' a = v:
///                             P_i = d(deviation of the link) - v/a d(deviation of its velocity)
/// Other events do not make the rate jump. A parameter that is not the speed forces its own column as the speed does;
/// where joints stick or break out, their limit moves with it, too.
///
/// Creep and Hertz contact let directions die out, as e^(-1300 t) at most; deviations are kept as a product W R, the
/// columns of W independent to 1e-14. A second of hunting begins with 36 columns and ends with 23; it takes six times
/// as long as the run alone (tests/bench/bench_hunting.cpp), and memory only where W is compressed.
class Variation {
 public:
  /// @param scales  of motions and memory; what counts as one (Flow::scales).
  /// @param parameter  what d end / d parameter is by; null: the speed. Must outlive this.
  Variation(const Wagon& wagon, double V, const Eigen::VectorXd& scales, ParameterSlopes* parameter = nullptr);

  /// @param from  the deviations at the begin, a column each: motions above, memory below.
  void Follow(const RecordedRun& run, const Eigen::MatrixXd& from);

  Eigen::MatrixXd end() const { return deviations_.leftCols(rank_) * weights_; }
  Eigen::VectorXd end_by_parameter() const { return deviations_.col(rank_); }
  /// Displacements of the links, as rows over the motions: d_link = row . x.
  const Eigen::MatrixXd& deflections() const { return d_; }
  const Eigen::MatrixXd& velocities() const { return v_; }     ///< of the links, likewise
  Eigen::Index largest_rank() const { return largest_rank_; }  ///< of W after its first compression, for measurements

 private:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  void Begin(const Eigen::MatrixXd& from);
  void CalcSlopes(const LinkStates& links, const StateVector<double>& x, std::size_t place);
  void MakeStep(const RecordedRun::Step& step, const LinkStates& links, bool begin_known, bool ends_at_event);
  void LoadForcing(const LinkStates& links);
  void PassEvent(const LinkStates& before, const LinkStates& after, const StateVector<double>& x);
  void BreakOut(const SliderPlace& place, std::size_t slider, const LinkStates& before, const LinkStates& after,
                const StateVector<double>& x);
  void Stick(const SliderPlace& place, std::size_t slider, const LinkStates& before, const LinkStates& after,
             const StateVector<double>& x);
  void Compress();
  /// W has so many columns from now on; beside them there are one for the speed and as many as fill a vector.
  void Resize(Eigen::Index rank);
  auto motions() { return deviations_.topRows(motions_); }

  const Wagon& wagon_;
  double V_;
  Eigen::VectorXd scales_;
  Eigen::Index motions_;
  std::vector<SliderPlace> sliders_;
  Eigen::MatrixXd d_, v_;  ///< displacement and velocity of every link, as rows over the motions

  ParameterSlopes* parameter_;

  Rows deviations_;          ///< W, and beside it what a change of the parameter makes
  Eigen::Index rank_ = 0;    ///< columns of W
  Eigen::MatrixXd weights_;  ///< R
  Eigen::Index largest_rank_ = 0;

  Rows forcing_;  ///< by link: sum Q k_i P_i
  DeviationStep step_;
  std::array<RateSlopes, 3> slopes_;
  std::array<StateVector<double>, 3> by_parameter_{};  ///< d rate / d parameter, where it is not the speed
  std::size_t begin_ = 0, middle_ = 1, end_ = 2;       ///< which of them is where
  StateVector<double> end_rate_{};
};

}  // namespace uiclink
