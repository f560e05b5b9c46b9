#include "identify/push.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "identify/sliding_arc.h"

namespace uiclink {
namespace {

/// Shortest arc that the frequency of sliding is taken from, as a share of a half swing.
constexpr double kMinArc = 0.15;
/// Margin on the travel behind which every joint slides.
constexpr double kTravelMargin = 1.2;
/// Departure from the free arc, as a share of its amplitude, beyond what the arc is uncertain by.
constexpr double kDeparted = 0.012;
/// The same where a push is not known to be there: more than the effects that the plain model lacks bend an arc.
constexpr double kSurelyPushed = 0.03;

/// A half swing that loses less than this share of what the next loses is still driven; free ones lose 1.1 times as
/// much and more, friction that falls with speed at least 0.8.
constexpr double kDriven = 0.75;

double Square(double x) { return x * x; }

/// Distance of the first two extrema that roll [m]; 0 where it never rolls.
double RollingSpan(const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  const std::size_t i = phases.rolling_start;
  return i + 1 < e.size() ? std::abs(e[i + 1].y - e[i].y) : 0;
}

/// Samples of the arc before extremum i > 0 in which every joint slides; where the motion never rolls, those of the
/// second half of the swing.
ArcWindow FindWindow(const Record& record, const Phases& phases, std::size_t i) {
  const Extremum &from = phases.extrema[i - 1], &e = phases.extrema[i];
  const double travel = std::max(kTravelMargin * RollingSpan(phases), 0.5 * std::abs(e.y - from.y));
  return FindSlidingArc(record.t, record.y, from.index, from.y, e.index, e.t, travel);
}

/// The free arc on the way to an extremum:  y = centre + (y_e - centre) cos omega (t - t_e).
struct FreeArc {
  double omega = 0;
  double centre = 0;
  double rms = 0;              ///< of the arcs behind it about their sines [m]
  std::optional<double> zero;  ///< reading midway between the centres of both sides [m], where arcs of both are there
};

/// The free arc to extremum j, from up to four arcs behind it.
FreeArc FindFreeArc(const Record& record, const Phases& phases, std::size_t j) {
  const std::vector<Extremum>& e = phases.extrema;
  const double half_period = (e[j + 2].t - e[j].t) / 2, omega = std::numbers::pi / half_period;
  std::array<ArcWindow, 4> arcs;
  std::size_t size = 0;
  for (std::size_t i = j + 1; i <= std::min({j + arcs.size(), phases.rolling_start, e.size() - 1}); ++i) {
    arcs[size] = FindWindow(record, phases, i);
    if (record.t[arcs[size].last - 1] - record.t[arcs[size].first] > kMinArc * half_period) ++size;
  }
  const std::optional<ArcFit> fit =
      size > 0 ? FitSlidingArcs(record.t, record.y, {arcs.data(), size}, omega) : std::nullopt;
  if (!fit) return {omega, phases.centre, 0, {}};
  const double side = e[j].y > e[j + 1].y ? 1 : -1;
  if (fit->both_sides) return {fit->omega, fit->zero - side * fit->shift, fit->rms, fit->zero};
  return {fit->omega, arcs[0].side == side ? fit->zero : 2 * phases.centre - fit->zero, fit->rms, {}};
}

/// Readings from sample `first` to extremum e, less the free arc [m].
std::vector<double> CalcDepartures(const Record& record, const Extremum& e, const FreeArc& arc, std::size_t first) {
  std::vector<double> r(e.index - first + 1);
  for (std::size_t i = first; i <= e.index; ++i)
    r[i - first] = record.y[i] - arc.centre - (e.y - arc.centre) * std::cos(arc.omega * (record.t[i] - e.t));
  return r;
}

/// How many of the departures, from the first on, come before the last that exceeds `beyond`, it included.
std::size_t CountDeparted(std::span<const double> r, double beyond) {
  std::size_t departed = r.size();
  while (departed > 0 && std::abs(r[departed - 1]) <= beyond) --departed;
  return departed;
}

/// The time t_r that  r = p (1 - cos w (t - t_e)) + q (1 - cos w (t_r - t)) before t_r, the first term alone after it,
/// fits best from sample `first` to the extremum at t_e.  The first term is what a slightly wrong centre leaves, the
/// second what a force does that stops at t_r.
double FindChange(const Record& record, std::span<const double> r, std::size_t first, double w, double t_extremum) {
  const std::size_t n = r.size();
  const std::size_t step = 1 + n / 64;  // 2 ms are enough for a fast converter
  double best = record.t[first], best_gain = 0;
  double pp = 0, pr = 0;
  std::vector<double> p(n);
  for (std::size_t i = 0; i < n; ++i) {
    p[i] = 1 - std::cos(w * (record.t[first + i] - t_extremum));
    pp += p[i] * p[i], pr += p[i] * r[i];
  }
  for (std::size_t c = 2; c < n; c += step) {
    double uu = 0, ur = 0, pu = 0;
    for (std::size_t i = 0; i < c; ++i) {
      const double tau2 = Square(w * (record.t[first + c] - record.t[first + i]));
      const double u = tau2 * (1 - tau2 / 12);
      uu += u * u, ur += u * r[i], pu += p[i] * u;
    }
    const double rest = ur - pu / pp * pr, gain = rest * rest / (uu - pu * pu / pp);
    if (gain > best_gain) best_gain = gain, best = record.t[first + c];
  }
  return best;
}

/// Start of the sliding arc before extrema[0] if nothing pushed at all: a free swing comes from the amplitude that the
/// last losses extrapolate to, and slides behind twice the amplitude at which it rolls.
std::size_t FindFreeStart(const Record& record, const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  const double side = e[0].y > e[1].y ? 1 : -1;
  const double span = 2 * std::abs(e[1].y - e[0].y) - std::abs(e[2].y - e[1].y);
  const double from = e[0].y - side * (span - kTravelMargin * RollingSpan(phases));
  std::size_t i = e[0].index;
  while (i > 0 && side * (record.y[i - 1] - from) > 0) --i;
  return i;
}

}  // namespace

double FindPushEnd(const Record& record, const Noise& noise, const Phases& phases, std::size_t limit) {
  const Extremum& e = phases.extrema[0];
  limit = std::min(limit, e.index);
  const FreeArc arc = FindFreeArc(record, phases, 0);
  const bool in_motion = limit == 0;
  // Where later arcs are no sines either, a departure by itself does not speak of a push.
  if (in_motion && arc.rms > 3 * noise.sigma) return record.t[limit];
  const std::size_t start = in_motion ? FindFreeStart(record, phases) : limit;
  const std::vector<double> r = CalcDepartures(record, e, arc, start);
  const double beyond = 6 * noise.sigma + (in_motion ? kSurelyPushed : kDeparted) * std::abs(e.y - arc.centre);
  const std::size_t departed = CountDeparted(r, beyond);
  if (departed == 0) return record.t[limit];
  // A quarter radian more of the push is enough to see it set in.
  std::size_t first = departed - 1;
  const double width = 0.25 / arc.omega;
  while (first > 0 && record.t[start + departed - 1] - record.t[start + first - 1] < width) --first;
  return FindChange(record, std::span<const double>(r).subspan(first), start + first, arc.omega, e.t);
}

bool IsFirstSwingPushed(const Record& record, const Noise& noise, const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  if (phases.rolling_start < 3) return false;
  const FreeArc arc = FindFreeArc(record, phases, 1);
  if (!arc.zero || arc.rms > 3 * noise.sigma) return false;
  const auto amplitude = [&](std::size_t i) { return std::abs(e[i].y - *arc.zero); };
  const double first = amplitude(0) - amplitude(1), second = amplitude(1) - amplitude(2);
  return first < kDriven * second - 6 * noise.sigma;
}

}  // namespace uiclink
