#pragma once

#include <cmath>
#include <numbers>

#include "model/scalar.h"
#include "vehicle/lanes.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

// Vertical springs (chapter 5). s [m] is the compression from the unloaded length, s_rate = s' [m/s]; F [N] > 0 pushes
// the ends apart. None of them knows that a wheel can leave the rail or that a buckle has a stop: s < 0 pulls.
// T is double or Dual<N>, V one of them or Lanes: four springs at once. Spring is the spring's structure, or one that
// has the same numbers in Lanes: of four wagons. No function allocates.

// --- linear ---

/// F = k s + d s'.
template <typename Spring, typename V>
[[gnu::always_inline]] inline V CalcSpringForce(const Spring& spring, const V& s, const V& s_rate) {
  return spring.k * s + spring.d * s_rate;
}

// --- parabolic, with its stage ---

/// Which leaves carry. The force is continuous where they change, its slope is not: F'' jumps there, so an integrator
/// that holds the stage between events keeps its order.
enum class SpringStage { kMainLeaf, kSupplementary };

/// The stage of a compression. At s = s0 exactly both give the same force; it counts as supplementary, as in (5.1).
template <typename T>
SpringStage StageOf(const ParabolicSpring& spring, const T& s) {
  return Value(s) < spring.s0 ? SpringStage::kMainLeaf : SpringStage::kSupplementary;
}

/// Positive while the main leaf carries alone [m]; its zero is the event.
template <typename T>
T CalcStageGuard(const ParabolicSpring& spring, const T& s) {
  return spring.s0 - s;
}

/// Force without damping in a given stage:  k1 s  or  F0 + k2 (s - s0).
template <typename T>
T CalcStaticForce(const ParabolicSpring& spring, SpringStage stage, const T& s) {
  if (stage == SpringStage::kMainLeaf) return spring.k1() * s;
  return spring.F0 + spring.k2 * (s - spring.s0);
}
/// The stage found out from s.
template <typename Spring, typename V>
[[gnu::always_inline]] inline V CalcStaticForce(const Spring& spring, const V& s) {
  return Choose(s < V(spring.s0), spring.k1() * s, spring.F0 + spring.k2 * (s - spring.s0));
}

/// (5.1): static force + d s'. @param d  damping [N s/m], see DampingOf.
template <typename T>
T CalcSpringForce(const ParabolicSpring& spring, double d, SpringStage stage, const T& s, const T& s_rate) {
  return CalcStaticForce(spring, stage, s) + d * s_rate;
}
template <typename Spring, typename D, typename V>
[[gnu::always_inline]] inline V CalcSpringForce(const Spring& spring, const D& d, const V& s, const V& s_rate) {
  return CalcStaticForce(spring, s) + d * s_rate;
}

/// The damping of a run is fixed before it: that of the loaded wagon where its static load engages the supplementary
/// leaf (section 5.2) [N s/m].
inline double DampingOf(const ParabolicSpring& spring, double static_load) {
  return static_load > spring.F0 ? spring.d_loaded : spring.d_unloaded;
}

/// Energy stored without damping [J]: the integral of the static force from 0 to s.
template <typename T>
T CalcSpringEnergy(const ParabolicSpring& spring, const T& s) {
  if (StageOf(spring, s) == SpringStage::kMainLeaf) return 0.5 * spring.k1() * s * s;
  const T beyond = s - spring.s0;
  return 0.5 * spring.F0 * spring.s0 + spring.F0 * beyond + 0.5 * spring.k2 * beyond * beyond;
}

// --- Fancher's leaf spring ---
//
// The force lags behind the envelopes by the slope times beta, so a long cycle loses 4 a (F_r - c beta) about s = 0,
// and 4 a (F_r + mu0 c s - c beta) about a compression s. Where beta is larger than (F_r + mu0 c s)/c the spring gives
// energy instead of losing it: a limit of the equation, not of this code (6.7 mm for section 5.3.1 about s = 0).

/// The envelope that the force goes over to:  c (1 + mu0) s + F_r  while loading,  c (1 - mu0) s - F_r  while
/// unloading.
/// @param loading  whether s grows.
template <typename T>
T CalcEnvelope(const LeafSpring& spring, bool loading, const T& s) {
  return loading ? T(spring.c * (1 + spring.mu0) * s + spring.F_r) : T(spring.c * (1 - spring.mu0) * s - spring.F_r);
}

