#include "vehicle/contact/calc_contact_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "vehicle/contact/elastic_contact.h"
#include "vehicle/contact/kalker_coefficients.h"

namespace uiclink {
namespace {

/// Of a contact ellipse, along and across rolling [m].
struct SemiAxes {
  double a = 0;
  double b = 0;
};

/// One wheel at one displacement, told as the left one.
struct WheelPlace {
  WheelPose pose;
  const CandidateList* minima = nullptr;
};

/// The left wheel at y and at -y: the latter is the right one at y, mirrored.
WheelPlace LeftAt(const KinematicContact& contact) {
  return {.pose = {.y = contact.y, .phi = contact.phi_roll, .z_lift = contact.z_lift}, .minima = &contact.left};
}
WheelPlace LeftAtMirrored(const KinematicContact& contact) {
  return {.pose = {.y = -contact.y, .phi = -contact.phi_roll, .z_lift = contact.z_lift}, .minima = &contact.right};
}

/// The curvature of the gap between a touching point and two ends at distance b along the tangent.
class SecantCurvature {
 public:
  SecantCurvature(const WheelsetOnRails& wheelset, const ContactCandidate& point, const WheelPose& pose)
      : wheelset_(wheelset), point_(point), pose_(pose) {}

  double operator()(double b) const {
    constexpr double kBesideTheProfile = 1e6;  // [1/m]; keeps b from going there
    const double across = b * std::cos(point_.delta);
    const double gap = Gap(point_.y_wheel - across) + Gap(point_.y_wheel + across);
    return std::isnan(gap) ? kBesideTheProfile : gap * std::cos(point_.delta + pose_.phi) / (b * b);
  }

 private:
  double Gap(double y_wheel) const {
    return wheelset_.EvalGap(WheelSide::kLeft, y_wheel, pose_.y, pose_.phi).gap + pose_.z_lift;
  }
  const WheelsetOnRails& wheelset_;
  const ContactCandidate& point_;
  WheelPose pose_;
};

class TableBuilder {
 public:
  TableBuilder(const TrackGeometry& geometry, ContactNotes& notes)
      : geometry_(geometry), notes_(notes), wheelset_(geometry), material_{geometry.young, geometry.poisson} {}

  std::vector<ContactRow> Build() {
    const int n = geometry_.rows;
    std::vector<ContactRow> rows(static_cast<std::size_t>(n));
    double phi = 0;
    for (int i = n / 2; i < n; ++i) {  // from the centre outward; both wheels of a pose fill two rows
      const double y = geometry_.y_max * (2 * i - (n - 1)) / (n - 1);
      const KinematicContact contact = FindKinematicContact(wheelset_, y, {}, phi);
      phi = contact.phi_roll;
      rows[static_cast<std::size_t>(i)] = CalcRow(LeftAt(contact), guess_);
      if (y > 0) rows[static_cast<std::size_t>(n - 1 - i)] = CalcRow(LeftAtMirrored(contact), guess_mirrored_);
    }
    if (geometry_.contact == ContactModel::kRigid) AddJumps(rows);
    std::ranges::sort(notes_.two_point, {}, &TwoPointContact::y);
    return rows;
  }

 private:
  ContactRow CalcRow(const WheelPlace& place, double& approach_guess) {
    const ContactRow row = geometry_.contact == ContactModel::kRigid ? CalcRigidRow((*place.minima)[0], place.pose)
                                                                     : CalcElasticRow(place, approach_guess);
    NoteSecondPoint(place, row);
    return row;
  }

  ContactRow CalcRigidRow(const ContactCandidate& point, const WheelPose& pose) const {
    const double n0 = geometry_.wheel_load / std::cos(point.delta + pose.phi);
    const HertzContact ellipse = CalcRigidEllipse(wheelset_, point, pose.y, pose.phi, pose.z_lift, n0, material_);
    return MakeRow(pose, point, {.a = ellipse.a, .b = ellipse.b}, ellipse.approach, n0);
  }

