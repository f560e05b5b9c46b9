#include "vehicle/contact/contact_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace uiclink {
namespace {

constexpr double kCell = 0.25e-3;        // [m] cell of the coarse search; pieces shorter than that are cells too
constexpr double kSteepestWheel = 12;    // slope beyond which a wheel is the back of its flange
constexpr double kLargestRoll = 0.04;    // [rad] a wheel on the tip of its flange rolls the wheelset by half of it
constexpr double kStepInHeight = 1e-10;  // [m] between pieces of a wheel: less is the rounding of printed coefficients
constexpr double kSmoothSlope = 1e-8;    // a larger slope of the gap at a minimum means a kink

/// One wheel at given displacement and roll, in its own mirrored axes.
struct Pose {
  double y, phi, cos, sin;
  Pose(WheelSide side, double y_wheelset, double roll)
      : y(side == WheelSide::kLeft ? y_wheelset : -y_wheelset),
        phi(side == WheelSide::kLeft ? roll : -roll),
        cos(std::cos(phi)),
        sin(std::sin(phi)) {}
};

/// A local minimum of the gap before its details are wanted.
struct Minimum {
  double y_wheel;
  JointSide joint_side;
  double gap;
  double gap_roll;
  bool at_joint;
  bool at_end;  ///< of a profile: what is missing there might touch first
};

/// Unordered; the highest gives way when full.
class MinimumList {
 public:
  void Add(const Minimum& minimum) {
    if (size_ < items_.size()) {
      items_[size_++] = minimum;
    } else {
      Minimum& highest = *std::max_element(items_.begin(), items_.end(), ByGap);
      if (minimum.gap < highest.gap) highest = minimum;
    }
  }
  Minimum* begin() { return items_.data(); }
  Minimum* end() { return items_.data() + size_; }
  const Minimum* begin() const { return items_.data(); }
  const Minimum* end() const { return items_.data() + size_; }
  void clear() { size_ = 0; }
  const Minimum* Lowest() const { return size_ == 0 ? nullptr : std::min_element(begin(), end(), ByGap); }

 private:
  static bool ByGap(const Minimum& a, const Minimum& b) { return a.gap < b.gap; }
  std::array<Minimum, CandidateList::kCapacity> items_;
  std::size_t size_ = 0;
};

GapPoint EvalGapInPose(const WheelOnRail& pair, double r0, const ProfilePoint& wheel, double y_wheel,
                       const Pose& pose) {
  const double a = pair.a_tape + y_wheel;
  const double z = wheel.z - pair.r0;
  GapPoint point;
  point.wheel = wheel;
  point.a_rail = pose.y + a * pose.cos - z * pose.sin;
  point.rail = pair.rail.Eval(point.a_rail);
  const double ds = pose.cos - wheel.slope * pose.sin;  // d a_rail / d y_wheel
  point.gap = r0 + a * pose.sin + z * pose.cos - point.rail.z;
  point.gap_slope = pose.sin + wheel.slope * pose.cos - point.rail.slope * ds;
  point.gap_second = wheel.second * (pose.cos + point.rail.slope * pose.sin) - point.rail.second * ds * ds;
  point.gap_roll = a * pose.cos - z * pose.sin + point.rail.slope * (a * pose.sin + z * pose.cos);
  return point;
}

/// The minima of one wheel's gap.
class GapSearch {
 public:
  GapSearch(const WheelsetOnRails& wheelset, WheelSide side, double y, double phi)
      : pair_(wheelset.side(side)), nodes_(wheelset.nodes(side)), r0_(wheelset.r0()), pose_(side, y, phi) {}

