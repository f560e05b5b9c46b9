#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vehicle/simulation.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// A motion of tables 10.1 and 10.2.
struct SpectrumMotion {
  const char* name;   ///< "front_longitudinal", "body_roll"
  std::size_t place;  ///< in the state vector
  bool angle;         ///< rad, else m
};
/// Longitudinal, lateral, yaw of both wheelsets; lateral, roll, yaw of the body.
inline constexpr std::size_t kSpectrumMotions = 9;
extern const std::array<SpectrumMotion, kSpectrumMotions> kSpectrumTable;

/// One-sided power spectral density: density[i] at i line_hz, unit^2/Hz. Sum of density x line_hz is the variance of
/// the samples under the window.
struct PowerSpectrum {
  double line_hz = 0;
  std::vector<double> density;
};

/// Of evenly spaced samples, by Hann's window, the mean under it removed:
///   density = 2 |sum of w x exp(..)|^2 / (hz sum of w^2)    (half of that at 0 and at hz/2).
/// @param segments  Welch: the mean of so many pieces, each overlapping the next by half.
/// @throws std::invalid_argument unless hz > 0, segments >= 1 and a piece has 16 samples.
PowerSpectrum CalcPowerSpectrum(std::span<const double> samples, double hz, std::size_t segments = 1);

/// Whether a line keeps step with the base frequency.
enum class Locking {
  kLocked,     ///< against p:q its phase moves by less than a tenth of a turn over the window
  kFree,       ///< it moves by more, beyond its error
  kUndecided,  ///< the phase wanders, or the window is too short (kLeastPeriods)
};
const char* Name(Locking locking);

struct SpectralLine {
  double frequency = 0;    ///< [Hz]; from the phase over the window where there is one, else from the peak
  double amplitude = 0;    ///< of a sine that makes this peak [m], [rad]
  double ratio = 0;        ///< to the base frequency
  double ratio_error = 0;  ///< standard error, from the scatter of the phase against that of the base
  int p = 0, q = 1;        ///< the nearest ratio p:q with q <= kMostSubharmonic
  double slip = 0;         ///< turns by which the phase moves against p:q over the window
  Locking locking = Locking::kUndecided;
  std::string near;  ///< a free vibration that a line which is not locked may be; empty: none
};

struct MotionSpectrum {
  PowerSpectrum power;
  double rms = 0;                   ///< about the mean [m], [rad]
  double mean = 0;                  ///< [m], [rad]
  std::vector<SpectralLine> lines;  ///< by falling height (FindSpectrumPeaks)
};

/// A way in which the wagon vibrates by itself: between the frequency with all joints stuck (small) and with all of
/// them sliding (large).
struct FreeVibration {
  std::string name;       ///< of the motion that is largest: "longitudinal", "body_roll"
  double stuck_hz = 0;    ///< [Hz]
  double sliding_hz = 0;  ///< [Hz]; stuck_hz where no such mode is found
  double decay = 0;       ///< all stuck: real part of the eigenvalue [1/s]
};

/// Spectra of a run.
struct RunningSpectrum {
  double hz = 0;        ///< of the samples
  double duration = 0;  ///< [s]
  std::size_t segments = 1;
  bool at_rest = true;      ///< nothing moves by kRest or more: there are no lines
  std::string base_motion;  ///< whose strongest line is the base
  double base_hz = 0;       ///< 0 at rest
  double base_error = 0;    ///< standard error [Hz]
  double chance = 0;        ///< share of all frequencies that would pass for locked
  std::array<MotionSpectrum, kSpectrumMotions> motions;

  double periods() const { return duration * base_hz; }
  const MotionSpectrum& motion(const std::string& name) const;
};

/// Displacements below it are no motion [m], [rad] (rms): a tolerance of a step times a hundred.
inline constexpr double kRest = 1e-7;
inline constexpr int kMostSubharmonic = 3;
inline constexpr double kLeastPeriods = 18;  ///< of the base for phases to be followed: three in each of six pieces
inline constexpr std::size_t kMostLines = 6;

/// The base is the strongest line of the front wheelset's lateral motion, or of the first of rear and body lateral
/// where that one rests.
/// @param samples  at equal distances.
/// @throws std::invalid_argument as CalcPowerSpectrum.
RunningSpectrum CalcRunningSpectrum(std::span<const SimulationSample> samples, double hz, std::size_t segments = 1);

/// The free vibrations from 0.3 to 20 Hz that are damped by less than half, by frequency.
/// @param sliding  the same wagon with the springs of its joints taken away.
std::vector<FreeVibration> FindFreeVibrations(const Wagon& wagon, const Wagon& sliding, double V);

/// Names the free vibration beside lines that are not locked: between its two frequencies, or within 2 %.
/// Longitudinal lines with longitudinal vibrations, all others with the others.
void NameFreeLines(const std::vector<FreeVibration>& vibrations, RunningSpectrum* spectrum);

}  // namespace uiclink
