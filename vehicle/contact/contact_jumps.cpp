#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "vehicle/contact/contact_search.h"

namespace uiclink {
namespace {

constexpr double kStep = 0.05e-3;       // [m] of the displacement, for a first look
constexpr double kShortestJump = 5e-6;  // [m] on the wheel
constexpr double kNarrow = 1e-9;  // [m] of the displacement: narrower, the heights of both minima are straight lines

constexpr double kTied = 3e-16;        // [m] heights that differ by no more than rounding
constexpr double kResolution = 1e-15;  // [m] of the displacement

constexpr std::array kSides{WheelSide::kLeft, WheelSide::kRight};

/// What the search keeps of a displacement.
struct Row {
  double y, phi;
  std::array<double, 2> y_wheel;
};

class JumpSearch {
 public:
  JumpSearch(const WheelsetOnRails& wheelset, const ContactSearchOptions& options)
      : wheelset_(wheelset), options_(options) {}

  Row MakeRow(double y, double phi_guess) const {
    const KinematicContact contact = FindKinematicContact(wheelset_, y, options_, phi_guess);
    return {y, contact.phi_roll, {contact.left[0].y_wheel, contact.right[0].y_wheel}};
  }

  /// Halves the interval while the middle is off the chord of a contact position: a jump or a bend is in it.
  void Search(const Row& low, const Row& high) {
    const Row middle = MakeRow(0.5 * (low.y + high.y), 0.5 * (low.phi + high.phi));
    bool smooth = true;
    for (std::size_t i = 0; i < 2; ++i) {
      smooth = smooth && std::abs(middle.y_wheel[i] - 0.5 * (low.y_wheel[i] + high.y_wheel[i])) < 0.5 * kShortestJump;
    }
    if (smooth) return;
    if (high.y - low.y > kNarrow) {
      Search(low, middle);
      Search(middle, high);
      return;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (std::abs(high.y_wheel[i] - low.y_wheel[i]) >= kShortestJump) AddTie(kSides[i], low, high);
    }
  }

  std::vector<Jump>& jumps() { return jumps_; }

 private:
  static const ContactCandidate* FindNearest(const CandidateList& list, double y_wheel) {
    const ContactCandidate* nearest = nullptr;
    for (const ContactCandidate& candidate : list) {
      if (nearest == nullptr || std::abs(candidate.y_wheel - y_wheel) < std::abs(nearest->y_wheel - y_wheel)) {
        nearest = &candidate;
      }
    }
    const bool same = nearest != nullptr && std::abs(nearest->y_wheel - y_wheel) < 0.2 * kShortestJump;
    return same ? nearest : nullptr;
  }

  /// Height of the minimum near y_after above the one near y_before [m]; NaN where one of them is gone.
  double CalcDifference(const KinematicContact& contact, WheelSide side, double y_before, double y_after) const {
    const ContactCandidate* before = FindNearest(contact.side(side), y_before);
    const ContactCandidate* after = FindNearest(contact.side(side), y_after);
    if (before == nullptr || after == nullptr) return std::numeric_limits<double>::quiet_NaN();
    return after->gap - before->gap;
  }

  /// Where the minimum that touches at `low` and the one that touches at `high` are equally high: regula falsi, with
  /// halved values at the end that stays (Illinois), since the difference bends just there.
  void AddTie(WheelSide side, const Row& low, const Row& high) {
    const auto i = static_cast<std::size_t>(side);
    const double y_before = low.y_wheel[i];
    const double y_after = high.y_wheel[i];
    double y_low = low.y;
    double y_high = high.y;
    KinematicContact tie = FindKinematicContact(wheelset_, y_low, options_, low.phi);
    double at_low = CalcDifference(tie, side, y_before, y_after);
    tie = FindKinematicContact(wheelset_, y_high, options_, high.phi);
    double at_high = CalcDifference(tie, side, y_before, y_after);
    if (!(at_low >= 0 && at_high <= 0)) return;  // one minimum that moves very fast
    double difference = at_high;
    for (int k = 0; k < 60 && std::abs(difference) > kTied && y_high - y_low > kResolution; ++k) {
      const double y = y_low + (y_high - y_low) * at_low / (at_low - at_high);
      tie = FindKinematicContact(wheelset_, y, options_, low.phi);
      difference = CalcDifference(tie, side, y_before, y_after);
      if (difference > 0) {
        if (y_low != low.y) at_high *= 0.5;
        y_low = y;
        at_low = difference;
      } else {
        if (y_high != high.y) at_low *= 0.5;
        y_high = y;
        at_high = difference;
      }
    }
    const ContactCandidate* before = FindNearest(tie.side(side), y_before);
    const ContactCandidate* after = FindNearest(tie.side(side), y_after);
    if (before != nullptr && after != nullptr) {
      jumps_.push_back({tie.y, side, tie.z_lift, tie.phi_roll, *before, *after});
    }
  }

  const WheelsetOnRails& wheelset_;
  ContactSearchOptions options_;
  std::vector<Jump> jumps_;
};

}  // namespace

std::vector<Jump> FindJumps(const WheelsetOnRails& wheelset, double y_low, double y_high,
                            const ContactSearchOptions& options) {
  JumpSearch search(wheelset, options);
  const int intervals = std::max(1, static_cast<int>(std::ceil((y_high - y_low) / kStep)));
  Row before = search.MakeRow(y_low, 0);
  for (int i = 1; i <= intervals; ++i) {
    const Row now = search.MakeRow(i == intervals ? y_high : y_low + (y_high - y_low) * i / intervals, before.phi);
    search.Search(before, now);
    before = now;
  }
  std::stable_sort(search.jumps().begin(), search.jumps().end(),
                   [](const Jump& a, const Jump& b) { return a.y < b.y; });
  return search.jumps();
}

}  // namespace uiclink
