#include "vehicle/hunting/running_spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "vehicle/spectrum_peaks.h"
#include "vehicle/stability.h"

namespace uiclink {

const std::array<SpectrumMotion, kSpectrumMotions> kSpectrumTable{
    {{"front_longitudinal", wheelset::kX, false},
     {"front_lateral", wheelset::kY, false},
     {"front_yaw", wheelset::kPsi, true},
     {"rear_longitudinal", kRearWheelset + wheelset::kX, false},
     {"rear_lateral", kRearWheelset + wheelset::kY, false},
     {"rear_yaw", kRearWheelset + wheelset::kPsi, true},
     {"body_lateral", kBody + body::kY, false},
     {"body_roll", kBody + body::kPhi, true},
     {"body_yaw", kBody + body::kPsi, true}}};

const char* Name(Locking locking) {
  switch (locking) {
    case Locking::kLocked:
      return "locked";
    case Locking::kFree:
      return "free";
    case Locking::kUndecided:
      return "undecided";
  }
  return "?";
}

const MotionSpectrum& RunningSpectrum::motion(const std::string& name) const {
  const auto entry = std::ranges::find_if(kSpectrumTable, [&](const SpectrumMotion& m) { return m.name == name; });
  if (entry == kSpectrumTable.end()) throw std::invalid_argument("RunningSpectrum: no motion has the name " + name);
  return motions[static_cast<std::size_t>(entry - kSpectrumTable.begin())];
}

namespace {

constexpr std::size_t kPieces = 6;      ///< of the window in which phases are looked at
constexpr double kLockedTurns = 0.1;    ///< a line that is locked moves by less against its ratio
constexpr double kDecidedTurns = 0.25;  ///< three standard errors above it decide nothing
constexpr double kPeakError = 0.02;     ///< of a peak's frequency [lines] (spectrum_peaks.h)
constexpr double kTurn = 2 * std::numbers::pi;

constexpr std::array kBaseMotions{"front_lateral", "rear_lateral", "body_lateral"};

/// Phase [rad] of a line in the pieces of the window, less that of a steady line of frequency f; continuous.
using Phases = std::array<double, kPieces>;

/// None where a piece is too short to tell the line from a constant.
std::optional<Phases> FollowPhase(std::span<const double> samples, double hz, double f) {
  const std::size_t n = samples.size() / kPieces;
  if (!(f > 2 * hz / static_cast<double>(n))) return std::nullopt;
  Phases phases{};
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    const std::span<const double> part = samples.subspan(piece * n, n);
    std::complex<double> line = 0, constant = 0;
    double sum = 0, weight = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double w = HannWindow(i, n);
      const std::complex<double> turned = std::polar(w, -kTurn * f * static_cast<double>(piece * n + i) / hz);
      line += turned * part[i];
      constant += turned;
      sum += w * part[i];
      weight += w;
    }
    phases[piece] = std::arg(line - constant * (sum / weight));
    if (piece > 0) phases[piece] -= kTurn * std::round((phases[piece] - phases[piece - 1]) / kTurn);
  }
  return phases;
}

/// A straight line through phases at equal distances.
struct Slope {
  double value = 0;  ///< [rad] per piece
  double error = 0;  ///< standard error, from the scatter
};
Slope FitSlope(const Phases& phases) {
  const double n = kPieces, middle = 0.5 * (n - 1);
  const double mean = std::accumulate(phases.begin(), phases.end(), 0.0) / n;
  double square = 0, product = 0, scatter = 0;
  for (std::size_t i = 0; i < kPieces; ++i) {
    const double at = static_cast<double>(i) - middle;
    square += at * at;
    product += at * (phases[i] - mean);
  }
  const double slope = product / square;
  for (std::size_t i = 0; i < kPieces; ++i) {
    const double off = phases[i] - mean - slope * (static_cast<double>(i) - middle);
    scatter += off * off;
  }
  return {slope, std::sqrt(scatter / ((n - 2) * square))};
}

/// A line that has been followed over the window.
struct Followed {
  Phases phases{};       ///< against peak_hz
  double peak_hz = 0;    ///< [Hz]
  double frequency = 0;  ///< [Hz]
  double error = 0;      ///< standard error [Hz]
};
std::optional<Followed> Follow(std::span<const double> samples, double hz, double f) {
  const std::optional<Phases> phases = FollowPhase(samples, hz, f);
  if (!phases) return std::nullopt;
  const double pieces_hz = hz / static_cast<double>(samples.size() / kPieces);
  const Slope slope = FitSlope(*phases);
  return Followed{.phases = *phases,
                  .peak_hz = f,
                  .frequency = f + slope.value * pieces_hz / kTurn,
                  .error = slope.error * pieces_hz / kTurn};
}