  /// All local minima, from the sign of the gap's slope at the nodes.
  void FindAll(MinimumList& minima) const {
    minima.clear();
    Sample before;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Sample now = EvalNode(nodes_[i]);
      if (i == 0) {
        if (now.on_rail && now.slope > 0) AddEnd(nodes_[i].y_wheel, JointSide::kAbove, minima);
      } else if (nodes_[i - 1].cell_begins) {
        SearchCell(nodes_[i - 1], before, nodes_[i], now, minima);
      } else if (before.on_rail && now.on_rail) {
        SearchJoint(nodes_[i].y_wheel, before.slope, now.slope, minima);
      }
      before = now;
    }
    if (before.on_rail && before.slope < 0) AddEnd(nodes_.back().y_wheel, JointSide::kBelow, minima);
  }

  /// Moves a minimum that was found at another roll to this one. @return false where it is no minimum any more.
  bool Follow(Minimum& minimum) const {
    if (!minimum.at_joint && !minimum.at_end) {
      double y = minimum.y_wheel;
      for (int i = 0; i < 20; ++i) {
        const GapPoint p = EvalGap(y, minimum.joint_side);
        const double step = -p.gap_slope / p.gap_second;
        if (!(p.gap_second > 0) || !(std::abs(step) < kCell)) return false;
        y += step;
        if (std::abs(step) < 1e-12) {
          minimum.y_wheel = y;
          break;
        }
        if (i == 19) return false;
      }
    }
    const GapPoint p = EvalGap(minimum.y_wheel, minimum.joint_side);
    minimum.gap = p.gap;
    minimum.gap_roll = p.gap_roll;
    return std::isfinite(p.gap);
  }

  ContactCandidate Describe(const Minimum& minimum, double lift) const {
    const GapPoint p = EvalGap(minimum.y_wheel, minimum.joint_side);
    ContactCandidate contact;
    contact.y_wheel = minimum.y_wheel;
    contact.a_wheel = pair_.a_tape + minimum.y_wheel;
    contact.a_rail = p.a_rail;
    contact.z_rail = p.rail.z;
    contact.r = pair_.r0 - p.wheel.z;
    contact.delta = std::atan(p.wheel.slope);
    contact.curvature_wheel = p.wheel.Curvature();
    contact.curvature_rail = -p.rail.Curvature();
    contact.gap = minimum.gap + lift;
    contact.at_joint = minimum.at_joint;
    if (minimum.at_joint) {
      const GapPoint below = EvalGap(minimum.y_wheel, JointSide::kBelow);
      if (below.wheel.slope != p.wheel.slope ||
          below.wheel.z != p.wheel.z) {  // the wheel's kink: the rail says where to
        contact.delta = std::atan(p.rail.slope) - pose_.phi;
        contact.curvature_wheel =
            0.5 * (below.wheel.Curvature() + EvalGap(minimum.y_wheel, JointSide::kAbove).wheel.Curvature());
      }
    }
    return contact;
  }

 private:
  struct Sample {
    bool on_rail = false;
    double slope = 0;  ///< of the gap
  };

  GapPoint EvalGap(double y_wheel, JointSide joint_side) const {
    return EvalGapInPose(pair_, r0_, pair_.wheel.Eval(y_wheel, joint_side), y_wheel, pose_);
  }

  Sample EvalNode(const WheelsetOnRails::Node& node) const {
    const double s = pose_.y + node.a * pose_.cos - node.z * pose_.sin;
    if (!pair_.rail.Contains(s)) return {};
    return {true, pose_.sin + node.slope * pose_.cos - pair_.rail.CalcSlope(s) * (pose_.cos - node.slope * pose_.sin)};
  }

  void Add(double y_wheel, JointSide joint_side, bool at_joint, bool at_end, MinimumList& minima) const {
    const GapPoint p = EvalGap(y_wheel, joint_side);
    minima.Add({y_wheel, joint_side, p.gap, p.gap_roll, at_joint, at_end});
  }
  void AddEnd(double y_wheel, JointSide joint_side, MinimumList& minima) const {
    Add(y_wheel, joint_side, false, true, minima);
  }

