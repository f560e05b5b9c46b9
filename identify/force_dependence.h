#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "identify/force_series.h"

namespace uiclink {

/// What a missing force may be a function of.
enum class DependsOn {
  kDisplacement,          ///< any function of y
  kDryFriction,           ///< sign(y')
  kViscous,               ///< y'
  kVelocity,              ///< any function of y'
  kTime,                  ///< any function of the time since the first free extremum, the same in every record
  kStiffnessInTime,       ///< y h(t), h slow: stiffness that changes in time
  kStiffnessOscillating,  ///< y cos(w t + phase), the phase of each record its own: stiffness that is modulated, not at
                          ///< twice the frequency of the motion, where it is a damping
};

/// How much of a missing force one dependence explains.
struct Dependence {
  DependsOn on{};
  int terms = 0;         ///< free coefficients that the link's parameters cannot take up
  double gain = 0;       ///< fall of the weighted sum of squares; about `terms` when there is nothing but noise
  double share = 0;      ///< of the sum of squares beyond noise, by this dependence alone; 0..1
  double p_value = 1;    ///< of the gain beside all dependences named before it, for all that was looked at
  bool named = false;    ///< among those that describe the force
  double frequency = 0;  ///< kStiffnessOscillating: that explains most [Hz]
};

/// Knots of a piecewise linear function, constant beyond the first and last.
struct Knots {
  std::vector<double> at;  ///< increasing

  /// Value at x of the function that is 1 at knot i and 0 at the others.
  double Hat(std::size_t i, double x) const;
  /// `count` knots, equally spaced from low to high.
  static Knots Spread(double low, double high, std::size_t count);
};

/// A function of one quantity, fitted to windows that see only its mean while the mass passes by.
struct FittedFunction {
  struct Knot {
    double at = 0;
    double f = 0;      ///< value [-] or [unit of the force/unit of the factor]
    double error = 0;  ///< its standard deviation
  };
  std::vector<Knot> knots;
};

/// The windows of all records in the units of ForceSeries::Judge, one below the other.
class ForceRegression {
 public:
  explicit ForceRegression(std::span<const ForceSeries> series);

  std::span<const ForceSeries> series() const { return series_; }
  const Eigen::VectorXd& force() const { return force_; }
  int dof() const { return dof_; }  ///< windows less what the links can absorb

  Eigen::VectorXd Column(const AlongMotion& function) const;
  Eigen::MatrixXd Columns(DependsOn on) const;          ///< not kStiffnessOscillating
  Eigen::MatrixXd Oscillating(double frequency) const;  ///< two columns per record
  const Knots& KnotsOf(DependsOn on) const;             ///< of displacement, velocity or time

  /// Values at the knots of displacement, velocity, time or of the stiffness in time (then [1/m]), with what is beyond
  /// seeing taken away, since the sensor's zero and k take it up: the mean, and over displacement the straight line
  /// that leaves the function zero at as many places as can be (least absolute values), so that a local force looks
  /// local.
  ///
  /// A record sees sharp features far worse than smooth ones, so the values have a prior: second differences are normal
  /// deviates whose size is the one that makes the record most likely (empirical Bayes, a smoothing spline).
  /// @param without     orthonormal columns of what is explained by something else
  /// @param dispersion  variance of the judged windows
  FittedFunction Fit(DependsOn on, const Eigen::MatrixXd& without, double dispersion) const;

 private:
  std::span<const ForceSeries> series_;
  Eigen::VectorXd force_;
  int dof_ = 0;
  Knots displacement_, velocity_, time_;
};

/// Orthonormal columns that span `columns` as far as they are independent of each other and of `without`.
Eigen::MatrixXd Independent(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& without);

/// Dependences of a missing force, each judged by itself, and the few that together describe it: added one by one as
/// long as the next is significant (kFalseAlarm over all that were looked at) and explains kLeastShare of what there is
/// beyond noise, the best by penalised likelihood first, so that a dry friction is not called "a function of velocity".
struct DependenceSearch {
  std::vector<Dependence> all;     ///< in the order of DependsOn
  std::vector<std::size_t> named;  ///< indices, most important first
  double chi2 = 0;                 ///< weighted sum of squares of the missing force
  double chi2_left = 0;            ///< after the named ones
  int terms = 0;                   ///< of the named ones
  double dispersion = 1;           ///< chi2_left per degree of freedom, at least 1: scales all errors
};
DependenceSearch SearchDependences(const ForceRegression& regression);

/// The columns of one dependence, at the frequency found.
Eigen::MatrixXd ColumnsOf(const ForceRegression& regression, const Dependence& dependence);

inline constexpr double kFalseAlarm = 1e-3;
inline constexpr double kLeastShare = 0.05;

}  // namespace uiclink