  ContactRow CalcElasticRow(const WheelPlace& place, double& approach_guess) const {
    const WheelPose& pose = place.pose;
    const ElasticContact c =
        CalcElasticContact(wheelset_, pose, *place.minima, geometry_.wheel_load, material_, approach_guess);
    approach_guess = c.approach / std::cos(c.delta + pose.phi);
    return MakeRow(pose, c, {.a = c.a, .b = c.b}, c.approach, c.normal_force);
  }

  /// @param point  with a_wheel, a_rail, r, z_rail, delta: a ContactCandidate or an ElasticContact.
  template <typename Point>
  ContactRow MakeRow(const WheelPose& pose, const Point& point, const SemiAxes& ellipse, double approach,
                     double n0) const {
    const KalkerCoefficients c = CalcKalkerCoefficients(ellipse.a / ellipse.b, geometry_.poisson);
    return {.y = pose.y,
            .a_wheel = point.a_wheel,
            .a_rail = point.a_rail,
            .r = point.r,
            .z_rail = point.z_rail,
            .delta = point.delta,
            .c11 = c.c11,
            .c22 = c.c22,
            .c23 = c.c23,
            .a_e = ellipse.a,
            .b_e = ellipse.b,
            .q0 = approach,
            .n0 = n0,
            .z_lift = pose.z_lift,
            .phi_roll = pose.phi};
  }

  /// The lowest minimum beside the ellipse of the first one, if the approach closes it.
  void NoteSecondPoint(const WheelPlace& place, const ContactRow& row) {
    const ContactCandidate& first = (*place.minima)[0];
    for (const ContactCandidate& other : *place.minima) {
      if (std::abs(other.y_wheel - first.y_wheel) <= row.b_e * std::cos(first.delta)) continue;
      const double gap = other.gap * std::cos(other.delta + place.pose.phi);
      if (gap < row.q0) {
        notes_.two_point.push_back({.y = row.y, .gap = gap, .approach = row.q0, .touching = first, .second = other});
      }
      return;  // the others are wider open
    }
  }

  /// Jumps of the left wheel; those at y < 0 are the right one's at y > 0.
  void AddJumps(std::vector<ContactRow>& rows) {
    for (Jump& jump : FindJumps(wheelset_, 0, geometry_.y_max)) {
      if (jump.side == WheelSide::kRight) {
        jump.side = WheelSide::kLeft;
        jump.y = -jump.y;
        jump.phi_roll = -jump.phi_roll;
        std::swap(jump.before, jump.after);
      }
      notes_.jumps.push_back(jump);
    }
    std::ranges::sort(notes_.jumps, {}, &Jump::y);
    for (const Jump& jump : notes_.jumps) {
      const WheelPose pose{.y = jump.y, .phi = jump.phi_roll, .z_lift = jump.z_lift};
      // A row of the regular ones that stands at the jump itself is one of the two.
      std::erase_if(rows, [&](const ContactRow& row) { return std::abs(row.y - jump.y) < 1e-12; });
      const auto at = std::ranges::lower_bound(rows, jump.y, {}, &ContactRow::y);
      const ContactRow both[] = {CalcRigidRow(jump.before, pose), CalcRigidRow(jump.after, pose)};
      rows.insert(at, std::begin(both), std::end(both));
    }
  }