  void SearchCell(const WheelsetOnRails::Node& begin, const Sample& at_begin, const WheelsetOnRails::Node& end,
                  const Sample& at_end, MinimumList& minima) const {
    if (at_begin.on_rail && at_end.on_rail) {
      if (at_begin.slope < 0 && at_end.slope >= 0) Refine(begin.y_wheel, end.y_wheel, minima);
    } else if (at_begin.on_rail) {
      SearchRailEnd(begin.y_wheel, at_begin, end.y_wheel, minima);
    } else if (at_end.on_rail) {
      SearchRailEnd(end.y_wheel, at_end, begin.y_wheel, minima);
    }
  }

  /// A minimum between a point above the rail and the end of the rail, or at that end.
  void SearchRailEnd(double inside, const Sample& at_inside, double outside, MinimumList& minima) const {
    const double from = inside;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (inside + outside);
      (std::isfinite(EvalGap(middle, JointSide::kAbove).gap) ? inside : outside) = middle;
    }
    const double at_edge = EvalGap(inside, JointSide::kAbove).gap_slope;
    const bool ends_above = outside > from;
    const double low_slope = ends_above ? at_inside.slope : at_edge;
    const double high_slope = ends_above ? at_edge : at_inside.slope;
    if (low_slope < 0 && high_slope >= 0) Refine(std::min(from, inside), std::max(from, inside), minima);
    if (ends_above ? at_edge < 0 : at_edge > 0) AddEnd(inside, JointSide::kAbove, minima);
  }

  /// Where two pieces of the wheel meet: a corner that juts out, or the lower edge of a step.
  void SearchJoint(double y_wheel, double slope_below, double slope_above, MinimumList& minima) const {
    const double step = EvalGap(y_wheel, JointSide::kAbove).gap - EvalGap(y_wheel, JointSide::kBelow).gap;
    if (std::abs(step) < kStepInHeight) {
      if (slope_below < 0 && slope_above >= 0) Add(y_wheel, JointSide::kAbove, true, false, minima);
    } else if (step < 0) {
      if (slope_above >= 0) Add(y_wheel, JointSide::kAbove, true, false, minima);
    } else if (slope_below <= 0) {
      Add(y_wheel, JointSide::kBelow, true, false, minima);
    }
  }

  /// The minimum of a cell over whose length the slope turns from negative to not negative: Newton within bisection.
  void Refine(double low, double high, MinimumList& minima) const {
    const double end = high;
    double y = 0.5 * (low + high);
    GapPoint p;
    for (int i = 0; i < 100; ++i) {
      // At the cell's end, the limit of the cell's own piece.
      p = EvalGap(y, y == end ? JointSide::kBelow : JointSide::kAbove);
      if (p.gap_slope == 0) break;
      (p.gap_slope < 0 ? low : high) = y;
      double next = y - p.gap_slope / p.gap_second;
      if (!(p.gap_second > 0) || !(next > low && next < high)) next = 0.5 * (low + high);
      const double step = next - y;
      y = next;
      if (std::abs(step) < 1e-13 || high - low < 1e-15) break;
    }
    const JointSide joint_side = y == end ? JointSide::kBelow : JointSide::kAbove;
    p = EvalGap(y, joint_side);
    const bool kink = std::abs(p.gap_slope) > kSmoothSlope;  // of the rail: those of the wheel are ends of cells
    minima.Add({y, joint_side, p.gap, p.gap_roll, kink, false});
  }

  const WheelOnRail& pair_;
  const std::vector<WheelsetOnRails::Node>& nodes_;
  double r0_;
  Pose pose_;
};

struct BothMinima {
  MinimumList left, right;
};

/// What has to vanish for both wheels to touch, and its derivative by the roll.
struct Imbalance {
  double height;
  double by_roll;
};

[[noreturn]] void ThrowNoContact(double y, const std::string& why) {
  throw std::domain_error("contact search: with the wheelset displaced by " + std::to_string(1e3 * y) + " mm " + why);
}

