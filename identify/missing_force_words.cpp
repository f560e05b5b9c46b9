#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/missing_force.h"

namespace uiclink {
namespace {

using Bin = MissingForce::Bin;

// What is called significant at one displacement [errors].
constexpr double kStandsOut = 3;
// Share of the largest force at which a force that grows to the end of the swing is said to set in.
constexpr double kOnset = 0.1;
// A rest beside what is named is mentioned when it is this share of what there is beyond noise.
constexpr double kRestShare = 0.1;

/// The largest force that is beyond doubt: by its lower bound, since bins that the motion rushes through are uncertain.
const Bin* FindLargest(const std::vector<Bin>& bins) {
  const auto bound = [](const Bin& bin) { return std::abs(bin.f) - kStandsOut * bin.error; };
  const auto less = [&bound](const Bin& a, const Bin& b) { return bound(a) < bound(b); };
  const auto largest = std::max_element(bins.begin(), bins.end(), less);
  return largest == bins.end() || bound(*largest) < 0 ? nullptr : &*largest;
}

/// Neighbours of a bin that have a good part of its force, in the same direction; in the unit of the axis. A force that
/// grows to the end of the swing is followed down to where it sets in.
std::pair<double, double> FindRange(const std::vector<Bin>& bins, const Bin* peak) {
  const bool is_at_end = peak == &bins.front() || peak == &bins.back();
  const double least = (is_at_end ? kOnset : 0.5) * std::abs(peak->f);
  const auto belongs = [&](const Bin& bin) { return bin.f * peak->f > 0 && std::abs(bin.f) > least; };
  const Bin *low = peak, *high = peak;
  while (low != bins.data() && belongs(*(low - 1))) --low;
  while (high + 1 != bins.data() + bins.size() && belongs(*(high + 1))) ++high;
  const double half_step =
      bins.size() > 1 ? 0.5 * (bins.back().at - bins.front().at) / static_cast<double>(bins.size() - 1) : 0;
  return {std::max(low->at - half_step, bins.front().at), std::min(high->at + half_step, bins.back().at)};
}

bool HasMirror(const std::vector<Bin>& bins, const Bin* peak) {
  return std::any_of(bins.begin(), bins.end(), [&](const Bin& bin) {
    return bin.at * peak->at < 0 && std::abs(bin.at + peak->at) < 0.3 * std::abs(peak->at) &&
           std::abs(bin.f) > 0.5 * std::abs(peak->f);
  });
}

std::string DescribeDisplacement(const std::vector<Bin>& bins) {
  const Bin* peak = FindLargest(bins);
  if (peak == nullptr) return "depends on displacement";
  const auto [low, high] = FindRange(bins, peak);
  std::string where;
  const double far = 1e3 * std::max(std::abs(low), std::abs(high)),
               near = 1e3 * std::min(std::abs(low), std::abs(high));
  const bool both = HasMirror(bins, peak);
  const char* sign = peak->at < 0 && !both ? "-" : "";
  if (low * high <= 0) {
    where = fmt::format("between {:.1f} and {:.1f} mm", 1e3 * low, 1e3 * high);
  } else if (high == bins.back().at || low == bins.front().at) {
    where = fmt::format("beyond {}{:.1f} mm", sign, near);
  } else {
    where = fmt::format("between {0}{1:.1f} and {0}{2:.1f} mm", sign, near, far);
  }
  return fmt::format("depends on displacement: a force of up to {:.2g} M g, largest {}{}", std::abs(peak->f), where,
                     both ? ", on both sides of zero" : ", on one side of zero only");
}

std::string DescribeCurve(const std::vector<Bin>& bins, double scale, const char* unit) {
  const Bin* peak = FindLargest(bins);
  return peak == nullptr ? std::string()
                         : fmt::format(": up to {:.2g} M g at {:.3g} {}", std::abs(peak->f), scale * peak->at, unit);
}

double Swing(const std::vector<Bin>& bins) {
  if (bins.empty()) return 0;
  const auto less = [](const Bin& a, const Bin& b) { return a.f < b.f; };
  const auto [low, high] = std::minmax_element(bins.begin(), bins.end(), less);
  return high->f - low->f;
}

std::string Describe(const MissingForce& force, const Dependence& d, double k) {
  switch (d.on) {
    case DependsOn::kDisplacement:
      return DescribeDisplacement(force.over_y);
    case DependsOn::kDryFriction:
      return fmt::format("depends on the sign of velocity: a dry friction of {:.2g} +- {:.1g} M g", force.dry_friction,
                         force.dry_friction_error);
    case DependsOn::kViscous:
      return fmt::format("is proportional to velocity: a damping of {:.2g} +- {:.1g} s/m per unit load", force.viscous,
                         force.viscous_error);
    case DependsOn::kVelocity:
      return "depends on velocity" + DescribeCurve(force.over_v, 1e3, "mm/s");
    case DependsOn::kTime:
      return fmt::format("changes in time by {:.2g} M g", Swing(force.over_t));
    case DependsOn::kStiffnessInTime:
      return fmt::format("is a stiffness that changes in time, by {:.2g} % of k",
                         100 * Swing(force.stiffness_over_t) / k);
    case DependsOn::kStiffnessOscillating:
      return fmt::format("is a stiffness that is modulated in time, at {:.2f} Hz", d.frequency);
  }
  return {};
}

/// "; not on velocity or time": what is neither named nor significant by itself.
std::string DescribeAbsent(const DependenceSearch& search) {
  const auto is_there = [&search](std::initializer_list<DependsOn> kinds) {
    return std::any_of(kinds.begin(), kinds.end(),
                       [&](DependsOn on) { return search.all[static_cast<std::size_t>(on)].named; });
  };
  std::vector<std::string> absent;
  if (!is_there({DependsOn::kDisplacement, DependsOn::kStiffnessInTime, DependsOn::kStiffnessOscillating}))
    absent.emplace_back("displacement");
  if (!is_there({DependsOn::kDryFriction, DependsOn::kViscous, DependsOn::kVelocity})) absent.emplace_back("velocity");
  if (!is_there({DependsOn::kTime, DependsOn::kStiffnessInTime, DependsOn::kStiffnessOscillating}))
    absent.emplace_back("time");
  return absent.empty() ? std::string() : fmt::format("; not on {}", fmt::join(absent, " or "));
}

}  // namespace

std::string DescribeMissingForce(const MissingForce& force, double k) {
  const DependenceSearch& search = force.search;
  if (!force.IsSignificant()) {
    return fmt::format("no missing force above {:.1g} M g at any displacement, no dry friction above {:.1g} M g",
                       force.smallest_seen, 3 * force.dry_friction_error);
  }
  if (search.named.empty()) {
    return "a force is missing that is no function of displacement, velocity or time alone, nor a stiffness that "
           "changes "
           "in time";
  }
  std::string words;
  for (const std::size_t i : search.named) {
    if (!words.empty()) words += "; beside that it ";
    words += Describe(force, search.all[i], k);
  }
  words += DescribeAbsent(search);
  const double rest = (search.chi2_left - force.dof + search.terms) / (search.chi2 - force.dof);
  if (rest > kRestShare) words += fmt::format("; {:.0f} % of it is explained by none of these", 100 * rest);
  return words;
}

}  // namespace uiclink
