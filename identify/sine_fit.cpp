#include "identify/sine_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

#include "identify/local_fit.h"
#include "identify/sliding_arc.h"

namespace uiclink {
namespace {

/// Cut-off over the amplitude at which rolling starts.
constexpr double kCutoffMargin = 1.2;
/// Shortest published arc [rad]: below it the two points lie so close that their noise decides.
constexpr double kMinPhase = 0.5;
/// What the estimated release may be late by [s]; three of its standard deviations on simulated records.
constexpr double kReleaseError = 0.01;
/// Half width of the window that locates a crossing [rad].
constexpr double kCrossingWidth = 0.3;

double Square(double x) { return x * x; }

/// Half the distance between the first extrema of the rolling phase [m].
double RollingAmplitude(const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  const std::size_t i = phases.rolling_start;
  return 0.5 * std::abs(e[i + 1].y - e[i].y);
}

/// Where the motion crosses `level` between samples `from` and `to`, which it does once.
std::optional<double> FindCrossing(const Record& record, std::size_t from, std::size_t to, double level, double w) {
  const bool rises = record.y[to] > record.y[from];
  const auto crossing = std::partition_point(record.y.begin() + static_cast<std::ptrdiff_t>(from),
                                             record.y.begin() + static_cast<std::ptrdiff_t>(to),
                                             [&](double y) { return rises ? y < level : y > level; });
  const std::size_t i = static_cast<std::size_t>(crossing - record.y.begin());
  const std::optional<LocalFit> fit = FitLocally(record.t, record.y, i, kCrossingWidth / w, w);
  return fit ? fit->FindCrossing(level) : std::nullopt;
}

/// 2 pi N / (t2 - t1) between crossings of the local centre, upward or downward both.
bool FindRollingFrequency(const Record& record, const Phases& phases, int periods, SineFit* fit) {
  const std::vector<Extremum>& e = phases.extrema;
  // At the start of the phase the joints still slip a little; two periods on, or a quarter of a short phase, they do
  // not.
  const std::size_t skipped = std::min<std::size_t>(4, (e.size() - phases.rolling_start) / 4);
  const std::size_t first = std::max<std::size_t>(phases.rolling_start + skipped, 1);
  if (e.size() < first + 5) return false;
  // A crossing lies between extrema i, i+1; its centre needs one more on each side.
  const int available = static_cast<int>((e.size() - 3 - first) / 2);
  fit->rolling_periods = periods > 0 ? std::min(periods, available) : available;
  if (fit->rolling_periods < 1) return false;
  const auto crossing = [&](std::size_t i) {
    const double centre = (e[i - 1].y + 3 * e[i].y + 3 * e[i + 1].y + e[i + 2].y) / 8;
    const double w = std::numbers::pi / (e[i + 1].t - e[i].t);
    return FindCrossing(record, e[i].index, e[i + 1].index, centre, w);
  };
  const std::optional<double> t1 = crossing(first);
  const std::optional<double> t2 = crossing(first + 2 * static_cast<std::size_t>(fit->rolling_periods));
  if (!t1 || !t2) return false;
  fit->rolling_from = *t1;
  fit->rolling_to = *t2;
  fit->omega_rolling = 2 * std::numbers::pi * fit->rolling_periods / (*t2 - *t1);
  return true;
}

/// The published method on the arc before extremum i: crossing of the cut-off, extremum, w.
std::optional<SlidingArc> FitPublished(const Record& record, const Phases& phases, const SineFit& fit, std::size_t i) {
  const Extremum& e = phases.extrema[i];
  const double side = e.y > fit.zero ? 1.0 : -1.0;
  SlidingArc arc{.extremum_t = e.t, .extremum = side * (e.y - fit.zero)};
  if (!(fit.cutoff < arc.extremum * std::cos(kMinPhase))) return std::nullopt;
  std::size_t from = e.index;
  const std::size_t limit = i > 0 ? phases.extrema[i - 1].index : 0;
  while (from > limit && side * (record.y[from] - fit.zero) > fit.cutoff) --from;
  if (side * (record.y[from] - fit.zero) > fit.cutoff) return std::nullopt;  // the record starts above the cut-off
  const double w = std::acos(fit.cutoff / arc.extremum) / (e.t - record.t[from]);
  // A few samples back, so that noise does not hide the crossing from the search.
  from -= std::min<std::size_t>(from - limit, 3);
  const std::optional<double> t1 = FindCrossing(record, from, e.index, fit.zero + side * fit.cutoff, w);
  if (!t1 || (i == 0 && *t1 < phases.release_s)) return std::nullopt;
  arc.omega_published = std::acos(fit.cutoff / arc.extremum) / (e.t - *t1);
  arc.k_published = Square(arc.omega_published) / record.g;
  return arc;
}

/// The samples of the arc before extremum i that the corrected method uses.
ArcWindow FindWindow(const Record& record, const Phases& phases, double cutoff, std::size_t i) {
  const Extremum& e = phases.extrema[i];
  if (i > 0) {
    const Extremum& before = phases.extrema[i - 1];
    return FindSlidingArc(record.t, record.y, before.index, before.y, e.index, e.t, 2 * cutoff);
  }
  // The push is over when the published arc starts; whatever lies before is not known to slide freely.
  ArcWindow arc{.first = e.index, .last = e.index + (record.t[e.index] > e.t ? 0 : 1), .t = e.t};
  arc.side = e.y > phases.centre ? 1 : -1;
  while (arc.first > 0 && record.t[arc.first - 1] >= phases.release_s + kReleaseError &&
         arc.side * (record.y[arc.first - 1] - phases.centre) > cutoff)
    --arc.first;
  return arc;
}

void FitArcByItself(const Record& record, const ArcWindow& window, double zero, SlidingArc* arc) {
  const std::optional<ArcFit> fit = FitSlidingArcs(record.t, record.y, {&window, 1}, arc->omega_published);
  if (!fit) return;
  arc->k_corrected = Square(fit->omega) / record.g;
  arc->k_corrected_std = 2 * fit->omega * fit->omega_std / record.g;
  arc->centre = fit->zero - zero;
}

/// All arcs together.
void FitCorrected(const Record& record, std::span<const ArcWindow> windows, SineFit* fit) {
  const std::optional<ArcFit> arcs = FitSlidingArcs(record.t, record.y, windows, fit->omega_sliding);
  if (!arcs) return;
  const double w = arcs->omega, g = record.g;
  fit->k_corrected = w * w / g;
  fit->k_corrected_std = 2 * w * arcs->omega_std / g;
  fit->sum_ki_corrected = Square(fit->omega_rolling) / g - fit->k_corrected;
  // Arcs of one side do not tell zero from shift; then the published zero has to do.
  const double shift = arcs->both_sides ? arcs->shift : windows[0].side * (fit->zero - arcs->zero);
  const double shift_std = arcs->both_sides ? arcs->shift_std : arcs->zero_std;
  fit->T0_corrected = fit->k_corrected * shift;
  fit->T0_corrected_std = std::sqrt(Square(w * w * shift_std) + Square(2 * w * shift * arcs->omega_std) +
                                    4 * w * w * w * shift * arcs->covariance_omega_shift) /
                          g;
}

/// T0 from the loss of the first free cycle.
void FindT0(const Phases& phases, SineFit* fit) {
  const std::vector<Extremum>& e = phases.extrema;
  const double s0 = std::abs(e[1].y - e[0].y), s1 = std::abs(e[2].y - e[1].y);
  // alpha T0^2 - 2 T0 + loss = 0; the smaller root is the one whose motion still slides.
  const double alpha = 2 / fit->sum_ki * (1 / s0 + 1 / s1), loss = 0.5 * fit->k * (s0 - s1);
  const double discriminant = 1 - alpha * loss;
  fit->T0_reproduces_loss = discriminant >= 0;
  fit->T0 = (1 - std::sqrt(std::max(0.0, discriminant))) / alpha;
}

}  // namespace

double CalcPublishedBias(double a, double c, double o) {
  if (!(0 < c && c < a && o >= 0))
    throw std::invalid_argument("CalcPublishedBias: a = " + std::to_string(a) + " m, c = " + std::to_string(c) +
                                " m, o = " + std::to_string(o) + " m, must be 0 < c < a and o >= 0");
  return Square(std::acos(c / a) / std::acos((c + o) / (a + o)));
}

std::optional<SineFit> FitSine(const Record& record, const Phases& phases, const SineFitOptions& options) {
  if (!phases.usable || phases.rolling_start + 1 >= phases.extrema.size()) return std::nullopt;
  SineFit fit;
  fit.zero_source = phases.rest_size > 0 ? ZeroSource::kRestReading : ZeroSource::kLateCentre;
  fit.zero = phases.rest_size > 0 ? phases.rest_level : phases.centre;
  fit.cutoff = options.cutoff.value_or(kCutoffMargin * RollingAmplitude(phases));
  if (!FindRollingFrequency(record, phases, options.rolling_periods, &fit)) return std::nullopt;

  std::vector<ArcWindow> windows;
  for (std::size_t i = 0; i < phases.rolling_start; ++i) {
    std::optional<SlidingArc> arc = FitPublished(record, phases, fit, i);
    if (!arc) continue;
    windows.push_back(FindWindow(record, phases, fit.cutoff, i));
    FitArcByItself(record, windows.back(), fit.zero, &*arc);
    fit.arcs.push_back(*arc);
  }
  if (fit.arcs.empty()) return std::nullopt;
  fit.omega_sliding = fit.arcs[0].omega_published;
  fit.k = fit.arcs[0].k_published;
  fit.sum_ki = Square(fit.omega_rolling) / record.g - fit.k;
  FitCorrected(record, windows, &fit);
  FindT0(phases, &fit);
  return fit;
}

}  // namespace uiclink
