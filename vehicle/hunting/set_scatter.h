#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle/wagon.h"

namespace uiclink {

/// How the numbers behind the draws are chosen.
///
/// Measured on a linear critical speed, to first order (200 draws, 2000 repetitions; standard errors relative to those
/// of independent draws) for a set with one, and one with two combinations of parameters that matter:
///   antithetic pairs   mean 0, 0            2.5 % and 97.5 % quantile 0.97, 0.96
///   Latin hypercube    mean 0.03, 0.03                                0.40, 0.67
/// so that a Latin hypercube does with a half to a sixth of the draws. Where half of the draws fall outside of physical
/// bounds and are drawn anew (a slider that the records do not determine) it gains 0 to 25 %.
enum class Sampling {
  kRandom,          ///< independent
  kAntithetic,      ///< each even draw is the mirror image of the one before
  kLatinHypercube,  ///< every independent normal variable has one value in each of as many equally likely intervals
};

/// By how much links differ from corner to corner: standard deviations relative to the set [-], drawn for every corner,
/// direction and joint by itself.
struct CornerScatter {
  double k = 0;          ///< of k
  double slider_k = 0;   ///< of each k_i
  double slider_T0 = 0;  ///< of each T0i
  /// Instead of these three: of each parameter what the covariance of the corner's own set says of it
  /// (Covariance::spread, relative to the value). A parameter that no spread is known of is the same everywhere.
  bool from_set = false;

  bool Any() const { return from_set || k > 0 || slider_k > 0 || slider_T0 > 0; }
};

struct ScatterOptions {
  std::size_t draws = 200;
  std::uint64_t seed = 1;
  Sampling sampling = Sampling::kLatinHypercube;
  CornerScatter corner = {};
  /// Half of a 95 % interval in standard deviations of the set's errors, by Direction; none: as the set says
  /// (Covariance::coverage). Deviations are drawn normal and widened by coverage/1.96, so that 95 % bounds are
  /// Student's while variances stay finite.
  std::array<std::optional<double>, 2> coverage{};
};

/// One number that is drawn.
struct UncertainParameter {
  std::string name;    ///< "lateral k", "longitudinal T03", "lateral rolling_friction.T_r"; "lateral k, front_left"
  std::string group;   ///< "lateral k + sum k_i", "lateral T0", "lateral rolling_friction", "corners: lateral T0", ...
  std::string symbol;  ///< as in the covariance: "k", "T01", "rolling_friction.T_r"
  Direction direction = Direction::kLateral;
  std::array<bool, kCorners> corners{};  ///< where it is; all corners that stand on the same numbers have it in common
  bool is_factor = false;                ///< a factor on the corner's own value (corner scatter); else the value itself
  double value = 0;                      ///< nominal: of the set, or 1
  double low = 0, high = 0;  ///< physical bounds: draws are strictly inside, or at one that is possible (effects)
  std::size_t block = 0;     ///< parameters of different blocks are independent
};

/// The parameter that a covariance calls `symbol` ("k", "k1", "T01", "viscous_damping.c"); null if there is none.
double* FindParameter(DirectionParameters* parameters, std::string_view symbol);

/// Draws the links of a wagon from the uncertainty of their sets.
///
///   set values of a direction   x = m + (coverage/1.96) L z,  L L' = C (the set's covariance), z standard normal,
///                               drawn anew while a value is outside its physical bounds (k, k_i, T0i > 0; effects:
///                               the bounds of the catalogue), which makes it a truncated normal distribution
///   corner scatter              each value of each corner times a factor, normal about 1, drawn anew while <= 0
/// Directions are independent; corners with the same numbers stand on the same measurement and have its errors in
/// common. Draws depend on the options alone: those of one direction neither on the other one nor on corner scatter.
class SetScatter {
 public:
  /// @throws std::invalid_argument for a covariance that names a parameter the set lacks ("lateral k7 is in the
  /// covariance, but not in the set") or is not positive semidefinite; for standard deviations
  /// and spreads < 0, coverages <= 0; std::runtime_error if fewer than one in 10000 draws is within the bounds.
  SetScatter(const std::array<CornerLinks, kCorners>& links, const ScatterOptions& options);

  /// Nothing is uncertain: every draw is the set itself.
  bool empty() const { return parameters_.empty(); }
  std::size_t size() const { return options_.draws; }
  const ScatterOptions& options() const { return options_; }
  /// By Direction; the largest, where corners stand on different sets. 1.96 where nothing is drawn.
  const std::array<double, 2>& coverage() const { return coverage_; }
  const std::vector<UncertainParameter>& parameters() const { return parameters_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }  ///< of the parameters, before truncation, widened
  const Eigen::VectorXd& centre() const { return centre_; }          ///< nominal values
  const Eigen::MatrixXd& values() const { return values_; }          ///< a row per draw, a column per parameter
  std::size_t redrawn() const { return redrawn_; }                   ///< points that were outside the bounds

  const std::array<CornerLinks, kCorners>& nominal() const { return nominal_; }
  /// Links with these values of the parameters.
  std::array<CornerLinks, kCorners> LinksAt(const Eigen::VectorXd& values) const;
  std::array<CornerLinks, kCorners> Draw(std::size_t i) const {
    return LinksAt(values_.row(static_cast<Eigen::Index>(i)).transpose());
  }

 private:
  struct Block;
  void AddSets(std::vector<Block>* blocks);
  void AddCorners(std::vector<Block>* blocks);
  /// Of parameter i (ParameterSymbols) of a corner's set, relative to its value.
  double FindCornerStd(const DirectionParameters& set, std::size_t i) const;
  void DrawBlock(const Block& block);

  std::array<CornerLinks, kCorners> nominal_;
  ScatterOptions options_;
  std::array<double, 2> coverage_{};
  std::vector<UncertainParameter> parameters_;
  Eigen::VectorXd centre_;
  Eigen::MatrixXd covariance_;
  Eigen::MatrixXd values_;
  std::size_t redrawn_ = 0;
};

/// A wagon like `wagon` on other links, some twenty times faster than making one, since the contact is copied.
Wagon WithLinks(const Wagon& wagon, const std::array<CornerLinks, kCorners>& links);

}  // namespace uiclink
