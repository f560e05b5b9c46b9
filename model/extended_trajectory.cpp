#include "model/extended_trajectory.h"

#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

/// A displacement, a velocity and a derivative are all the same sum over six functions of time, with other weights:
///   closed form:  1, s, and with c = exp(-q5 s) cos q4 s, n = exp(-q5 s) sin q4 s:  c, n, s c, s n
///   polynomial:   1, u, ..., u^5
constexpr std::size_t kBlock = 64;
constexpr std::size_t kLanes = 4;  // samples that are found side by side
struct Basis {
  std::array<std::array<double, kBlock>, 5> f{};  // without the 1
};
using Coefficients = std::array<double, 6>;

/// What turns exp(-b s) (cos w s, sin w s) to the next of equally spaced s.
struct Turn {
  double b = 0, w = 0, step = 0;
  double cosine = 1, sine = 0;

  Turn() = default;
  Turn(double decay, double frequency, double s) : b(decay), w(frequency), step(s) {
    const double shrink = b == 0 ? 1 : std::exp(-b * s);
    cosine = shrink * std::cos(w * s);
    sine = shrink * std::sin(w * s);
  }
  Turn Apply(const Turn& other) const {
    Turn both;
    both.cosine = cosine * other.cosine - sine * other.sine;
    both.sine = sine * other.cosine + cosine * other.sine;
    return both;
  }
};

/// Motions alternate between a few frequencies: their turns are kept.
class Turns {
 public:
  const Turn& Find(double b, double w, double step) {
    for (const Turn& turn : kept_)
      if (turn.w == w && turn.b == b && turn.step == step) return turn;
    Turn& oldest = kept_[next_];
    next_ = (next_ + 1) % kept_.size();
    return oldest = Turn(b, w, step);
  }

 private:
  std::array<Turn, 4> kept_{};
  std::size_t next_ = 0;
};

template <typename T>
Coefficients Values(const ExtendedArc<T>& arc) {
  Coefficients q{};
  for (std::size_t j = 0; j < q.size(); ++j) q[j] = Value(arc.q[j]);
  return q;
}

/// c and n at equally spaced samples, in lanes that are independent of each other.
void TurnThrough(const Coefficients& q, double s0, double step, std::size_t size, Turns* turns, Basis* basis) {
  const Turn one = turns->Find(q[5], q[4], step);
  const Turn two = one.Apply(one), four = two.Apply(two);
  std::array<double, kLanes> cosine{}, sine{};
  Turn at(q[5], q[4], s0);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    cosine[lane] = at.cosine;
    sine[lane] = at.sine;
    at = at.Apply(one);
  }
  for (std::size_t i = 0; i < size; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      basis->f[1][i + lane] = cosine[lane];
      basis->f[2][i + lane] = sine[lane];
      const double c = cosine[lane] * four.cosine - sine[lane] * four.sine;
      sine[lane] = sine[lane] * four.cosine + cosine[lane] * four.sine;
      cosine[lane] = c;
    }
  }
}

void CalcClosedForm(const Coefficients& q, const SampleTimes& times, std::size_t first, std::size_t size, double start,
                    Turns* turns, Basis* basis) {
  auto& f = basis->f;
  if (times.times.empty()) {
    TurnThrough(q, times[first] - start, times.step, size, turns, basis);
  } else {
    for (std::size_t i = 0; i < size; ++i) {
      const Turn at(q[5], q[4], times[first + i] - start);
      f[1][i] = at.cosine;
      f[2][i] = at.sine;
    }
  }
  for (std::size_t i = 0; i < size; ++i) {
    const double s = times[first + i] - start;
    f[0][i] = s;
    f[3][i] = s * f[1][i];
    f[4][i] = s * f[2][i];
  }
}

void CalcPolynomial(double length, const SampleTimes& times, std::size_t first, std::size_t size, double start,
                    Basis* basis) {
  auto& f = basis->f;
  for (std::size_t i = 0; i < size; ++i) {
    const double u = (times[first + i] - start) / length;
    f[0][i] = u;
    f[1][i] = u * u;
    f[2][i] = u * f[1][i];
    f[3][i] = f[1][i] * f[1][i];
    f[4][i] = u * f[3][i];
  }
}

