#include "model/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uiclink {
namespace {

constexpr std::size_t kLanes = 4;   // turned together, so that the compiler can use vector instructions
constexpr std::size_t kBlock = 64;  // samples whose cosines and sines are at hand at a time

/// The turns of the phase from one sample to the next and over all lanes, for one angular frequency.
struct Turn {
  double w = 0;
  double cos_step = 1, sin_step = 0;
  double cos_lanes = 1, sin_lanes = 0;

  Turn() = default;
  Turn(double w_in, double step)
      : w(w_in),
        cos_step(std::cos(w * step)),
        sin_step(std::sin(w * step)),
        cos_lanes(std::cos(kLanes * w * step)),
        sin_lanes(std::sin(kLanes * w * step)) {}
};

/// The turns of the modes that a run passes through: a mode has one frequency, so each is evaluated once.
class Turns {
 public:
  explicit Turns(double step) : step_(step) {}

  const Turn& Find(Mode sliding, double w) {
    Turn& turn = turns_[sliding % kModes];
    if (turn.w != w) turn = Turn(w, step_);
    return turn;
  }

 private:
  static constexpr std::size_t kModes = 16;  // all modes of four sliders; more sliders share places
  double step_;
  std::array<Turn, kModes> turns_{};
};

/// cos and sin of phase, phase + step, ... : the phase is turned, not evaluated.
class Turner {
 public:
  Turner(double phase, const Turn& turn) : turn_(turn) {
    cos_[0] = std::cos(phase);
    sin_[0] = std::sin(phase);
    for (std::size_t j = 1; j < kLanes; ++j) {
      cos_[j] = cos_[j - 1] * turn.cos_step - sin_[j - 1] * turn.sin_step;
      sin_[j] = sin_[j - 1] * turn.cos_step + cos_[j - 1] * turn.sin_step;
    }
  }

  /// Writes the next `size` cosines and sines; size must be a multiple of kLanes except in the last call.
  void Next(std::size_t size, double* cosines, double* sines) {
    for (std::size_t i = 0; i < size; i += kLanes) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        cosines[i + j] = cos_[j];
        sines[i + j] = sin_[j];
        const double c = cos_[j] * turn_.cos_lanes - sin_[j] * turn_.sin_lanes;
        sin_[j] = sin_[j] * turn_.cos_lanes + cos_[j] * turn_.sin_lanes;
        cos_[j] = c;
      }
    }
  }

 private:
  std::array<double, kLanes> cos_{};
  std::array<double, kLanes> sin_{};
  const Turn& turn_;
};

/// Cosines and sines of w (t - t_start) for a block of samples, and t - t_start itself.
struct PhaseBlock {
  std::array<double, kBlock + kLanes> cosines;
  std::array<double, kBlock + kLanes> sines;
  std::array<double, kBlock> since_start;
};

/// Phases of the samples of a run, block by block.
class PhaseSampler {
 public:
  explicit PhaseSampler(const SampleTimes& times) : times_(times), turns_(times.step) {}

  /// Calls use(arc, first sample, number of samples, block) for all samples of a trajectory.
  template <typename Scalar, typename Use>
  void ForAllBlocks(const Trajectory<Scalar>& trajectory, Use use) {
    std::size_t from = 0;
    for (std::size_t j = 0; j < trajectory.arcs().size(); ++j) {
      const Arc<Scalar>& arc = trajectory.arcs()[j];
      const bool last = j + 1 == trajectory.arcs().size();
      const std::size_t to = last ? times_.size : times_.FindFirst(arc.t_end, from);
      if (from >= to) continue;
      ForBlocks(arc, from, to, use);
      from = to;
    }
  }

 private:
  template <typename Scalar, typename Use>
  void ForBlocks(const Arc<Scalar>& arc, std::size_t from, std::size_t to, Use& use) {
    const double w = Value(arc.w);
    Turner turner(w * (times_[from] - arc.t_start), turns_.Find(arc.sliding, w));
    for (std::size_t first = from; first < to; first += kBlock) {
      const std::size_t size = std::min(kBlock, to - first);
      for (std::size_t i = 0; i < size; ++i) block_.since_start[i] = times_[first + i] - arc.t_start;
      if (times_.times.empty()) {
        turner.Next(size, block_.cosines.data(), block_.sines.data());
      } else {
        for (std::size_t i = 0; i < size; ++i) {
          block_.cosines[i] = std::cos(w * block_.since_start[i]);
          block_.sines[i] = std::sin(w * block_.since_start[i]);
        }
      }
      use(arc, first, size, block_);
    }
  }

  SampleTimes times_;
  Turns turns_;
  PhaseBlock block_{};
};

}  // namespace

std::size_t SampleTimes::FindFirst(double t, std::size_t from) const {
  if (!times.empty()) {
    const auto begin = times.begin() + static_cast<std::ptrdiff_t>(from);
    return static_cast<std::size_t>(std::lower_bound(begin, times.end(), t) - times.begin());
  }
  const double index = std::ceil((t - first) / step);
  if (!(index > static_cast<double>(from))) return from;
  return index >= static_cast<double>(size) ? size : static_cast<std::size_t>(index);
}

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
  Scalar start = StartForces(j)[slider];
  if ((arcs_[j].sliding >> slider) & 1u) return start;
  return start - oscillator_.sliders()[slider].k * (y(t) - (arcs_[j].c + arcs_[j].a));
}

void CalcDisplacements(const Trajectory<double>& trajectory, const SampleTimes& times, std::span<double> y) {
  PhaseSampler(times).ForAllBlocks(
      trajectory, [&](const Arc<double>& arc, std::size_t first, std::size_t size, const PhaseBlock& block) {
        for (std::size_t i = 0; i < size; ++i) y[first + i] = arc.c + arc.a * block.cosines[i] + arc.b * block.sines[i];
      });
}

template <int N>
void CalcDisplacements(const Trajectory<Dual<N>>& trajectory, const SampleTimes& times, std::span<double> y,
                       std::span<double> v, std::span<double> dy) {
  std::array<double, kBlock> by_w{};  // d y / d w
  PhaseSampler(times).ForAllBlocks(
      trajectory, [&](const Arc<Dual<N>>& arc, std::size_t first, std::size_t size, const PhaseBlock& block) {
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
#define UICLINK_INSTANTIATE_DUAL(N)                                                                    \
  template class Trajectory<Dual<(N)>>;                                                                \
  template void CalcDisplacements(const Trajectory<Dual<(N)>>&, const SampleTimes&, std::span<double>, \
                                  std::span<double>, std::span<double>)
UICLINK_INSTANTIATE_DUAL(4);
UICLINK_INSTANTIATE_DUAL(6);
UICLINK_INSTANTIATE_DUAL(8);
UICLINK_INSTANTIATE_DUAL(10);
#undef UICLINK_INSTANTIATE_DUAL

}  // namespace uiclink
