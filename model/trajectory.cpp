#include "model/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uiclink {
namespace {

constexpr std::size_t kLanes = 4;   // turned together, so that the compiler can use vector instructions
constexpr std::size_t kBlock = 64;  // samples whose cosines and sines are at hand at a time

/// cos and sin of phase, phase + step, ... : the phase is turned, not evaluated.
class Turner {
 public:
  Turner(double phase, double step) : turn_cos_(std::cos(kLanes * step)), turn_sin_(std::sin(kLanes * step)) {
    for (std::size_t j = 0; j < kLanes; ++j) {
      cos_[j] = std::cos(phase + static_cast<double>(j) * step);
      sin_[j] = std::sin(phase + static_cast<double>(j) * step);
    }
  }

  /// Writes the next `size` cosines and sines; size must be a multiple of kLanes except in the last call.
  void Next(std::size_t size, double* cosines, double* sines) {
    for (std::size_t i = 0; i < size; i += kLanes) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        cosines[i + j] = cos_[j];
        sines[i + j] = sin_[j];
        const double c = cos_[j] * turn_cos_ - sin_[j] * turn_sin_;
        sin_[j] = sin_[j] * turn_cos_ + cos_[j] * turn_sin_;
        cos_[j] = c;
      }
    }
  }

 private:
  std::array<double, kLanes> cos_{};
  std::array<double, kLanes> sin_{};
  double turn_cos_;
  double turn_sin_;
};

/// Cosines and sines of w (t - t_start) for a block of samples, and t - t_start itself.
struct PhaseBlock {
  std::array<double, kBlock + kLanes> cosines;
  std::array<double, kBlock + kLanes> sines;
  std::array<double, kBlock> since_start;
};

/// First sample at or after the end of the arc; all that are left for the last arc.
template <typename Scalar>
std::size_t EndOfArc(const Arc<Scalar>& arc, bool last, const SampleTimes& times, std::size_t from) {
  if (last) return times.size;
  if (!times.times.empty()) {
    const auto begin = times.times.begin() + static_cast<std::ptrdiff_t>(from);
    return static_cast<std::size_t>(std::lower_bound(begin, times.times.end(), arc.t_end) - times.times.begin());
  }
  const double index = std::ceil((arc.t_end - times.first) / times.step);
  if (!(index > static_cast<double>(from))) return from;
  return index >= static_cast<double>(times.size) ? times.size : static_cast<std::size_t>(index);
}

/// Calls use(first sample, number of samples, block) for the samples of one arc, block by block.
template <typename Scalar, typename Use>
void ForBlocks(const Arc<Scalar>& arc, const SampleTimes& times, std::size_t from, std::size_t to, Use use) {
  if (from >= to) return;
  PhaseBlock block;
  const double w = Value(arc.w);
  Turner turner(w * (times[from] - arc.t_start), w * times.step);
  for (std::size_t first = from; first < to; first += kBlock) {
    const std::size_t size = std::min(kBlock, to - first);
    for (std::size_t i = 0; i < size; ++i) block.since_start[i] = times[first + i] - arc.t_start;
    if (times.times.empty()) {
      turner.Next(size, block.cosines.data(), block.sines.data());
    } else {
      for (std::size_t i = 0; i < size; ++i) {
        block.cosines[i] = std::cos(w * block.since_start[i]);
        block.sines[i] = std::sin(w * block.since_start[i]);
      }
    }
    use(first, size, block);
  }
}

/// Calls use(arc, first sample, number of samples, block) for all samples of a trajectory.
template <typename Scalar, typename Use>
void ForAllBlocks(const Trajectory<Scalar>& trajectory, const SampleTimes& times, Use use) {
  std::size_t from = 0;
  for (std::size_t j = 0; j < trajectory.arcs().size(); ++j) {
    const Arc<Scalar>& arc = trajectory.arcs()[j];
    const std::size_t to = EndOfArc(arc, j + 1 == trajectory.arcs().size(), times, from);
    ForBlocks(arc, times, from, to,
              [&](std::size_t first, std::size_t size, const PhaseBlock& block) { use(arc, first, size, block); });
    from = std::max(from, to);
  }
}

}  // namespace

