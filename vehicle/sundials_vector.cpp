#include "vehicle/sundials_vector.h"

#include <nvector/nvector_serial.h>

#include <cmath>

#include "vehicle/processors.h"
#include "vehicle/wagon_state.h"

// Vectors also where the compiler is asked for less than -O3.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3")
#endif

namespace uiclink {
namespace {

constexpr int kSize = static_cast<int>(kMaxState);

/// z = sum c_j x_j, from the first term to the last. z may be one of the x_j.
UICLINK_FOR_EACH_PROCESSOR
void Combine(int terms, const double* c, const double* const* x, double* z) {
  double sum[kSize];
  for (int i = 0; i < kSize; ++i) sum[i] = c[0] * x[0][i];
  int j = 1;
  for (; j + 1 < terms; j += 2) {
    const double* const a = x[j];
    const double* const b = x[j + 1];
    const double ca = c[j], cb = c[j + 1];
    for (int i = 0; i < kSize; ++i) sum[i] = (sum[i] + ca * a[i]) + cb * b[i];
  }
  if (j < terms)
    for (int i = 0; i < kSize; ++i) sum[i] += c[j] * x[j][i];
  for (int i = 0; i < kSize; ++i) z[i] = sum[i];
}

/// sum (x_i w_i)^2 in four interleaved parts.
UICLINK_FOR_EACH_PROCESSOR
double SumOfSquares(const double* x, const double* w) {
  double sum[4] = {0, 0, 0, 0};
  for (int i = 0; i + 4 <= kSize; i += 4) {
    for (int k = 0; k < 4; ++k) {
      const double p = x[i + k] * w[i + k];
      sum[k] += p * p;
    }
  }
  for (int i = kSize - kSize % 4; i < kSize; ++i) sum[i % 4] += x[i] * w[i] * (x[i] * w[i]);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

int LinearCombination(int terms, realtype* c, N_Vector* x, N_Vector z) {
  constexpr int kMost = 32;
  if (terms < 1 || terms > kMost) return -1;
  const double* data[kMost];
  for (int j = 0; j < terms; ++j) data[j] = NV_DATA_S(x[j]);
  Combine(terms, c, data, NV_DATA_S(z));
  return 0;
}

void LinearSum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z) {
  const double c[2] = {a, b};
  const double* const data[2] = {NV_DATA_S(x), NV_DATA_S(y)};
  Combine(2, c, data, NV_DATA_S(z));
}

void Scale(realtype c, N_Vector x, N_Vector z) {
  const double* const from = NV_DATA_S(x);
  double* const to = NV_DATA_S(z);
  if (c == 1) {
    if (from != to)
      for (int i = 0; i < kSize; ++i) to[i] = from[i];
    return;
  }
  for (int i = 0; i < kSize; ++i) to[i] = c * from[i];
}

realtype WrmsNorm(N_Vector x, N_Vector w) { return std::sqrt(SumOfSquares(NV_DATA_S(x), NV_DATA_S(w)) / kSize); }

}  // namespace

N_Vector NewStateVector(SUNContext context) {
  N_Vector v = N_VNew_Serial(static_cast<sunindextype>(kMaxState), context);
  if (v == nullptr) return v;
  v->ops->nvlinearcombination = &LinearCombination;
  v->ops->nvlinearsum = &LinearSum;
  v->ops->nvscale = &Scale;
  v->ops->nvwrmsnorm = &WrmsNorm;
  return v;
}

}  // namespace uiclink
