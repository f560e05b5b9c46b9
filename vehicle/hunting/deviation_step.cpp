#include "vehicle/hunting/deviation_step.h"

#include <algorithm>

#include "vehicle/lanes.h"
#include "vehicle/processors.h"

namespace uiclink {
namespace {

/// R rows of a product, W times four columns of it, in the processor's registers.
template <std::size_t R, std::size_t W>
struct Sums {
  Lanes sum[R][W];

  [[gnu::always_inline]] Sums() {
#pragma GCC unroll 8
    for (std::size_t r = 0; r < R; ++r)
#pragma GCC unroll 2
      for (std::size_t w = 0; w < W; ++w) sum[r][w] = Lanes(0.0);
  }
  /// @param slopes  by input: Stride numbers, of which R are used.
  /// @param rows    of the inputs, `stride` apart.
  template <std::size_t Stride>
  [[gnu::always_inline]] void Add(const double* slopes, std::size_t inputs, const double* rows, std::size_t stride) {
    for (std::size_t i = 0; i < inputs; ++i, slopes += Stride, rows += stride) {
      Lanes x[W];
#pragma GCC unroll 2
      for (std::size_t w = 0; w < W; ++w) x[w] = Lanes(rows + 4 * w);
#pragma GCC unroll 8
      for (std::size_t r = 0; r < R; ++r)
#pragma GCC unroll 2
        for (std::size_t w = 0; w < W; ++w) sum[r][w] = sum[r][w] + Lanes(slopes[r]) * x[w];
    }
  }
  [[gnu::always_inline]] void Store(std::size_t r, double* row) const {
#pragma GCC unroll 2
    for (std::size_t w = 0; w < W; ++w) sum[r][w].Store(row + 4 * w);
  }
};

struct Product {
  const RateSlopes& slopes;
  std::size_t stride;
  std::size_t motions;
  bool leaf;
  const double* forcing;
  const double* by_parameter;
  const double* X;
  double* rate;

  template <std::size_t W>
  [[gnu::always_inline]] void CalcAxle(std::size_t axle, std::size_t column) const {
    constexpr std::size_t kStride = RateSlopes::kAxleStride;
    const auto x = [&](std::size_t i) { return X + i * stride + column; };
    const auto force = [&](std::size_t i) { return forcing + i * stride + column; };
    const auto input = [&](std::size_t i) { return slopes.axles[axle][i].data(); };
    Sums<RateSlopes::kAxleRows, W> sums;
    const std::size_t own = axle * wheelset::kSize;
    sums.template Add<kStride>(input(0), wheelset::kSize, x(own), stride);
    sums.template Add<kStride>(input(wheelset::kSize), body::kSize, x(kBody), stride);
    sums.template Add<kStride>(input(RateSlopes::kAxleLinks), 2, force(2 * axle), stride);
    sums.template Add<kStride>(input(RateSlopes::kAxleLinks + 2), 2, force(kCorners + 2 * axle), stride);
    if (leaf) sums.template Add<kStride>(input(RateSlopes::kAxleLeaves), 2, x(kLeafForces + 2 * axle), stride);
    for (std::size_t r = 0; r < RateSlopes::kAxleRows; ++r)
      sums.Store(r, rate + (own + RateSlopes::kAxleRow[r]) * stride + column);
  }

  template <std::size_t W>
  [[gnu::always_inline]] void CalcBody(std::size_t column) const {
    Sums<RateSlopes::kBodyRows, W> sums;
    sums.template Add<RateSlopes::kBodyRows>(slopes.body[0].data(), leaf ? kMaxState : kMotions, X + column, stride);
    sums.template Add<RateSlopes::kBodyRows>(slopes.body[RateSlopes::kBodyLinks].data(), 2 * kCorners, forcing + column,
                                             stride);
    for (std::size_t r = 0; r < RateSlopes::kBodyRows; ++r)
      sums.Store(r, rate + (kBody + RateSlopes::kBodyRow[r]) * stride + column);
  }