/// Standard error of the ratio of two lines: what scatters in the one as it does in the other is no error.
double CalcRatioError(const Followed& line, const Followed& base, double pieces_hz) {
  const double ratio = line.frequency / base.frequency;
  Phases difference{};
  for (std::size_t i = 0; i < kPieces; ++i) difference[i] = line.phases[i] - ratio * base.phases[i];
  return FitSlope(difference).error * pieces_hz / kTurn / base.frequency;
}

void FindNearestRatio(SpectralLine* line) {
  double best = std::numeric_limits<double>::infinity();
  for (int q = 1; q <= kMostSubharmonic; ++q) {
    const int p = std::max(1, static_cast<int>(std::lround(line->ratio * q)));
    const double off = std::abs(line->ratio - static_cast<double>(p) / q);
    if (off >= best - 1e-12) continue;
    best = off;
    line->p = p;
    line->q = q;
  }
}

/// Frequency, ratio and locking of a line; base: none where phases cannot be followed.
void Judge(std::span<const double> samples, const RunningSpectrum& whole, const std::optional<Followed>& base,
           SpectralLine* line) {
  const std::optional<Followed> followed = base ? Follow(samples, whole.hz, line->frequency) : std::nullopt;
  if (followed) line->frequency = followed->frequency;
  line->ratio = line->frequency / whole.base_hz;
  line->ratio_error = followed
                          ? CalcRatioError(*followed, *base, whole.hz / static_cast<double>(samples.size() / kPieces))
                          : kPeakError / whole.periods() * std::hypot(1, line->ratio);
  FindNearestRatio(line);
  line->slip = (line->ratio - static_cast<double>(line->p) / line->q) * whole.periods();
  if (!followed) return;
  const double error = 3 * line->ratio_error * whole.periods();
  if (std::abs(line->slip) - error > kLockedTurns) {
    line->locking = Locking::kFree;
  } else if (error <= kDecidedTurns) {
    line->locking = Locking::kLocked;
  }
}

MotionSpectrum CalcMotionSpectrum(const std::vector<double>& samples, double hz, std::size_t segments) {
  MotionSpectrum spectrum{.power = CalcPowerSpectrum(samples, hz, segments), .rms = 0, .mean = 0, .lines = {}};
  const auto n = static_cast<double>(samples.size());
  spectrum.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / n;
  double square = 0;
  for (const double x : samples) square += (x - spectrum.mean) * (x - spectrum.mean);
  spectrum.rms = std::sqrt(square / n);
  if (spectrum.rms < kRest) return spectrum;
  for (const SpectrumPeak& peak : FindSpectrumPeaks(samples, hz, kMostLines))
    spectrum.lines.push_back({.frequency = peak.frequency, .amplitude = peak.amplitude, .near = {}});
  return spectrum;
}

}  // namespace

PowerSpectrum CalcPowerSpectrum(std::span<const double> samples, double hz, std::size_t segments) {
  constexpr std::size_t kLeast = 16;
  if (!(hz > 0) || !std::isfinite(hz)) throw std::invalid_argument("the rate of samples must be positive");
  const std::size_t n = segments > 0 ? 2 * samples.size() / (segments + 1) : 0;
  if (n < kLeast) throw std::invalid_argument("a piece of a spectrum must have at least 16 samples");
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) squares += HannWindow(i, n) * HannWindow(i, n);
  PowerSpectrum spectrum{.line_hz = hz / static_cast<double>(n), .density = std::vector<double>(n / 2 + 1)};
  const double scale = 2 / (hz * squares * static_cast<double>(segments));
  for (std::size_t piece = 0; piece < segments; ++piece) {
    const std::vector<std::complex<double>> lines = TransformHann(samples.subspan(piece * (n / 2), n));
    for (std::size_t i = 0; i < spectrum.density.size(); ++i) spectrum.density[i] += scale * std::norm(lines[i]);
  }
  // Lines that are their own mirror image.
  spectrum.density.front() *= 0.5;
  if (n % 2 == 0) spectrum.density.back() *= 0.5;
  return spectrum;
}