/// Slope of that envelope [N/m].
inline double EnvelopeSlope(const LeafSpring& spring, bool loading) {
  return spring.c * (loading ? 1 + spring.mu0 : 1 - spring.mu0);
}

/// F' = (F_env - F) |s'| / beta [N/s], the direction of motion given: between reversals it does not change, and |s'| is
/// smooth in it.
template <typename T>
T CalcLeafRate(const LeafSpring& spring, bool loading, const T& F, const T& s, const T& s_rate) {
  const T travel = loading ? s_rate : T(-s_rate);
  return (CalcEnvelope(spring, loading, s) - F) * travel / spring.beta;
}
/// The direction found out from s'.
template <typename Spring, typename V>
[[gnu::always_inline]] inline V CalcLeafRate(const Spring& spring, const V& F, const V& s, const V& s_rate) {
  const V loading = (spring.c * (1 + spring.mu0)) * s + spring.F_r - F;
  const V unloading = F - ((spring.c * (1 - spring.mu0)) * s - spring.F_r);
  return Choose(V(0.0) < s_rate, loading, unloading) * s_rate * (1 / spring.beta);
}

/// The force after a one-way travel from (s_start, F_start) to s, exactly. With E the envelope of that direction, E'
/// its slope and u = |s - s_start|:
///   F = E(s) - sign E' beta + (F_start - E(s_start) + sign E' beta) exp(-u / beta),   sign = +1 loading, -1 unloading.
template <typename T>
T CalcLeafForce(const LeafSpring& spring, const T& s_start, const T& F_start, const T& s) {
  using std::exp;
  const bool loading = Value(s) >= Value(s_start);
  const double sign = loading ? 1 : -1;
  const double lag = sign * EnvelopeSlope(spring, loading) * spring.beta;
  const T u = sign * (s - s_start);
  const T left = exp(-u / spring.beta);
  return CalcEnvelope(spring, loading, s) - lag + (F_start - CalcEnvelope(spring, loading, s_start) + lag) * left;
}

/// Work done on the spring along that travel, the integral of F ds [J].
template <typename T>
T CalcLeafWork(const LeafSpring& spring, const T& s_start, const T& F_start, const T& s) {
  using std::expm1;
  const bool loading = Value(s) >= Value(s_start);
  const double sign = loading ? 1 : -1;
  const double lag = sign * EnvelopeSlope(spring, loading) * spring.beta;
  const T u = sign * (s - s_start);
  const T envelope_start = CalcEnvelope(spring, loading, s_start);
  const T along = (s - s_start) * (0.5 * (envelope_start + CalcEnvelope(spring, loading, s)) - lag);
  return along - sign * spring.beta * (F_start - envelope_start + lag) * expm1(-u / spring.beta);
}

// --- static compression under a load [N] ---

inline double CalcStaticCompression(const LinearSpring& spring, double load) { return load / spring.k; }
inline double CalcStaticCompression(const ParabolicSpring& spring, double load) {
  return load <= spring.F0 ? load / spring.k1() : spring.s0 + (load - spring.F0) / spring.k2;
}
/// Fancher's spring carries a load anywhere between its envelopes; this is the middle, load / c.
inline double CalcStaticCompression(const LeafSpring& spring, double load) { return load / spring.c; }

// --- dry friction as a reference for damping (section 5.3) ---

/// Work of a friction force mu N in a cycle of amplitude a: 4 a mu N [J]. Independent of frequency.
inline double CalcFrictionWork(double mu, double N, double a) { return 4 * a * mu * N; }

/// The damper that loses as much in a cycle of amplitude a at the angular frequency w:  pi d w a^2 = 4 a mu N,
///   d = 4 mu N / (pi w a) [N s/m]. Table 5.1 took w = 2 pi (1 Hz), which it does not say.
inline double CalcEquivalentDamping(double mu, double N, double a, double w) {
  return CalcFrictionWork(mu, N, a) / (std::numbers::pi * w * a * a);
}

}  // namespace uiclink