template <typename Scalar>
void Trajectory<Scalar>::Clear(const Oscillator<Scalar>& oscillator) {
  oscillator_ = oscillator;
  sliders_ = oscillator.sliders().size();
  arcs_.clear();
  forces_.clear();
}

template <typename Scalar>
void Trajectory<Scalar>::Append(const Arc<Scalar>& arc, std::span<const Scalar> forces) {
  arcs_.push_back(arc);
  forces_.insert(forces_.end(), forces.begin(), forces.end());
}

template <typename Scalar>
std::size_t Trajectory<Scalar>::FindArc(double t) const {
  const auto after = std::upper_bound(arcs_.begin(), arcs_.end(), t,
                                      [](double time, const Arc<Scalar>& arc) { return time < arc.t_start; });
  return after == arcs_.begin() ? 0 : static_cast<std::size_t>(after - arcs_.begin()) - 1;
}

template <typename Scalar>
Scalar Trajectory<Scalar>::y(double t) const {
  using std::cos;
  using std::sin;
  const Arc<Scalar>& arc = arcs_[FindArc(t)];
  const Scalar phase = arc.w * (t - arc.t_start);
  return arc.c + arc.a * cos(phase) + arc.b * sin(phase);
}

template <typename Scalar>
Scalar Trajectory<Scalar>::v(double t) const {
  using std::cos;
  using std::sin;
  const Arc<Scalar>& arc = arcs_[FindArc(t)];
  const Scalar phase = arc.w * (t - arc.t_start);
  return arc.w * (arc.b * cos(phase) - arc.a * sin(phase));
}

template <typename Scalar>
Scalar Trajectory<Scalar>::T(std::size_t slider, double t) const {
  const std::size_t j = FindArc(t);
  const Scalar start = StartForces(j)[slider];
  if ((arcs_[j].sliding >> slider) & 1u) return start;
  return start - oscillator_.sliders()[slider].k * (y(t) - (arcs_[j].c + arcs_[j].a));
}

void CalcDisplacements(const Trajectory<double>& trajectory, const SampleTimes& times, std::span<double> y) {
  ForAllBlocks(trajectory, times,
               [&](const Arc<double>& arc, std::size_t first, std::size_t size, const PhaseBlock& block) {
                 for (std::size_t i = 0; i < size; ++i)
                   y[first + i] = arc.c + arc.a * block.cosines[i] + arc.b * block.sines[i];
               });
}

template <int N>
void CalcDisplacements(const Trajectory<Dual<N>>& trajectory, const SampleTimes& times, std::span<double> y,
                       std::span<double> v, std::span<double> dy) {
  ForAllBlocks(trajectory, times,
               [&](const Arc<Dual<N>>& arc, std::size_t first, std::size_t size, const PhaseBlock& block) {
                 std::array<double, kBlock> by_w;  // d y / d w
                 for (std::size_t i = 0; i < size; ++i) {
                   const double turn = arc.b.a * block.cosines[i] - arc.a.a * block.sines[i];
                   y[first + i] = arc.c.a + arc.a.a * block.cosines[i] + arc.b.a * block.sines[i];
                   v[first + i] = arc.w.a * turn;
                   by_w[i] = block.since_start[i] * turn;
                 }
                 for (int p = 0; p < N; ++p) {
                   double* column = dy.data() + static_cast<std::size_t>(p) * times.size + first;
                   const double c = arc.c.v[p], a = arc.a.v[p], b = arc.b.v[p], w = arc.w.v[p];
                   for (std::size_t i = 0; i < size; ++i)
                     column[i] = c + a * block.cosines[i] + b * block.sines[i] + w * by_w[i];
                 }
               });
}

template class Trajectory<double>;
#define UICLINK_INSTANTIATE_DUAL(N)                                                                  \
  template class Trajectory<Dual<N>>;                                                                \
  template void CalcDisplacements(const Trajectory<Dual<N>>&, const SampleTimes&, std::span<double>, \
                                  std::span<double>, std::span<double>)
UICLINK_INSTANTIATE_DUAL(4);
UICLINK_INSTANTIATE_DUAL(6);
UICLINK_INSTANTIATE_DUAL(8);
UICLINK_INSTANTIATE_DUAL(10);
#undef UICLINK_INSTANTIATE_DUAL

}  // namespace uiclink