RunningSpectrum CalcRunningSpectrum(std::span<const SimulationSample> samples, double hz, std::size_t segments) {
  RunningSpectrum result{.hz = hz,
                         .duration = static_cast<double>(samples.size()) / hz,
                         .segments = segments,
                         .base_motion = {},
                         .motions = {}};
  std::array<std::vector<double>, kSpectrumMotions> values;
  for (std::size_t m = 0; m < kSpectrumMotions; ++m) {
    values[m].reserve(samples.size());
    for (const SimulationSample& sample : samples) values[m].push_back(sample.x[kSpectrumTable[m].place]);
    result.motions[m] = CalcMotionSpectrum(values[m], hz, segments);
    if (!result.motions[m].lines.empty()) result.at_rest = false;
  }
  const std::vector<double>* base_samples = nullptr;
  for (std::size_t m = 0; m < kSpectrumMotions && base_samples == nullptr; ++m) {
    const std::string name = kSpectrumTable[m].name;
    if (std::ranges::find(kBaseMotions, name) == kBaseMotions.end() || result.motions[m].lines.empty()) continue;
    base_samples = &values[m];
    result.base_motion = name;
    result.base_hz = result.motions[m].lines.front().frequency;
  }
  if (base_samples == nullptr) return result;
  std::optional<Followed> base;
  if (result.periods() >= kLeastPeriods) base = Follow(*base_samples, hz, result.base_hz);
  if (base) result.base_hz = base->frequency;
  result.base_error = base ? base->error : kPeakError / result.duration;
  int ratios = 0;  // p:q in lowest terms between two whole numbers
  for (int q = 1; q <= kMostSubharmonic; ++q)
    for (int p = 0; p < q; ++p) ratios += std::gcd(p, q) == 1;
  result.chance = std::min(1.0, 2 * kLockedTurns * ratios / result.periods());
  for (std::size_t m = 0; m < kSpectrumMotions; ++m)
    for (SpectralLine& line : result.motions[m].lines) Judge(values[m], result, base, &line);
  return result;
}

// --- free vibrations -------------------------------------------------------------------------------------------------

namespace {

std::vector<LinearMode> FindVibrations(const Wagon& wagon, double V) {
  constexpr double kLowest = 0.3, kHighest = 20, kMostDamping = 0.5;
  std::vector<LinearMode> modes = CalcModes(Linearize(wagon, V));
  std::erase_if(modes, [](const LinearMode& mode) {
    const double f = mode.lambda.imag() / kTurn;
    return !(f >= kLowest && f <= kHighest && mode.damping_ratio() < kMostDamping);
  });
  std::ranges::sort(modes, {}, [](const LinearMode& mode) { return mode.lambda.imag(); });
  return modes;
}

/// "longitudinal" for either wheelset, else the motion that is largest, angles by a lever of 1 m.
std::string NameMode(const LinearMode& mode) {
  const auto largest = std::ranges::max_element(kSpectrumTable, {},
                                                [&](const SpectrumMotion& m) { return std::abs(mode.shape[m.place]); });
  const std::string name = largest->name;
  return name.ends_with("_longitudinal") ? "longitudinal" : name;
}

/// 1: the same shape, 0: nothing in common.
double CompareShapes(const LinearMode& a, const LinearMode& b) {
  std::complex<double> product = 0;
  double aa = 0, bb = 0;
  for (const SpectrumMotion& m : kSpectrumTable) {
    product += std::conj(a.shape[m.place]) * b.shape[m.place];
    aa += std::norm(a.shape[m.place]);
    bb += std::norm(b.shape[m.place]);
  }
  return aa * bb > 0 ? std::abs(product) / std::sqrt(aa * bb) : 0;
}

}  // namespace

std::vector<FreeVibration> FindFreeVibrations(const Wagon& wagon, const Wagon& sliding, double V) {
  constexpr double kAlike = 0.8, kSame = 0.01;
  const std::vector<LinearMode> others = FindVibrations(sliding, V);
  std::vector<FreeVibration> vibrations;
  for (const LinearMode& mode : FindVibrations(wagon, V)) {
    const double f = mode.lambda.imag() / kTurn;
    FreeVibration vibration{.name = NameMode(mode), .stuck_hz = f, .sliding_hz = f, .decay = mode.lambda.real()};
    double best = kAlike;
    for (const LinearMode& other : others) {
      const double alike = CompareShapes(mode, other);
      if (NameMode(other) != vibration.name || alike < best) continue;
      best = alike;
      vibration.sliding_hz = other.lambda.imag() / kTurn;
    }
    // The two wheelsets swing at one frequency.
    if (!vibrations.empty() && vibrations.back().name == vibration.name && f - vibrations.back().stuck_hz < kSame * f)
      continue;
    vibrations.push_back(std::move(vibration));
  }
  return vibrations;
}

void NameFreeLines(const std::vector<FreeVibration>& vibrations, RunningSpectrum* spectrum) {
  constexpr double kNear = 0.02;
  for (std::size_t m = 0; m < kSpectrumMotions; ++m) {
    const bool longitudinal = std::string(kSpectrumTable[m].name).ends_with("_longitudinal");
    for (SpectralLine& line : spectrum->motions[m].lines) {
      if (line.locking == Locking::kLocked) continue;
      double best = std::numeric_limits<double>::infinity();
      for (const FreeVibration& vibration : vibrations) {
        const auto [low, high] = std::minmax(vibration.stuck_hz, vibration.sliding_hz);
        const double off = std::abs(line.frequency - vibration.stuck_hz);
        const bool inside = line.frequency >= low * (1 - kNear) && line.frequency <= high * (1 + kNear);
        if ((vibration.name == "longitudinal") != longitudinal || !inside || off >= best) continue;
        best = off;
        line.near = vibration.name;
      }
    }
  }
}

}  // namespace uiclink
