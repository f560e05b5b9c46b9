#pragma once

#include <cstddef>
#include <vector>

namespace uiclink::digitise {

/// Symmetric positive definite equations whose matrix has `band` diagonals beside the main one.
class BandedEquations {
 public:
  BandedEquations(std::size_t size, std::size_t band)
      : size_(size), band_(band), matrix_(size * (band + 1)), right_(size) {}

  /// Adds to element (i, j), |i - j| <= band; given once, it counts for (j, i) as well.
  void Add(std::size_t i, std::size_t j, double value) { (i >= j ? Lower(i, j) : Lower(j, i)) += value; }
  void AddRight(std::size_t i, double value) { right_[i] += value; }
  std::size_t band() const { return band_; }

  /// Cholesky. False when the matrix is not positive definite; then nothing else may be asked.
  bool Factor();
  /// After Factor().
  std::vector<double> Solve() const;
  /// After Factor(): the elements of the inverse inside the band, row i: (i, i), (i, i-1), ... (i, i-band)
  /// (Takahashi's recursion).
  std::vector<double> InverseInBand() const;

 private:
  double& Lower(std::size_t i, std::size_t j) { return matrix_[i * (band_ + 1) + (i - j)]; }
  double Lower(std::size_t i, std::size_t j) const { return matrix_[i * (band_ + 1) + (i - j)]; }

  std::size_t size_, band_;
  std::vector<double> matrix_;  ///< lower triangle, row by row; after Factor() Cholesky's factor
  std::vector<double> right_;
};

}  // namespace uiclink::digitise