Coefficients VelocityOf(const Coefficients& q, double length) {
  if (length > 0) return {q[1] / length, 2 * q[2] / length, 3 * q[3] / length, 4 * q[4] / length, 5 * q[5] / length, 0};
  return {q[1], 0, q[4] * q[3] - q[5] * q[2], -(q[4] * q[2] + q[5] * q[3]), 0, 0};
}

Coefficients DisplacementOf(Coefficients q, double length) {
  if (!(length > 0)) q[4] = q[5] = 0;
  return q;
}

/// The derivative by a quantity, from those of the arc's six numbers and of its start.
Coefficients DerivativeOf(const Coefficients& q, const Coefficients& velocity, const Coefficients& dq, double dstart,
                          double length) {
  Coefficients k = dq;
  if (!(length > 0)) {
    k[4] = dq[4] * q[3] - dq[5] * q[2];
    k[5] = -dq[4] * q[2] - dq[5] * q[3];
  }
  for (std::size_t j = 0; j < k.size(); ++j) k[j] -= dstart * velocity[j];
  return k;
}

void Evaluate(const Coefficients& k, const Basis& basis, std::size_t size, double* out) {
  const auto& f = basis.f;
  if (k[4] == 0 && k[5] == 0) {
    for (std::size_t i = 0; i < size; ++i) out[i] = k[0] + k[1] * f[0][i] + k[2] * f[1][i] + k[3] * f[2][i];
  } else if (k[1] == 0) {
    for (std::size_t i = 0; i < size; ++i)
      out[i] = k[0] + k[2] * f[1][i] + k[3] * f[2][i] + k[4] * f[3][i] + k[5] * f[4][i];
  } else {
    for (std::size_t i = 0; i < size; ++i)
      out[i] = k[0] + k[1] * f[0][i] + k[2] * f[1][i] + k[3] * f[2][i] + k[4] * f[3][i] + k[5] * f[4][i];
  }
}

/// Calls use(arc, its values, first sample, number of samples, basis) for all samples of a run.
template <typename T, typename Use>
void ForAllBlocks(const ExtendedTrajectory<T>& trajectory, const SampleTimes& times, Use use) {
  Basis basis;
  Turns turns;
  std::size_t from = 0;
  for (const ExtendedArc<T>& arc : trajectory.arcs()) {
    const std::size_t to = &arc == &trajectory.arcs().back() ? times.size : times.FindFirst(arc.t_end, from);
    const double start = Value(arc.t_start);
    const Coefficients q = Values(arc);
    for (std::size_t first = from; first < to; first += kBlock) {
      const std::size_t size = std::min(kBlock, to - first);
      if (arc.length > 0) {
        CalcPolynomial(arc.length, times, first, size, start, &basis);
      } else {
        CalcClosedForm(q, times, first, size, start, &turns, &basis);
      }
      use(arc, q, first, size, basis);
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
               [&](const ExtendedArc<double>& arc, const Coefficients& q, std::size_t first, std::size_t size,
                   const Basis& basis) { Evaluate(DisplacementOf(q, arc.length), basis, size, y.data() + first); });
}

template <int N>
void CalcDisplacements(const ExtendedTrajectory<Dual<N>>& trajectory, const SampleTimes& times, int columns,
                       std::span<double> y, std::span<double> v, std::span<double> dy) {
  ForAllBlocks(trajectory, times,
               [&](const ExtendedArc<Dual<N>>& arc, const Coefficients& q, std::size_t first, std::size_t size,
                   const Basis& basis) {
                 const Coefficients velocity = VelocityOf(q, arc.length);
                 Evaluate(DisplacementOf(q, arc.length), basis, size, y.data() + first);
                 Evaluate(velocity, basis, size, v.data() + first);
                 for (int p = 0; p < columns; ++p) {
                   Coefficients dq{};
                   for (std::size_t j = 0; j < dq.size(); ++j) dq[j] = arc.q[j].v[p];
                   Evaluate(DerivativeOf(q, velocity, dq, arc.t_start.v[p], arc.length), basis, size,
                            dy.data() + static_cast<std::size_t>(p) * times.size + first);
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
