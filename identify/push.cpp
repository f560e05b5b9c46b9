#include "identify/push.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "identify/local_fit.h"
#include "identify/sliding_arc.h"
#include "identify/turns.h"

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

/// Losses below these shares of the next swing's, or of the strongest later cycle's, are suspect; below the second ones
/// very much so. With the zero of the arcs, in 7859 records of the rig with no stop, sensor limit or rig mode, driven
/// swings lose at most 0.33 of the next one (99.8 %), free ones at least 0.76 (99 %).
constexpr double kSuspectSwing = 0.65, kVerySuspectSwing = 0.35;
constexpr double kSuspectCycle = 0.75, kVerySuspectCycle = 0.6;
/// Two losses may differ by this share of the distance of two extrema: an uneven sensor or spring (3 /m at 25 mm: 7 %
/// from side to side) bends the zero by more than a line through later swings tells.
constexpr double kUneven = 0.05;
/// Least force of a hand, in units of the friction, and by how much it must improve the fit of the arc.
constexpr double kLeastPush = 0.6, kLeastGain = 1.1;
/// The shape of a swing speaks against a push only where one would show: rms of its residuals in units of T0/k.
constexpr double kResolved = 0.1;
/// Half width of the turn that is looked at for a stop [rad], and how much more than friction and spring slow down
/// there.
constexpr double kSharpWidth = 0.35, kSharp = 1.15;
/// Fewest samples that tell an arc with a step of force from one without.
constexpr std::ptrdiff_t kFewestOfShape = 6;

double Square(double x) { return x * x; }

/// Distance of the first two extrema that roll [m]; 0 where it never rolls.
double RollingSpan(const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  const std::size_t i = phases.rolling_start;
  return i + 1 < e.size() ? std::abs(e[i + 1].y - e[i].y) : 0;
}

/// Leaves out the samples that the sensor cut.
void TrimCut(const Record& record, const Noise& noise, const Extremum& e, ArcWindow* arc) {
  if (!e.cut) return;
  const double within = CutBand(noise);
  while (arc->last > arc->first && std::abs(record.y[arc->last - 1] - e.y) <= within) --arc->last;
}

/// Samples of the arc before extremum i > 0 in which every joint slides; where the motion never rolls, those behind the
/// given share of the swing.
ArcWindow FindWindow(const Record& record, const Noise& noise, const Phases& phases, std::size_t i, double share) {
  const Extremum &from = phases.extrema[i - 1], &e = phases.extrema[i];
  const double travel = std::max(kTravelMargin * RollingSpan(phases), share * std::abs(e.y - from.y));
  ArcWindow arc = FindSlidingArc(record.t, record.y, from.index, from.y, e.index, e.t, travel);
  TrimCut(record, noise, e, &arc);
  return arc;
}

/// The free arc on the way to an extremum:  y = centre + (y_e - centre) cos omega (t - t_e).
struct FreeArc {
  double omega = 0;
  double centre = 0;
  double rms = 0;              ///< of the arcs behind it about their sines [m]
  bool fitted = false;         ///< from sliding arcs; otherwise from the half swing behind it and the late centre
  std::optional<double> zero;  ///< reading midway between the centres of both sides [m], where arcs of both are there
};

