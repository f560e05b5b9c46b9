#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "identify/record.h"
#include "model/oscillator.h"

namespace uiclink {

/// A measured free decay and the link that is said to explain it.  A view: the record must outlive it.
struct MissingForceInput {
  const Record* record = nullptr;
  std::size_t first = 0;         ///< first sample at or after the first free extremum
  std::size_t size = 0;          ///< samples from there
  double sigma = 0;              ///< noise of a reading [m], > 0
  double offset = 0;             ///< reading at the link's zero [m]
  Oscillator<double> link = {};  ///< per unit load; its g is used
  double y0 = 0;                 ///< first free extremum from the link's zero [m]; its sign sets the sliders' start
  double t0 = 0;                 ///< time of that extremum [s]; times below count from here
};

/// Where the mass is at one instant of the measured motion.
struct Moment {
  double t = 0;  ///< since the first free extremum [s]
  double y = 0;  ///< smoothed displacement from the link's zero [m]
  double v = 0;  ///< smoothed velocity [m/s]
};

/// A force, or any other function, along the motion.
using AlongMotion = std::function<double(const Moment&)>;

/// Force per unit load that a link lacks along one measured motion, averaged over short windows.
///
///   f(t) = y''/g + k y - sum T_i  [-],  positive towards positive y.
///
/// The sliders are followed along the measured motion itself, T_i' = -k_i y' held within +-T0i, from
/// T_i = -sign(y0) T0i at the first extremum: their memory is that of the record and not that of a simulation.
///
/// No reading is differentiated: each window is a weak form. With a weight p(t) that joins the values
/// (1 - (s/W)^2)^2 at the samples by straight lines, s the distance from the window's centre,
///   int p y'' dt = sum over samples of p (slope after it - slope before it)
/// is an identity, and the same p averages k y - sum T_i. So a window holds exactly the mean of f under p: no bias from
/// the curvature of the motion nor from corners of the force where sliders break out or turn, hence no guard around
/// them. (p'' is the filter of Savitzky and Golay of second order for y''.) The price is that f
/// itself is seen as its mean over W, during which the mass may move some millimetres; Average() gives the same mean of
/// any function, so that functions can be fitted to the windows without that blur.
///
/// Errors: independent readings of standard deviation sigma, propagated through y''/g and the springs that are stuck,
/// with the covariance of windows that overlap, plus kReconstructionFloor. A slider that sticks remembers the level at
/// which the motion turned, with the error of the smoothed motion there: one common error for all windows until it
/// slides again.
///
/// What the link's own parameters can take up says nothing about a missing force, since a fit has already moved k, k_i,
/// T0i and the sensor's zero by whatever they can explain: `absorbed` spans the changes of f with each of them, and
/// with the force at which each slider is left when it slides no more (it remembers the noise of one extremum).
class ForceSeries {
 public:
  struct Window {
    Moment at;         ///< mean time of the window, and the motion at its centre
    double f = 0;      ///< mean missing force [-]
    double error = 0;  ///< its standard deviation [-]
    double left = 0;   ///< f less what the link's parameters can absorb (generalised least squares) [-]
  };

  /// @returns nothing when the record has fewer than ten windows, or sigma or the link make no sense.
  static std::optional<ForceSeries> Make(const MissingForceInput& input);

  const std::vector<Window>& windows() const { return windows_; }
  std::size_t size() const { return windows_.size(); }
  double half_width() const { return half_width_; }                    ///< W [s]
  double frequency() const { return frequency_; }                      ///< of the link while every slider sticks [Hz]
  const std::vector<Moment>& motion() const { return motion_; }        ///< smoothed, several instants between samples
  int absorbed() const { return static_cast<int>(absorbed_.cols()); }  ///< independent directions that the link absorbs

  /// Mean of a function along the motion over each window.
  Eigen::VectorXd Average(const AlongMotion& function) const;
  /// Values at the windows in units in which their errors are independent and of standard deviation 1, freed from
  /// everything that the link can absorb.
  Eigen::VectorXd Judge(const Eigen::VectorXd& values) const;
  /// Judge() of the missing force.
  Eigen::VectorXd JudgeForce() const;
  /// Moves k, k_i, T0i and offset of the input by what fits best to the windows beside a force that is explained: one
  /// step of Gauss-Newton, no parameter by more than a factor of 2.
  /// @param explained  mean of that force over each window [-]
  /// @param given      where the weak prior has its middle
  /// @returns the largest relative change of a parameter.
  double Refit(const Eigen::VectorXd& explained, const MissingForceInput& given, MissingForceInput* input) const;
  /// Covariance of two windows.
  double Covariance(std::size_t a, std::size_t b) const;

 private:
  ForceSeries() = default;
  Eigen::VectorXd Whiten(Eigen::VectorXd values) const;
  Eigen::VectorXd Colour(Eigen::VectorXd white) const;  // undoes Whiten
  Eigen::VectorXd WindowSums(const Eigen::VectorXd& node_sums) const;
  void PlaceWindows(const std::vector<double>& t);
  void CalcCovariance(const MissingForceInput& input, const std::vector<double>& t,
                      const std::vector<double>& stiffness);
  void CalcMemoryErrors(const MissingForceInput& input);
  void CalcAbsorbed(const MissingForceInput& input);

  struct Span {
    std::size_t first;            // node
    std::vector<double> weights;  // of the nodes from there; the window's integral is 1
  };
  std::size_t nodes_ = 0;
  double half_width_ = 0, frequency_ = 0;
  std::vector<Moment> motion_;
  std::vector<Span> spans_;
  std::vector<Window> windows_;
  std::vector<std::vector<double>> covariance_;  // row a: with windows a, a+1, ... as far as they overlap
  std::vector<std::vector<double>> factor_;      // Cholesky, row a: columns a - bandwidth .. a
  Eigen::MatrixXd memory_;  // orthonormal, after the Cholesky factor: forces that sticking sliders remember wrongly
  Eigen::VectorXd memory_shrink_;  // 1 - 1/sqrt(1 + variance of each)
  Eigen::MatrixXd directions_;     // whitened df/d(offset, k, then k_i, T0i, force where slider i is left)
  Eigen::MatrixXd absorbed_;       // orthonormal, in the units of Judge()
};

/// Error of a window beside that of the readings [-]: corners between samples, curvature that the smoothing misses.
inline constexpr double kReconstructionFloor = 3e-6;
/// Standard deviation of the weak prior of Refit(): of the parameters relative to their values, and of the offset [m].
inline constexpr double kLinkPrior = 0.3, kOffsetPrior = 5e-3;

}  // namespace uiclink
