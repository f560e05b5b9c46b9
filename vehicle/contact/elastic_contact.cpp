#include "vehicle/contact/elastic_contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLowering = 0.55;   ///< share of the approach by which the profiles are lowered (Kik and Piotrowski)
constexpr std::size_t kPoints = 16;  ///< of the quadrature of one interval
constexpr std::size_t kMostPieces = 8;

/// Nodes and weights on (-1, 1) for functions that behave like sqrt(1 - s^2) at both ends: Gauss-Legendre in the angle
/// t of s = sin t.
struct Quadrature {
  std::array<double, kPoints> node{};
  std::array<double, kPoints> weight{};
};

Quadrature MakeQuadrature() {
  constexpr int n = kPoints;
  Quadrature q;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {  // Newton's method on the Legendre polynomial
      double p0 = 1;
      double p1 = x;
      for (int k = 2; k <= n; ++k) p0 = std::exchange(p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k);
      slope = n * (x * p1 - p0) / (x * x - 1);
      const double dx = p1 / slope;
      x -= dx;
      if (std::abs(dx) < 1e-15) break;
    }
    const double angle = 0.5 * kPi * x;
    const auto at = static_cast<std::size_t>(n - 1 - i);
    q.node[at] = std::sin(angle);
    q.weight[at] = 0.5 * kPi * std::cos(angle) * 2 / ((1 - x * x) * slope * slope);
  }
  return q;
}

/// A strip of the contact, across rolling.
struct Strip {
  double length = 0;       ///< across [m], with the quadrature's weight
  double overlap = 0;      ///< vertical [m]
  double deflection = 0;   ///< vertical approach less gap [m]
  double half_length = 0;  ///< along rolling [m]
  double slope = 0;        ///< of the wheel in the track frame [-]
  double cosine = 0;
  double load = 0;  ///< normal line load times length, over pi p'
  double y = 0;     ///< place in the track frame (y outward) [m]
  double z = 0;
  double a_wheel = 0;
  double r = 0;
};

/// A stretch of the wheel in which the profiles overlap, or part of it between two ridges of the gap.
struct Piece {
  double low = 0;  ///< ends, profile coordinates of the wheel [m]
  double high = 0;
  double low_y = 0, low_z = 0, high_y = 0, high_z = 0;  ///< ends in the track frame [m]
  std::array<Strip, kPoints> strips = {};
};

/// int_{-c}^{c} sqrt(c^2 - x^2) / sqrt(x^2 + d^2) dx, d > 0.
double CalcStripInfluence(double c, double d) {
  const double hypotenuse = std::sqrt(c * c + d * d);
  return 2 * c * c * CalcEllipticIntegrals(d / hypotenuse).D / hypotenuse;
}

/// int_0^x ln(t) dt.
double LogIntegral(double x) { return x > 0 ? x * (std::log(x) - 1) : 0; }

double Distance(double y0, double z0, double y1, double z1) {
  const double dy = y1 - y0;
  const double dz = z1 - z0;
  return std::sqrt(dy * dy + dz * dz);
}

class Overlap {
 public:
  Overlap(const WheelsetOnRails& wheelset, const WheelPose& pose, const CandidateList& minima)
      : wheelset_(wheelset), pose_(pose), minima_(minima), a_tape_(wheelset.side(WheelSide::kLeft).a_tape) {}

  /// Lays strips for this vertical approach; returns the vertical load it carries, for E* = 1.
  double Lower(double approach) {
    approach_ = approach;
    FindIntervals();
    for (std::size_t i = 0; i < piece_count_; ++i) LayStrips(pieces_[i]);
    return CalcLoad();
  }

  ElasticContact Summarise(double load) const;

 private:
  double Gap(double y_wheel) const { return At(y_wheel).gap + pose_.z_lift; }
  GapPoint At(double y_wheel) const { return wheelset_.EvalGap(WheelSide::kLeft, y_wheel, pose_.y, pose_.phi); }

  void FindIntervals();
  double March(double minimum, int direction);
  double FindRidge(double rising, double falling, int direction) const;
  double FindEdge(double inside, double outside) const;
  void LayStrips(Piece& piece) const;
  double CalcLoad() const;
  double CalcInfluence(const Piece& piece, const Strip& at) const;
  std::span<const Piece> pieces() const { return {pieces_.data(), piece_count_}; }

  const WheelsetOnRails& wheelset_;
  WheelPose pose_;
  const CandidateList& minima_;
  double a_tape_;
  double approach_ = 0;
  std::size_t piece_count_ = 0;
  int interval_count_ = 0;
  std::array<Piece, kMostPieces> pieces_;
};

/// From each minimum that lies deep enough outward to where the overlap ends. Deepest first; a minimum inside of an
/// interval that is there already belongs to it.
void Overlap::FindIntervals() {
  piece_count_ = 0;
  interval_count_ = 0;
  for (const ContactCandidate& minimum : minima_) {
    if (minimum.gap >= kLowering * approach_) break;
    const auto known = std::span(pieces_).first(piece_count_);
    if (std::ranges::any_of(known,
                            [&](const Piece& p) { return minimum.y_wheel >= p.low && minimum.y_wheel <= p.high; }))
      continue;
    if (piece_count_ == kMostPieces) break;
    ++interval_count_;
    Piece& first = pieces_[piece_count_++];
    first.low = March(minimum.y_wheel, -1);
    first.high = March(minimum.y_wheel, 1);
  }
  if (piece_count_ == 0)
    throw std::domain_error("CalcElasticContact: no minimum of the gap at which the wheel touches");
}

