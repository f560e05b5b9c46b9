#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/contact/geometry.h"
#include "vehicle/contact/profile.h"

namespace uiclink {

enum class WheelSide { kLeft, kRight };

/// One wheel above its rail. Both sides are described as the left one is (the right one mirrored): lateral positions
/// count outward from the centre.
struct WheelOnRail {
  Profile wheel;      ///< axes of Profile; y = 0 at the tape circle
  Profile rail;       ///< placed in the track: y = distance from the track centre [m], highest point at z = 0
  double a_tape = 0;  ///< distance of the tape circle from the wheelset's centre [m]
  double r0 = 0;      ///< radius at the tape circle [m]
};

/// A rail head in the track (rail_position.cpp): canted, then shifted so that its highest point has z = 0 and its gauge
/// face is gauge / 2 + rail_offset from the track centre, measured `gauge_depth` below the highest point. Outward and
/// upward positive.
/// @throws std::invalid_argument when the profile does not reach down to the gauge face.
Profile PlaceRail(const Profile& rail, const TrackGeometry& geometry);

/// Wheel and rail profile that a geometry names: a standard one or a file of points, smoothed as it says.
Profile LoadWheelProfile(const TrackGeometry& geometry);
Profile LoadRailProfile(const TrackGeometry& geometry);

/// A point of the wheel above the rail, for a wheelset whose centre is at height r0 over the rail tops (no lift).
struct GapPoint {
  double gap = 0;         ///< vertical distance of wheel and rail [m], without the lift; NaN beside the rail
  double gap_slope = 0;   ///< d gap / d y_wheel [-]
  double gap_second = 0;  ///< d2 gap / d y_wheel2 [1/m]
  double gap_roll = 0;    ///< d gap / d phi [m/rad], of this side's own (mirrored) roll
  double a_rail = 0;      ///< distance from the track centre, track frame [m]
  ProfilePoint wheel;     ///< wheelset frame, z = 0 at the tape circle
  ProfilePoint rail;      ///< track frame
};

/// Two wheels on two rails. Const, shared between threads.
class WheelsetOnRails {
 public:
  /// A symmetric wheelset. @throws as PlaceRail() and ReadProfile().
  explicit WheelsetOnRails(const TrackGeometry& geometry);
  /// @param r0 nominal rolling radius that z_lift counts from [m].
  WheelsetOnRails(WheelOnRail left, WheelOnRail right, double r0);

  const WheelOnRail& side(WheelSide side) const { return side == WheelSide::kLeft ? left_.pair : right_.pair; }
  double r0() const { return r0_; }

  /// @param y_wheel profile coordinate of the wheel [m]
  /// @param y       displacement of the wheelset, positive left [m]
  /// @param phi     its roll, positive left side up [rad]
  GapPoint EvalGap(WheelSide side, double y_wheel, double y, double phi,
                   JointSide joint_side = JointSide::kAbove) const;

  /// Node of the coarse search: end of a cell within one piece of the wheel profile.
  struct Node {
    double y_wheel, a, z, slope;  ///< a outward from the wheelset's centre, z above the axle (negative)
    bool cell_begins;             ///< a cell reaches from this node to the next one
  };
  const std::vector<Node>& nodes(WheelSide side) const { return side == WheelSide::kLeft ? left_.nodes : right_.nodes; }

 private:
  struct Searchable {
    WheelOnRail pair;
    std::vector<Node> nodes;
  };
  static Searchable MakeSearchable(WheelOnRail pair);

  Searchable left_;
  Searchable right_;
  double r0_;
};

/// A local minimum of the gap. All of it in the mirrored axes of WheelOnRail: a_wheel, a_rail > 0, delta > 0 towards
/// the flange on both wheels.
struct ContactCandidate {
  double y_wheel = 0;          ///< profile coordinate of the wheel [m]
  double a_wheel = 0;          ///< lateral distance from the wheelset's centre, wheelset frame [m]
  double a_rail = 0;           ///< from the track centre, track frame [m]
  double z_rail = 0;           ///< height above the rail top [m], <= 0
  double r = 0;                ///< rolling radius [m]
  double delta = 0;            ///< contact angle, wheelset frame [rad]: atan of the common slope
  double curvature_wheel = 0;  ///< of the cross-section [1/m], > 0 where the wheel is convex (mean of both at a joint)
  double curvature_rail = 0;   ///< of the cross-section [1/m], > 0 where the rail is convex
  double gap = 0;              ///< vertical distance [m], 0 for the point that touches, else > 0
  bool at_joint = false;       ///< on a kink of wheel or rail, where the slopes need not agree
};

/// The local minima of one wheel by increasing gap; [0] touches. Holds up to kCapacity, the lowest ones.
class CandidateList {
 public:
  static constexpr std::size_t kCapacity = 24;
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const ContactCandidate& operator[](std::size_t i) const { return items_[i]; }
  const ContactCandidate* begin() const { return items_.data(); }
  const ContactCandidate* end() const { return items_.data() + size_; }
  void clear() { size_ = 0; }
  /// Puts it in its place by gap.
  void Insert(const ContactCandidate& candidate);

 private:
  std::array<ContactCandidate, kCapacity> items_;
  std::size_t size_ = 0;
};

struct KinematicContact {
  double y = 0;
  double z_lift = 0;    ///< height of the wheelset's centre above r0 over the rail tops [m]
  double phi_roll = 0;  ///< roll, positive left side up [rad]
  CandidateList left;
  CandidateList right;

  const CandidateList& side(WheelSide s) const { return s == WheelSide::kLeft ? left : right; }
};

struct ContactSearchOptions {
  bool roll = true;  ///< false: phi = 0 and each wheel touches by itself, as EN 15302 does; z_lift is then the mean of
                     ///< the lifts of both wheels
};

/// Where the wheelset displaced by y stands when both wheels just touch their rails, and all local minima of the gap.
///
/// Unknown: the roll, from  min gap of the left wheel = min gap of the right one (Newton within a bracket; the minima
/// from the sign of the gap's slope on a grid of 0.25 mm, refined to rounding). No allocation.
/// @param phi_guess start value of the roll, e.g. of the neighbouring row.
/// @throws std::domain_error when a wheel touches with the end of a profile, or no roll makes both wheels touch.
KinematicContact FindKinematicContact(const WheelsetOnRails& wheelset, double y,
                                      const ContactSearchOptions& options = {}, double phi_guess = 0);

/// The contact of one wheel jumps: at y two local minima touch together.
struct Jump {
  double y = 0;
  WheelSide side = WheelSide::kLeft;
  double z_lift = 0;        ///< at y
  double phi_roll = 0;      ///< at y
  ContactCandidate before;  ///< touches for smaller y
  ContactCandidate after;   ///< touches for greater y
};

/// All jumps of both wheels for y_low < y < y_high, by increasing y: y to rounding (about 1e-13 m). Jumps that are
/// shorter than 5 um on the wheel are taken for motion.
std::vector<Jump> FindJumps(const WheelsetOnRails& wheelset, double y_low, double y_high,
                            const ContactSearchOptions& options = {});

}  // namespace uiclink
