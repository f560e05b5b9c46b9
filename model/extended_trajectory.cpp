#include "model/extended_trajectory.h"

#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

/// First sample at or after the end of an arc; all that are left for the last arc.
template <typename T>
std::size_t EndOfArc(const ExtendedArc<T>& arc, bool last, const SampleTimes& times, std::size_t from) {
  if (last) return times.size;
  if (!times.times.empty()) {
    const auto begin = times.times.begin() + static_cast<std::ptrdiff_t>(from);
    return static_cast<std::size_t>(std::lower_bound(begin, times.times.end(), arc.t_end) - times.times.begin());
  }
  const double index = std::ceil((arc.t_end - times.first) / times.step);
  if (!(index > static_cast<double>(from))) return from;
  return index >= static_cast<double>(times.size) ? times.size : static_cast<std::size_t>(index);
}

/// exp(-b s) cos w s and exp(-b s) sin w s at equally spaced s: turned and shrunk from sample to sample.
class DampedTurner {
 public:
  DampedTurner(double b, double w, double s, double step) {
    const double now = std::exp(-b * s), next = std::exp(-b * step);
    cosine_ = now * std::cos(w * s);
    sine_ = now * std::sin(w * s);
    cos_step_ = next * std::cos(w * step);
    sin_step_ = next * std::sin(w * step);
  }
  double cosine() const { return cosine_; }
  double sine() const { return sine_; }
  void Next() {
    const double c = cosine_ * cos_step_ - sine_ * sin_step_;
    sine_ = sine_ * cos_step_ + cosine_ * sin_step_;
    cosine_ = c;
  }

 private:
  double cosine_ = 0, sine_ = 0, cos_step_ = 1, sin_step_ = 0;
};

/// Weights of the six numbers q of an arc in y and, for the closed form, in v at some samples of it. The derivative of
/// y by a quantity is the same sum over the derivatives of q, less v times that of t_start.
constexpr std::size_t kBlock = 64;
struct Weights {
  std::array<std::array<double, kBlock>, 6> y{};
  std::array<double, kBlock> value{}, velocity{};
};

template <typename T>
std::array<double, 6> Values(const ExtendedArc<T>& arc) {
  std::array<double, 6> q{};
  for (std::size_t j = 0; j < q.size(); ++j) q[j] = Value(arc.q[j]);
  return q;
}

void WeighClosedForm(const std::array<double, 6>& q, double s0, const SampleTimes& times, std::size_t first,
                     std::size_t size, double start, Weights* weights) {
  DampedTurner turner(q[5], q[4], s0, times.step);
  for (std::size_t i = 0; i < size; ++i) {
    const double s = times[first + i] - start;
    if (!times.times.empty()) turner = DampedTurner(q[5], q[4], s, 0);
    const double cosine = turner.cosine(), sine = turner.sine();
    const double swing = q[2] * cosine + q[3] * sine, turned = q[3] * cosine - q[2] * sine;
    weights->value[i] = q[0] + q[1] * s + swing;
    weights->velocity[i] = q[1] + q[4] * turned - q[5] * swing;
    weights->y[0][i] = 1;
    weights->y[1][i] = s;
    weights->y[2][i] = cosine;
    weights->y[3][i] = sine;
    weights->y[4][i] = s * turned;
    weights->y[5][i] = -s * swing;
    turner.Next();
  }
}

void WeighPolynomial(const std::array<double, 6>& q, double length, const SampleTimes& times, std::size_t first,
                     std::size_t size, double start, Weights* weights) {
  for (std::size_t i = 0; i < size; ++i) {
    const double u = (times[first + i] - start) / length;
    double power = 1, value = 0, slope = 0, before = 0;
    for (std::size_t j = 0; j < q.size(); ++j) {
      weights->y[j][i] = power;
      value += q[j] * power;
      slope += static_cast<double>(j) * q[j] * before;
      before = power;
      power *= u;
    }
    weights->value[i] = value;
    weights->velocity[i] = slope / length;
  }
}

/// Calls use(arc, first sample, number of samples, weights) for all samples of a run.
template <typename T, typename Use>
void ForAllBlocks(const ExtendedTrajectory<T>& trajectory, const SampleTimes& times, Use use) {
  Weights weights;
  std::size_t from = 0;
  for (const ExtendedArc<T>& arc : trajectory.arcs()) {
    const std::size_t to = EndOfArc(arc, &arc == &trajectory.arcs().back(), times, from);
    const double start = Value(arc.t_start);
    const std::array<double, 6> q = Values(arc);
    for (std::size_t first = from; first < to; first += kBlock) {
      const std::size_t size = std::min(kBlock, to - first);
      if (arc.length > 0) {
        WeighPolynomial(q, arc.length, times, first, size, start, &weights);
      } else {
        WeighClosedForm(q, times[first] - start, times, first, size, start, &weights);
      }
      use(arc, first, size, weights);
    }
    from = std::max(from, to);
  }
}

}  // namespace