Imbalance CalcImbalance(const BothMinima& minima, double y) {
  const Minimum* left = minima.left.Lowest();
  const Minimum* right = minima.right.Lowest();
  if (left == nullptr || right == nullptr) ThrowNoContact(y, "a wheel has no rail below it");
  return {left->gap - right->gap, left->gap_roll + right->gap_roll};
}

void FindAllMinima(const WheelsetOnRails& wheelset, double y, double phi, BothMinima& minima) {
  GapSearch(wheelset, WheelSide::kLeft, y, phi).FindAll(minima.left);
  GapSearch(wheelset, WheelSide::kRight, y, phi).FindAll(minima.right);
}

/// Moves the minima to another roll; false where the coarse search is needed again.
bool FollowMinima(const WheelsetOnRails& wheelset, double y, double phi, BothMinima& minima) {
  const auto follow = [&](WheelSide side, MinimumList& list) {
    const GapSearch search(wheelset, side, y, phi);
    return std::all_of(list.begin(), list.end(), [&](Minimum& minimum) { return search.Follow(minimum); });
  };
  return follow(WheelSide::kLeft, minima.left) && follow(WheelSide::kRight, minima.right);
}

/// Newton for the roll within a bracket that shrinks: the imbalance grows with the roll.
class RollSolver {
 public:
  explicit RollSolver(double phi) : phi_(phi) {}
  double phi() const { return phi_; }
  /// @return false when the roll cannot be told better.
  bool Step(const Imbalance& imbalance) {
    (imbalance.height < 0 ? low_ : high_) = phi_;
    double next = phi_ - imbalance.height / imbalance.by_roll;
    const bool slow = ++steps_ > kNewtonSteps;  // between two minima that come and go, Newton may creep
    if (slow || !(imbalance.by_roll > 0) || !(next > low_ && next < high_)) next = 0.5 * (low_ + high_);
    const double step = next - phi_;
    phi_ = next;
    return std::abs(step) > kSameRoll;
  }
  void MoveTo(double phi) {
    if (phi > low_ && phi < high_) phi_ = phi;
  }
  bool AtLimit() const { return kLargestRoll - std::abs(phi_) < 1e-6; }

 private:
  static constexpr int kNewtonSteps = 12;
  static constexpr double kSameRoll = 1e-16;

  double phi_;
  double low_ = -kLargestRoll;
  double high_ = kLargestRoll;
  int steps_ = 0;
};

/// The imbalance [m] that counts as none: rounding of heights of half a metre.
constexpr double kBalanced = 3e-16;

/// The roll at which both wheels touch; `minima` are those at that roll.
double SolveRoll(const WheelsetOnRails& wheelset, double y, double phi_guess, BothMinima& minima) {
  RollSolver solver(std::clamp(phi_guess, -0.9 * kLargestRoll, 0.9 * kLargestRoll));
  constexpr int kFollowedScans = 12;
  for (int scan = 0; scan < 100; ++scan) {
    FindAllMinima(wheelset, y, solver.phi(), minima);
    Imbalance imbalance = CalcImbalance(minima, y);
    if (std::abs(imbalance.height) <= kBalanced || (scan > 0 && std::abs(imbalance.height) < 2e-15))
      return solver.phi();
    if (!solver.Step(imbalance)) return solver.phi();
    if (solver.AtLimit()) ThrowNoContact(y, "no roll lets both wheels touch");
    if (scan > kFollowedScans) continue;
    // Follow the minima as far as they go, then look at all of the gap again.
    RollSolver follower = solver;
    for (int i = 0; i < 8; ++i) {
      BothMinima moved = minima;
      if (!FollowMinima(wheelset, y, follower.phi(), moved)) break;
      imbalance = CalcImbalance(moved, y);
      solver.MoveTo(follower.phi());  // its bracket stays one of full searches
      if (std::abs(imbalance.height) <= kBalanced || !follower.Step(imbalance)) break;
    }
  }
  ThrowNoContact(y, "the roll does not settle");
}

