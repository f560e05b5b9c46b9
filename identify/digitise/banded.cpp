#include "identify/digitise/banded.h"

#include <algorithm>
#include <cmath>

namespace uiclink::digitise {

bool BandedEquations::Factor() {
  for (std::size_t i = 0; i < size_; ++i) {
    const std::size_t first = i > band_ ? i - band_ : 0;
    for (std::size_t j = first; j <= i; ++j) {
      double sum = Lower(i, j);
      for (std::size_t k = std::max(first, j > band_ ? j - band_ : 0); k < j; ++k) sum -= Lower(i, k) * Lower(j, k);
      if (i == j && !(sum > 0)) return false;
      Lower(i, j) = i == j ? std::sqrt(sum) : sum / Lower(j, j);
    }
  }
  return true;
}

std::vector<double> BandedEquations::Solve() const {
  std::vector<double> x = right_;
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t k = i > band_ ? i - band_ : 0; k < i; ++k) x[i] -= Lower(i, k) * x[k];
    x[i] /= Lower(i, i);
  }
  for (std::size_t i = size_; i-- > 0;) {
    for (std::size_t k = i + 1; k < std::min(size_, i + band_ + 1); ++k) x[i] -= Lower(k, i) * x[k];
    x[i] /= Lower(i, i);
  }
  return x;
}

std::vector<double> BandedEquations::InverseInBand() const {
  const std::size_t row = band_ + 1;
  std::vector<double> inverse(size_ * row);
  const auto at = [&](std::size_t i, std::size_t j) -> double& {
    return i >= j ? inverse[i * row + (i - j)] : inverse[j * row + (j - i)];
  };
  for (std::size_t j = size_; j-- > 0;) {
    const std::size_t end = std::min(size_, j + row);
    for (std::size_t i = end; i-- > j + 1;) {
      double sum = 0;
      for (std::size_t k = j + 1; k < end; ++k) sum -= Lower(k, j) / Lower(j, j) * at(std::max(i, k), std::min(i, k));
      at(i, j) = sum;
    }
    double diagonal = 1 / (Lower(j, j) * Lower(j, j));
    for (std::size_t k = j + 1; k < end; ++k) diagonal -= Lower(k, j) / Lower(j, j) * at(k, j);
    at(j, j) = diagonal;
  }
  return inverse;
}

}  // namespace uiclink::digitise