/// Outward from a minimum to the edge of the overlap. On the way each ridge of the gap ends a piece, since the overlap
/// may have a corner there, and another piece begins: all but the one next to the minimum are stored here.
/// @return the end of the piece next to the minimum.
double Overlap::March(double minimum, int direction) {
  constexpr double kStep = 0.4e-3;
  const double depth = kLowering * approach_;
  double first_end = std::numeric_limits<double>::quiet_NaN();
  double begin = minimum;
  bool falling = false;
  const auto close = [&](double end) {
    if (std::isnan(first_end)) {
      first_end = end;
    } else {
      pieces_[piece_count_++] = {.low = std::min(begin, end), .high = std::max(begin, end)};
    }
    begin = end;
  };
  double inside = minimum;
  while (true) {
    const double at = inside + direction * kStep;
    const GapPoint point = At(at);
    const bool falls = direction * point.gap_slope < 0;
    if (falls && !falling) {
      const double ridge = FindRidge(inside, at, direction);
      if (Gap(ridge) > depth) {
        close(FindEdge(inside, ridge));
        return first_end;
      }
      if (piece_count_ + 1 < kMostPieces) close(ridge);
    }
    falling = falls;
    if (!(point.gap + pose_.z_lift <= depth)) {
      close(FindEdge(inside, at));
      return first_end;
    }
    inside = at;
  }
}

/// The greatest gap between two places, by its slope.
double Overlap::FindRidge(double rising, double falling, int direction) const {
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (rising + falling);
    (direction * At(middle).gap_slope > 0 ? rising : falling) = middle;
  }
  return 0.5 * (rising + falling);
}

/// Where the gap grows beyond the lowering, or where a profile ends (gap NaN): Newton's method within the bracket.
double Overlap::FindEdge(double inside, double outside) const {
  const double depth = kLowering * approach_;
  double at = outside;
  for (int i = 0; i < 60 && std::abs(outside - inside) > 1e-13; ++i) {
    const GapPoint point = At(at);
    const double excess = point.gap + pose_.z_lift - depth;
    (excess <= 0 ? inside : outside) = at;
    const double next = at - excess / point.gap_slope;
    const bool within = (next - inside) * (next - outside) < 0;
    if (within && std::abs(next - at) < 1e-13) return next;
    at = within ? next : 0.5 * (inside + outside);
  }
  return inside;
}

void Overlap::LayStrips(Piece& piece) const {
  static const Quadrature quadrature = MakeQuadrature();
  const double middle = 0.5 * (piece.low + piece.high);
  const double half = 0.5 * (piece.high - piece.low);
  const GapPoint low = At(piece.low);
  const GapPoint high = At(piece.high);
  piece.low_y = low.a_rail;
  piece.low_z = low.rail.z;
  piece.high_y = high.a_rail;
  piece.high_z = high.rail.z;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double y_wheel = middle + half * quadrature.node[i];
    const GapPoint point = At(y_wheel);
    const double gap = point.gap + pose_.z_lift;
    Strip& strip = piece.strips[i];
    const double angle = std::atan(point.wheel.slope) + pose_.phi;
    strip.length = half * quadrature.weight[i] * std::sqrt(1 + point.wheel.slope * point.wheel.slope);
    strip.overlap = std::max(kLowering * approach_ - gap, 0.0);
    strip.deflection = approach_ - gap;
    strip.slope = std::tan(angle);
    strip.cosine = std::cos(angle);
    strip.a_wheel = a_tape_ + y_wheel;
    strip.r = wheelset_.side(WheelSide::kLeft).r0 - point.wheel.z;
    strip.half_length = std::sqrt(2 * strip.r * strip.overlap);
    strip.load = strip.r * strip.overlap * strip.length;
    strip.y = point.a_rail;
    strip.z = point.rail.z;
  }
}

/// int over a piece of the influence of its strips on the middle of the strip `at`, of this piece or another one. The
/// influence of a strip near by is 2 c (ln(4 c/d) - 1); the part -2 c ln d, with the c of the strip `at`, is integrated
/// exactly, and the remainder is smooth enough for the quadrature.
double Overlap::CalcInfluence(const Piece& piece, const Strip& at) const {
  const double c = at.half_length;
  if (c == 0) return 0;  // carries nothing
  const bool own = &at >= piece.strips.data() && &at < piece.strips.data() + kPoints;
  double sum = 0;
  for (const Strip& s : piece.strips) {
    if (&s == &at) {
      sum += s.length * 2 * c * (std::log(4 * c) - 1);
      continue;
    }
    const double d = Distance(at.y, at.z, s.y, s.z);
    const double influence = s.half_length > 0 ? CalcStripInfluence(s.half_length, d) : 0;
    sum += s.length * (influence + 2 * c * std::log(d));
  }
  const double to_low = LogIntegral(Distance(at.y, at.z, piece.low_y, piece.low_z));
  const double to_high = LogIntegral(Distance(at.y, at.z, piece.high_y, piece.high_z));
  const double logarithms = own ? to_low + to_high : at.y > piece.high_y ? to_low - to_high : to_high - to_low;
  return sum - 2 * c * logarithms;
}