  const TrackGeometry& geometry_;
  ContactNotes& notes_;
  WheelsetOnRails wheelset_;
  ElasticMaterial material_;
  double guess_ = 1e-5;  ///< vertical approach of the row before, elastic contact
  double guess_mirrored_ = 1e-5;
};

/// r of a table at y, on either side of a jump there; linear between rows.
double CalcRadius(const std::vector<ContactRow>& rows, double y, bool after_jump) {
  const auto at = after_jump ? std::ranges::upper_bound(rows, y, {}, &ContactRow::y)
                             : std::ranges::lower_bound(rows, y, {}, &ContactRow::y);
  if (at == rows.begin()) return rows.front().r;
  if (at == rows.end()) return rows.back().r;
  const ContactRow& low = *(at - 1);
  return low.r + (at->r - low.r) * (y - low.y) / (at->y - low.y);
}

}  // namespace

HertzContact CalcRigidEllipse(const WheelsetOnRails& wheelset, const ContactCandidate& point, double y, double phi,
                              double z_lift, double normal_force, const ElasticMaterial& material) {
  constexpr double kNarrowest = 1e-5;  // [m]
  constexpr double kFlattest = 1e-4;   // [1/m]; less than any gap of kWidestEllipse above rounding
  const SecantCurvature curvature(wheelset, point, {.y = y, .phi = phi, .z_lift = z_lift});
  const double kappa_x = std::cos(point.delta) / point.r;
  const auto at = [&](double b) {
    return CalcHertzContact(kappa_x, std::max(curvature(b), kFlattest), normal_force, material);
  };
  // b of Hertz for the curvature over b, against b itself: from the local curvature to where the two change places,
  // then by regula falsi (Illinois) in the logarithm.
  const double local = point.curvature_wheel + point.curvature_rail;
  double b = CalcHertzContact(kappa_x, std::clamp(local, 0.5, 1e4), normal_force, material).b;
  HertzContact ellipse = at(b);
  double excess = std::log(ellipse.b / b);
  const double factor = excess > 0 ? 1.2 : 1 / 1.2;
  double other = b;
  double other_excess = excess;
  while (other_excess * excess > 0 && other < kWidestEllipse && other > kNarrowest) {
    b = std::exchange(other, other * factor);
    excess = std::exchange(other_excess, std::log(at(other).b / other));
  }
  if (other_excess * excess > 0) return at(std::clamp(other, kNarrowest, kWidestEllipse));
  double x0 = std::log(b);
  double x1 = std::log(other);
  for (int i = 0; i < 60 && std::abs(x1 - x0) > 1e-12; ++i) {
    const double x = (x0 * other_excess - x1 * excess) / (other_excess - excess);
    ellipse = at(std::exp(x));
    const double f = std::log(ellipse.b) - x;
    if (std::abs(f) < 1e-12) break;
    if (f * other_excess < 0) {
      x0 = x1;
      excess = other_excess;
    } else {
      excess *= 0.5;
    }
    x1 = x;
    other_excess = f;
  }
  return ellipse;
}

ContactTable CalcContactTable(const TrackGeometry& geometry, ContactNotes& notes) {
  if (geometry.rows < 5 || !(geometry.y_max > 0) || !(geometry.wheel_load > 0))
    throw std::invalid_argument(
        fmt::format("CalcContactTable: rows = {}, y_max = {} m, wheel_load = {} N, must be >= 5, > 0, > 0",
                    geometry.rows, geometry.y_max, geometry.wheel_load));
  notes = {};
  try {
    return {.name = geometry.name,
            .r0 = geometry.r0,
            .shear_modulus = geometry.shear_modulus(),
            .rows = TableBuilder(geometry, notes).Build()};
  } catch (const std::domain_error& error) {
    throw std::invalid_argument(
        fmt::format("CalcContactTable: the wheelset does not fit between the rails of \"{}\" for |y| <= {} mm: {}",
                    geometry.name, 1e3 * geometry.y_max, error.what()));
  }
}

ContactTable CalcContactTable(const TrackGeometry& geometry) {
  ContactNotes notes;
  return CalcContactTable(geometry, notes);
}

RollingRadiusDifference CalcRollingRadiusDifference(const ContactTable& table) {
  const std::vector<ContactRow>& rows = table.rows;
  const double reach = std::min(-rows.front().y, rows.back().y);
  std::vector<double> places;
  for (const ContactRow& row : rows) {
    for (const double y : {row.y, -row.y}) {
      if (std::abs(y) <= reach) places.push_back(y);
    }
  }
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  RollingRadiusDifference difference;
  const auto add = [&](double y, double delta_r) {
    difference.y.push_back(y);
    difference.delta_r.push_back(delta_r);
  };
  for (const double y : places) {
    // The right wheel's jump is passed from the other side.
    const double before = CalcRadius(rows, y, false) - CalcRadius(rows, -y, true);
    const double after = CalcRadius(rows, y, true) - CalcRadius(rows, -y, false);
    add(y, before);
    if (before != after) add(y, after);
  }
  return difference;
}

}  // namespace uiclink