template <typename T>
T CalcDisplacement(const ExtendedArc<T>& arc, const T& s) {
  using std::cos;
  using std::exp;
  using std::sin;
  const auto& q = arc.q;
  if (arc.length > 0) {
    const T u = s / arc.length;
    return q[0] + u * (q[1] + u * (q[2] + u * (q[3] + u * (q[4] + u * q[5]))));
  }
  const T phase = q[4] * s;
  return q[0] + q[1] * s + exp(-(q[5] * s)) * (q[2] * cos(phase) + q[3] * sin(phase));
}

template <typename T>
T CalcVelocity(const ExtendedArc<T>& arc, const T& s) {
  using std::cos;
  using std::exp;
  using std::sin;
  const auto& q = arc.q;
  if (arc.length > 0) {
    const T u = s / arc.length;
    return (q[1] + u * (2.0 * q[2] + u * (3.0 * q[3] + u * (4.0 * q[4] + u * (5.0 * q[5]))))) / arc.length;
  }
  const T phase = q[4] * s;
  const T cosine = cos(phase), sine = sin(phase);
  return q[1] + exp(-(q[5] * s)) * (cosine * (q[3] * q[4] - q[5] * q[2]) - sine * (q[2] * q[4] + q[5] * q[3]));
}

template <typename T>
const ExtendedArc<T>& ExtendedTrajectory<T>::FindArc(double t) const {
  const auto after = std::upper_bound(arcs_.begin(), arcs_.end(), t,
                                      [](double time, const ExtendedArc<T>& arc) { return time < Value(arc.t_start); });
  return after == arcs_.begin() ? arcs_.front() : *(after - 1);
}

template <typename T>
T ExtendedTrajectory<T>::y(double t) const {
  const ExtendedArc<T>& arc = FindArc(t);
  return CalcDisplacement(arc, T(t - arc.t_start));
}

template <typename T>
T ExtendedTrajectory<T>::v(double t) const {
  const ExtendedArc<T>& arc = FindArc(t);
  return CalcVelocity(arc, T(t - arc.t_start));
}

void CalcDisplacements(const ExtendedTrajectory<double>& trajectory, const SampleTimes& times, std::span<double> y) {
  ForAllBlocks(trajectory, times,
               [&](const ExtendedArc<double>&, std::size_t first, std::size_t size, const Weights& weights) {
                 std::copy_n(weights.value.begin(), size, y.begin() + static_cast<std::ptrdiff_t>(first));
               });
}

template <int N>
void CalcDisplacements(const ExtendedTrajectory<Dual<N>>& trajectory, const SampleTimes& times, int columns,
                       std::span<double> y, std::span<double> v, std::span<double> dy) {
  ForAllBlocks(trajectory, times,
               [&](const ExtendedArc<Dual<N>>& arc, std::size_t first, std::size_t size, const Weights& weights) {
                 std::copy_n(weights.value.begin(), size, y.begin() + static_cast<std::ptrdiff_t>(first));
                 std::copy_n(weights.velocity.begin(), size, v.begin() + static_cast<std::ptrdiff_t>(first));
                 for (int p = 0; p < columns; ++p) {
                   double* column = dy.data() + static_cast<std::size_t>(p) * times.size + first;
                   const double start = arc.t_start.v[p];
                   const double q0 = arc.q[0].v[p], q1 = arc.q[1].v[p], q2 = arc.q[2].v[p], q3 = arc.q[3].v[p],
                                q4 = arc.q[4].v[p], q5 = arc.q[5].v[p];
                   for (std::size_t i = 0; i < size; ++i)
                     column[i] = q0 + q1 * weights.y[1][i] + q2 * weights.y[2][i] + q3 * weights.y[3][i] +
                                 q4 * weights.y[4][i] + q5 * weights.y[5][i] - start * weights.velocity[i];
                 }
               });
}

template class ExtendedTrajectory<double>;
template double CalcDisplacement(const ExtendedArc<double>&, const double&);
template double CalcVelocity(const ExtendedArc<double>&, const double&);
#define UICLINK_INSTANTIATE_DUAL(N)                                                                                 \
  template class ExtendedTrajectory<Dual<(N)>>;                                                                     \
  template Dual<(N)> CalcDisplacement(const ExtendedArc<Dual<(N)>>&, const Dual<(N)>&);                             \
  template Dual<(N)> CalcVelocity(const ExtendedArc<Dual<(N)>>&, const Dual<(N)>&);                                 \
  template void CalcDisplacements(const ExtendedTrajectory<Dual<(N)>>&, const SampleTimes&, int, std::span<double>, \
                                  std::span<double>, std::span<double>)
UICLINK_INSTANTIATE_DUAL(6);
UICLINK_INSTANTIATE_DUAL(8);
UICLINK_INSTANTIATE_DUAL(12);
UICLINK_INSTANTIATE_DUAL(16);
#undef UICLINK_INSTANTIATE_DUAL

}  // namespace uiclink