/// p' = pi E* sum(load deflection) / sum(load influence);  vertical load = pi p' sum(load cos).
double Overlap::CalcLoad() const {
  double work = 0;
  double influence = 0;
  double vertical = 0;
  for (const Piece& piece : pieces()) {
    for (const Strip& strip : piece.strips) {
      work += strip.load * strip.deflection * strip.cosine;
      vertical += strip.load * strip.cosine;
      for (const Piece& other : pieces()) influence += strip.load * CalcInfluence(other, strip);
    }
  }
  return kPi * kPi * work / influence * vertical;
}

ElasticContact Overlap::Summarise(double load) const {
  ElasticContact contact{.patches = interval_count_};
  double sum = 0;
  double slope = 0;
  double area = 0;
  double width = 0;
  for (const Piece& piece : pieces()) {
    for (const Strip& s : piece.strips) {
      const double weight = s.load * s.cosine;
      sum += weight;
      slope += weight * s.slope;
      contact.a_wheel += weight * s.a_wheel;
      contact.a_rail += weight * s.y;
      contact.z_rail += weight * s.z;
      contact.r += weight * s.r;
      area += 2 * s.half_length * s.length;
      width += s.length;
    }
  }
  for (double* mean : {&slope, &contact.a_wheel, &contact.a_rail, &contact.z_rail, &contact.r}) *mean /= sum;
  const double track_angle = std::atan(slope);
  const double length = 2 * std::sqrt(2 * contact.r * kLowering * approach_);
  // The quadratic gap with this overlap: area 2 pi delta_0 / sqrt(kappa_x kappa_y), length to width as the roots of the
  // curvatures. Hertz at this approach gives it the ellipse with  a b = (area/pi) (B/K) sqrt(kappa_p/kappa_q) / (0.55
  // g).
  const double slimness = width / length;
  const double ratio = CalcHertzAxisRatio(slimness * slimness);
  const double g = std::min(ratio, 1 / ratio);
  const EllipticIntegrals f = CalcEllipticIntegrals(g);
  const double product = area / kPi * f.B / f.K * std::min(slimness, 1 / slimness) / (kLowering * g);
  contact.delta = track_angle - pose_.phi;
  contact.a = std::sqrt(product * ratio);
  contact.b = std::sqrt(product / ratio);
  contact.approach = approach_ * std::cos(track_angle);
  contact.normal_force = load / std::cos(track_angle);
  return contact;
}

}  // namespace

ElasticContact CalcElasticContact(const WheelsetOnRails& wheelset, const WheelPose& pose, const CandidateList& minima,
                                  double load, const ElasticMaterial& material, double approach_guess) {
  if (!(load > 0) || !(approach_guess > 0))
    throw std::invalid_argument(
        fmt::format("CalcElasticContact: load = {} N, approach_guess = {} m, must be > 0", load, approach_guess));
  // ln(load) over ln(approach) is nearly a straight line of slope 1.5: secants from there. Where a profile has a step
  // in height (S1002 has one of 0.1 um) the load has tiny steps too, and the second tolerance is what can be met.
  constexpr double kTolerance = 1e-11;
  constexpr double kToleranceAtStep = 1e-7;
  constexpr double kStepWidth = 1e-10;  // of the logarithm
  constexpr int kSecants = 19;          // that a smooth profile needs at most
  Overlap overlap(wheelset, pose, minima);
  double x = std::log(approach_guess);
  double slope = 1.5;
  double x_before = x;
  double excess_before = 0;
  double excess = 0;
  double below = -std::numeric_limits<double>::infinity(), above = -below;  // carries less, carries more
  for (int i = 0; i < 60; ++i) {
    excess = std::log(material.contact_modulus() * overlap.Lower(std::exp(x)) / load);
    if (!std::isfinite(excess)) break;
    if (std::abs(excess) < kTolerance) return overlap.Summarise(load);
    (excess < 0 ? below : above) = x;
    if (i > 0 && x != x_before) slope = std::clamp((excess - excess_before) / (x - x_before), 1.0, 4.0);
    excess_before = excess;
    x_before = x;
    x -= excess / slope;
    if (i < kSecants) continue;
    // The load steps to and fro: a profile of points is no smooth curve. Halving ends at the step.
    if (std::abs(excess) < kToleranceAtStep || above - below < kStepWidth) return overlap.Summarise(load);
    if (std::isfinite(above - below)) x = 0.5 * (below + above);
  }
  throw std::domain_error(
      fmt::format("elastic contact: at y = {:.6g} mm no approach carries {:g} N; points of a rough profile want "
                  "smoothing (profile_smoothing_mm)",
                  1e3 * pose.y, load));
}

}  // namespace uiclink
