#include "model/closed_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace uiclink {
namespace {

/// Kinetic energy over load as a function of the travel s between two breakouts:  q(s) = alpha + beta s - K s^2/2.
struct EnergyPiece {
  double alpha = 0, beta = 0, K = 0;

  double operator()(double s) const { return alpha + s * (beta - 0.5 * K * s); }
  double Centre() const { return beta / K; }
  /// The travel at which the kinetic energy is used up.
  double End() const {
    const double m = Centre();
    return m + std::sqrt(std::max(0.0, m * m + 2 * alpha / K));
  }
  /// Phase of the harmonic motion at travel s [rad].
  double Phase(double s) const { return std::atan2(s - Centre(), std::sqrt(std::max(0.0, 2 * (*this)(s) / K))); }
};

struct Breakout {
  double travel = std::numeric_limits<double>::infinity();
  double k = 0, T0 = 0, start_force = 0;
};

}  // namespace

HalfCycle CalcHalfCycle(const Oscillator<double>& oscillator, double A) {
  if (!(A > 0)) throw std::invalid_argument("CalcHalfCycle: A = " + std::to_string(A) + " m, must be > 0");
  std::array<Breakout, kMaxSliders> breakouts;
  const std::size_t n = oscillator.sliders().size();
  EnergyPiece piece{.alpha = 0, .beta = oscillator.k * A, .K = oscillator.k};
  for (std::size_t i = 0; i < n; ++i) {
    const Slider<double>& slider = oscillator.sliders()[i];
    const double start = std::min(slider.k * A, slider.T0);
    breakouts[i] = {.travel = (slider.T0 + start) / slider.k, .k = slider.k, .T0 = slider.T0, .start_force = start};
    piece.beta += start;  // while it sticks it does the work  start s - k s^2/2
    piece.K += slider.k;
  }
  std::sort(breakouts.begin(), breakouts.begin() + static_cast<std::ptrdiff_t>(n),
            [](const Breakout& l, const Breakout& r) { return l.travel < r.travel; });

  HalfCycle result;
  double s = 0, phase_sum = 0;
  std::size_t slid = 0;
  for (; slid < n && breakouts[slid].travel < piece.End(); ++slid) {
    const Breakout& b = breakouts[slid];
    phase_sum += (piece.Phase(b.travel) - piece.Phase(s)) / std::sqrt(oscillator.g * piece.K);
    s = b.travel;
    // Its work  start s - k s^2/2  goes on from here as a straight line of slope -T0.
    piece.alpha += (b.start_force + b.T0 - 0.5 * b.k * b.travel) * b.travel;
    piece.beta -= b.start_force + b.T0;
    piece.K -= b.k;
  }
  const double end = piece.End();
  phase_sum += (0.5 * std::numbers::pi - piece.Phase(s)) / std::sqrt(oscillator.g * piece.K);
  for (std::size_t i = 0; i < slid; ++i) result.loss += breakouts[i].T0 * (end - breakouts[i].travel);
  result.next_amplitude = end - A;
  result.duration = phase_sum;
  return result;
}

double CalcFrequency(const Oscillator<double>& oscillator, double A) {
  return 0.5 / CalcHalfCycle(oscillator, A).duration;
}

double CalcLossPerCycle(const Oscillator<double>& oscillator, double A) {
  double loss = 0;
  for (const Slider<double>& slider : oscillator.sliders())
    loss += 4 * slider.T0 * std::max(0.0, A - slider.T0 / slider.k);
  return loss;
}

double CalcSlidingFrequency(const Oscillator<double>& oscillator) { return std::sqrt(oscillator.g * oscillator.k); }

double CalcRollingFrequency(const Oscillator<double>& oscillator) {
  double stiffness = oscillator.k;
  for (const Slider<double>& slider : oscillator.sliders()) stiffness += slider.k;
  return std::sqrt(oscillator.g * stiffness);
}

double CalcEnergy(const Oscillator<double>& oscillator, const State<double>& state) {
  double energy = state.v * state.v / (2 * oscillator.g) + 0.5 * oscillator.k * state.y * state.y;
  for (std::size_t i = 0; i < oscillator.sliders().size(); ++i)
    energy += state.T[i] * state.T[i] / (2 * oscillator.sliders()[i].k);
  return energy;
}

double CalcDissipation(const Oscillator<double>& oscillator, const Trajectory<double>& trajectory, double t) {
  double dissipated = 0;
  for (const Arc<double>& arc : trajectory.arcs()) {
    if (arc.t_start >= t) break;
    const double phase = arc.w * (std::min(arc.t_end, t) - arc.t_start);
    const double slip = std::abs(arc.a * (std::cos(phase) - 1) + arc.b * std::sin(phase));
    for (std::size_t i = 0; i < oscillator.sliders().size(); ++i)
      if ((arc.sliding >> i) & 1u) dissipated += oscillator.sliders()[i].T0 * slip;
  }
  return dissipated;
}

}  // namespace uiclink