void DescribeAll(const GapSearch& search, const MinimumList& minima, double lift, double y, CandidateList& list) {
  const Minimum* lowest = minima.Lowest();
  if (lowest->at_end) ThrowNoContact(y, "a wheel touches where a profile ends: the profile is too short");
  for (const Minimum& minimum : minima) {
    if (!minimum.at_end) list.Insert(search.Describe(minimum, lift));
  }
}

}  // namespace

WheelsetOnRails::Searchable WheelsetOnRails::MakeSearchable(WheelOnRail pair) {
  std::vector<Node> nodes;
  for (const ProfilePiece& piece : pair.wheel.pieces()) {
    const double length = piece.y_end() - piece.y_begin();
    const int cells = std::max(1, static_cast<int>(std::lround(length / kCell)));
    for (int i = 0; i <= cells; ++i) {
      const double y = i == cells ? piece.y_end() : piece.y_begin() + length * i / cells;
      const ProfilePoint p = piece.Eval(y);
      if (!(std::abs(p.slope) <= kSteepestWheel)) {
        if (!nodes.empty()) nodes.back().cell_begins = false;
        continue;
      }
      nodes.push_back({y, pair.a_tape + y, p.z - pair.r0, p.slope, i < cells});
    }
  }
  if (nodes.size() < 2) throw std::invalid_argument("wheel " + pair.wheel.name() + ": too steep everywhere");
  nodes.back().cell_begins = false;
  return {std::move(pair), std::move(nodes)};
}

WheelsetOnRails::WheelsetOnRails(WheelOnRail left, WheelOnRail right, double r0)
    : left_(MakeSearchable(std::move(left))), right_(MakeSearchable(std::move(right))), r0_(r0) {}

WheelsetOnRails::WheelsetOnRails(const TrackGeometry& geometry)
    : left_(MakeSearchable({.wheel = LoadWheelProfile(geometry),
                            .rail = PlaceRail(LoadRailProfile(geometry), geometry),
                            .a_tape = geometry.back_to_back / 2 + geometry.tape_circle,
                            .r0 = geometry.r0})),
      right_(left_),
      r0_(geometry.r0) {}

GapPoint WheelsetOnRails::EvalGap(WheelSide which, double y_wheel, double y, double phi, JointSide joint_side) const {
  const WheelOnRail& pair = side(which);
  return EvalGapInPose(pair, r0_, pair.wheel.Eval(y_wheel, joint_side), y_wheel, Pose(which, y, phi));
}

void CandidateList::Insert(const ContactCandidate& candidate) {
  std::size_t place = size_;
  while (place > 0 && items_[place - 1].gap > candidate.gap) --place;
  if (place == kCapacity) return;
  if (size_ < kCapacity) ++size_;
  for (std::size_t i = size_ - 1; i > place; --i) items_[i] = items_[i - 1];
  items_[place] = candidate;
}

KinematicContact FindKinematicContact(const WheelsetOnRails& wheelset, double y, const ContactSearchOptions& options,
                                      double phi_guess) {
  BothMinima minima;
  double phi = 0;
  if (options.roll) {
    phi = SolveRoll(wheelset, y, phi_guess, minima);
  } else {
    FindAllMinima(wheelset, y, 0, minima);
    CalcImbalance(minima, y);  // for its check that there are minima
  }
  const double lift_left = -minima.left.Lowest()->gap;
  const double lift_right = -minima.right.Lowest()->gap;
  KinematicContact contact;
  contact.y = y;
  contact.phi_roll = phi;
  contact.z_lift = 0.5 * (lift_left + lift_right);
  DescribeAll(GapSearch(wheelset, WheelSide::kLeft, y, phi), minima.left, lift_left, y, contact.left);
  DescribeAll(GapSearch(wheelset, WheelSide::kRight, y, phi), minima.right, lift_right, y, contact.right);
  return contact;
}

}  // namespace uiclink