  template <std::size_t W>
  [[gnu::always_inline]] void CalcLeaf(std::size_t corner, std::size_t column) const {
    const double* const by = slopes.leaves[corner].data();
    const auto x = [&](std::size_t i) { return X + i * stride + column; };
    Sums<1, W> sums;
    sums.template Add<1>(by, 4, x(AxleOf(corner) * wheelset::kSize + wheelset::kZ), stride);
    sums.template Add<1>(by + 4, 4, x(kBody + body::kZ), stride);
    sums.template Add<1>(by + 8, 1, x(kLeafForces + corner), stride);
    sums.Store(0, rate + (kLeafForces + corner) * stride + column);
  }

  template <std::size_t W>
  [[gnu::always_inline]] void CalcColumns(std::size_t column) const {
    for (std::size_t axle = 0; axle < kAxles; ++axle) CalcAxle<W>(axle, column);
    CalcBody<W>(column);
    if (!leaf) return;
    for (std::size_t corner = 0; corner < kCorners; ++corner) CalcLeaf<W>(corner, column);
  }

  /// The rate of a position is the velocity, in the row after it.
  [[gnu::always_inline]] void CopyVelocities() const {
    const auto copy = [&](std::size_t i) { std::copy_n(X + (i + 1) * stride, stride, rate + i * stride); };
    for (std::size_t axle = 0; axle < kAxles; ++axle)
      for (std::size_t i : RateSlopes::kAxlePosition) copy(axle * wheelset::kSize + i);
    for (std::size_t i : RateSlopes::kBodyPosition) copy(kBody + i);
  }

  [[gnu::always_inline]] void Calc(std::size_t parameter_column) const {
    std::size_t column = 0;
    for (; column + 8 <= stride; column += 8) CalcColumns<2>(column);
    if (column < stride) CalcColumns<1>(column);
    CopyVelocities();
    if (parameter_column >= stride) return;
    if (by_parameter != nullptr) {
      for (std::size_t i = 0; i < motions; ++i) rate[i * stride + parameter_column] += by_parameter[i];
      return;
    }
    for (std::size_t axle = 0; axle < kAxles; ++axle)
      for (std::size_t r = 0; r < RateSlopes::kAxleRows; ++r)
        rate[(axle * wheelset::kSize + RateSlopes::kAxleRow[r]) * stride + parameter_column] +=
            slopes.by_speed[axle][r];
  }
};

/// z = x + c y. All of them may be the same.
[[gnu::always_inline]] inline void Combine(std::size_t size, const double* x, double c, const double* y, double* z) {
  for (std::size_t i = 0; i < size; i += 4) (Lanes(x + i) + c * Lanes(y + i)).Store(z + i);
}

struct Work {
  double* rate;
  double* stage;
  double* sum;
};

UICLINK_FOR_EACH_PROCESSOR
void MakeStep(const DeviationStep::Slopes& slopes, double h, std::size_t motions, const DeviationStep::Columns& columns,
              const double* forcing, const DeviationStep::ParameterRates& by_parameter, const Work& work, double* X) {
  const std::size_t size = motions * columns.stride;
  const auto calc = [&](const RateSlopes& at, std::size_t place, const double* from) __attribute__((always_inline)) {
    Product{at, columns.stride, motions, motions > kMotions, forcing, by_parameter[place], from, work.rate}.Calc(
        columns.parameter_column);
  };
  calc(slopes.begin, 0, X);
  Combine(size, X, h / 6, work.rate, work.sum);
  Combine(size, X, h / 2, work.rate, work.stage);
  calc(slopes.middle, 1, work.stage);
  Combine(size, work.sum, h / 3, work.rate, work.sum);
  Combine(size, X, h / 2, work.rate, work.stage);
  calc(slopes.middle, 1, work.stage);
  Combine(size, work.sum, h / 3, work.rate, work.sum);
  Combine(size, X, h, work.rate, work.stage);
  calc(slopes.end, 2, work.stage);
  Combine(size, work.sum, h / 6, work.rate, X);
}

}  // namespace

void DeviationStep::Reserve(std::size_t stride) {
  for (std::vector<double>* rows : {&rate_, &stage_, &sum_})
    if (rows->size() < kMaxState * stride) rows->resize(kMaxState * stride);
}

void DeviationStep::Make(const Slopes& slopes, double h, std::size_t motions, const Columns& columns,
                         const double* forcing, double* X, const ParameterRates& by_parameter) {
  MakeStep(slopes, h, motions, columns, forcing, by_parameter, {rate_.data(), stage_.data(), sum_.data()}, X);
}

}  // namespace uiclink