/// The free arc to extremum j, from up to four arcs behind it.
FreeArc FindFreeArc(const Record& record, const Noise& noise, const Phases& phases, std::size_t j) {
  const std::vector<Extremum>& e = phases.extrema;
  const double half_period = (e[j + 2].t - e[j].t) / 2, omega = std::numbers::pi / half_period;
  std::array<ArcWindow, 4> arcs;
  std::size_t size = 0;
  for (std::size_t i = j + 1; i <= std::min({j + arcs.size(), phases.rolling_start, e.size() - 1}); ++i) {
    arcs[size] = FindWindow(record, noise, phases, i, 0.5);
    if (arcs[size].last <= arcs[size].first) continue;
    if (record.t[arcs[size].last - 1] - record.t[arcs[size].first] > kMinArc * half_period) ++size;
  }
  const std::optional<ArcFit> fit =
      size > 0 ? FitSlidingArcs(record.t, record.y, {arcs.data(), size}, omega) : std::nullopt;
  if (!fit) return {.omega = omega, .centre = phases.centre, .zero = {}};
  const double side = e[j].y > e[j + 1].y ? 1 : -1;
  if (fit->both_sides) return {fit->omega, fit->zero - side * fit->shift, fit->rms, true, fit->zero};
  return {fit->omega, arcs[0].side == side ? fit->zero : 2 * phases.centre - fit->zero, fit->rms, true, {}};
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

/// An arc  y = centre + a cos + b sin  with and without a force before some time t_r, which shifts the centre by
/// `force` towards the extremum ahead.
struct Shape {
  bool known = false;
  double force = 0;                ///< P/k [m], > 0: along the velocity
  double t_r = 0;                  ///< [s]
  double rms = 0, rms_forced = 0;  ///< of the residuals without and with the force [m]

  bool ShowsForce(double least) const { return known && force > least && rms > kLeastGain * rms_forced; }
};

/// Fits the arc; `free_centre`: the centre is that of the arc itself, so that only the step of the force counts.
Shape FitShape(const Record& record, const ArcWindow& arc, const FreeArc& free, bool free_centre) {
  const auto n = static_cast<Eigen::Index>(arc.last - arc.first);
  Shape shape;
  if (n < kFewestOfShape) return shape;
  Eigen::MatrixX3d basis(n, 3);
  Eigen::VectorXd y(n), phase(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t sample = arc.first + static_cast<std::size_t>(i);
    phase[i] = free.omega * (record.t[sample] - arc.t);
    basis.row(i) << std::cos(phase[i]), std::sin(phase[i]), 1;
    y[i] = record.y[sample] - free.centre;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(basis.leftCols(free_centre ? 3 : 2));
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, free_centre ? 3 : 2);
  const Eigen::VectorXd residual = y - q * (q.transpose() * y);
  double best_gain = 0;
  const Eigen::Index step = 1 + n / 40;  // a fortieth of the arc is 10 ms
  for (Eigen::Index c = 3; c + 1 < n; c += step) {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(n);
    u.head(c) = 1 - (phase[c] - phase.head(c).array()).cos();
    u -= q * (q.transpose() * u);
    const double uu = u.squaredNorm(), ur = u.dot(residual);
    if (!(ur * ur > best_gain * uu)) continue;
    best_gain = ur * ur / uu;
    shape.force = arc.side * ur / uu;
    shape.t_r = record.t[arc.first + static_cast<std::size_t>(c)];
  }
  const double rss = residual.squaredNorm();
  shape.known = true;
  shape.rms = std::sqrt(rss / static_cast<double>(n));
  shape.rms_forced = std::sqrt(std::max(0.0, rss - best_gain) / static_cast<double>(n));
  return shape;
}

enum class Suspicion { kNone, kSome, kStrong };

/// The zero as a sensor or an uneven spring moves it:  level + slope t + bend A^2 at an extremum of amplitude A.
struct Zero {
  double level = 0;  ///< [m]
  double slope = 0;  ///< [m/s]
  double bend = 0;   ///< [1/m]
};

/// Size of extremum i, free of the zero [m].
double Size(const std::vector<Extremum>& e, std::size_t i) {
  if (i == 0) return std::abs(e[1].y - e[0].y) / 2;
  return (std::abs(e[i].y - e[i - 1].y) + std::abs(e[i + 1].y - e[i].y)) / 4;
}

/// Middle line of what follows extrema[1]: least squares over the centres of each three neighbours. Where few of them
/// slide, those would pass for a bend; then the rolling ones give level and slope.
std::optional<Zero> FitMiddle(const Phases& phases) {
  constexpr std::size_t kFewest = 6;  // triples: three periods tell a drift from the beat of a tone
  const std::vector<Extremum>& e = phases.extrema;
  const bool bends = phases.rolling_start >= kFewest;
  const std::size_t first = bends ? 2 : phases.rolling_start + 1;
  if (e.size() < first + kFewest + 1) return std::nullopt;
  const double unit = Size(e, 1), length = e.back().t - e[0].t;
  Eigen::Matrix3d normal = Eigen::Vector3d(0, 0, bends ? 0 : 1).asDiagonal();
  Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
  for (std::size_t i = first; i + 1 < e.size(); ++i) {
    const double size = bends ? Size(e, i) / unit : 0;
    const Eigen::Vector3d row(1, (e[i].t - e[0].t) / length, size * size);
    normal += row * row.transpose();
    rhs += row * (e[i - 1].y + 2 * e[i].y + e[i + 1].y) / 4;
  }
  const Eigen::Vector3d x = normal.ldlt().solve(rhs);
  return Zero{x[0] - x[1] / length * e[0].t, x[1] / length, x[2] / (unit * unit)};
}

/// What the losses of the first two half swings say, with amplitudes from `zero`.
Suspicion SuspectSwing(const std::vector<Extremum>& e, const Zero& zero) {
  const auto amplitude = [&](std::size_t i) {
    return std::abs(e[i].y - zero.level - zero.slope * e[i].t - zero.bend * Square(Size(e, i)));
  };
  const double first = amplitude(0) - amplitude(1), second = amplitude(1) - amplitude(2);
  if (second - first < kUneven * std::abs(e[1].y - e[0].y) || first > kSuspectSwing * second) return Suspicion::kNone;
  return first < kVerySuspectSwing * second ? Suspicion::kStrong : Suspicion::kSome;
}

/// What the loss of the first cycle says.
Suspicion SuspectCycle(const std::vector<Extremum>& e, double later_loss) {
  const double loss = std::abs(e[1].y - e[0].y) - std::abs(e[2].y - e[1].y);
  if (loss > kSuspectCycle * later_loss) return Suspicion::kNone;
  return loss < kVerySuspectCycle * later_loss ? Suspicion::kStrong : Suspicion::kSome;
}

/// Whether the motion turns round in extrema[0] faster than free arcs and friction make it: it touched a stop.
bool IsSharp(const Record& record, const Phases& phases, const FreeArc& free) {
  const Extremum& e = phases.extrema[0];
  const double other_centre = 2 * free.zero.value_or(phases.centre) - free.centre;
  const std::optional<LocalFit> fit = FitLocally(record.t, record.y, e.index, kSharpWidth / free.omega, free.omega);
  return fit && std::abs(2 * fit->c2) > kSharp * free.omega * free.omega * std::abs(e.y - other_centre);
}

/// Frequency and centre of the arc to a cut extremum are known, its height is not.
double FindPushEndBelowCut(const Record& record, const Noise& noise, const Phases& phases, std::size_t limit,
                           const FreeArc& free) {
  const Extremum& e = phases.extrema[0];
  ArcWindow arc{.first = limit, .last = e.index + 1, .t = e.t, .side = e.y > phases.extrema[1].y ? 1.0 : -1.0};
  TrimCut(record, noise, e, &arc);
  const Shape shape = FitShape(record, arc, free, true);
  return shape.ShowsForce(kDeparted * std::abs(e.y - free.centre)) ? shape.t_r : record.t[limit];
}

}  // namespace

