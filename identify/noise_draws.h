#pragma once

#include <Eigen/Core>
#include <random>
#include <span>
#include <vector>

#include "identify/symptoms.h"

namespace uiclink {

/// Draws of what the residuals of a right model would be: white noise of each record's level, less its projection on
/// what the fit can follow (least squares in units of the noise, own and common unknowns together).
///
///   r = (I - P) e,   P the projector on the columns [own_1 .. own_n | common]
class NoiseDraws {
 public:
  NoiseDraws(std::span<const SymptomInput> records, unsigned seed);

  /// The next draw: residuals of every record [m].
  const std::vector<Eigen::VectorXd>& Next();

 private:
  struct Projection {
    double sigma = 0;
    Eigen::MatrixXd own;     // orthonormal basis of the record's own directions
    Eigen::MatrixXd common;  // shared directions without them
  };
  void RemoveCommon();

  std::vector<Projection> projections_;
  Eigen::MatrixXd common_inverse_;  // of the sum over records of common' common
  std::vector<Eigen::VectorXd> draw_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace uiclink