double FindPushEnd(const Record& record, const Noise& noise, const Phases& phases, std::size_t limit) {
  const Extremum& e = phases.extrema[0];
  limit = std::min(limit, e.index);
  const FreeArc arc = FindFreeArc(record, noise, phases, 0);
  const bool in_motion = limit == 0;
  if (e.cut) return in_motion ? record.t[limit] : FindPushEndBelowCut(record, noise, phases, limit, arc);
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

bool IsFirstSwingDriven(const Record& record, const Noise& noise, const Phases& phases, double later_loss) {
  const std::vector<Extremum>& e = phases.extrema;
  if (e.size() < 4) return false;
  const bool cut = e[0].cut || e[1].cut || e[2].cut;
  const Suspicion cycle = SuspectCycle(e, later_loss);
  Suspicion swing = SuspectSwing(e, {phases.centre});
  if (const std::optional<Zero> middle = FitMiddle(phases)) swing = std::min(swing, SuspectSwing(e, *middle));
  if (!cut && cycle == Suspicion::kNone && swing == Suspicion::kNone) return false;
  const FreeArc free = FindFreeArc(record, noise, phases, 1);
  if (free.zero) swing = std::min(swing, SuspectSwing(e, {*free.zero}));
  const Suspicion suspicion = std::max(cycle, swing);
  if (!cut && suspicion == Suspicion::kNone) return false;

  const ArcWindow arc = FindWindow(record, noise, phases, 1, 0.25);
  const double friction = later_loss / 4, least = kLeastPush * friction;  // both as shifts of the centre, T0/k
  const Shape fixed = FitShape(record, arc, free, false), own = FitShape(record, arc, free, true);
  if (cut) return (free.fitted ? fixed : own).ShowsForce(least);
  if (fixed.ShowsForce(least) || own.ShowsForce(least)) return true;
  const bool follows_free_arc = fixed.known && free.fitted && fixed.rms < kResolved * friction;
  return suspicion == Suspicion::kStrong && !(follows_free_arc && IsSharp(record, phases, free));
}

}  // namespace uiclink
