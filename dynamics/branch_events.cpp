#include "dynamics/branch_events.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numeric>
#include <optional>

namespace uiclink {
namespace {

constexpr int kMostTries = 40;  // bisection alone gains twelve decimals in them

/// What changes its sign where something happens.
using TestFunction = std::function<double(const BranchPoint&)>;

/// Multipliers but the trivial one, by falling magnitude.
std::vector<std::complex<double>> Nontrivial(const Cycle& cycle, bool forced) {
  return {cycle.multipliers.begin() + (forced || cycle.multipliers.empty() ? 0 : 1), cycle.multipliers.end()};
}

/// Unstable multipliers, sorted by where they have left the unit circle.
struct UnstableCount {
  int above = 0;    ///< real, > 1
  int below = 0;    ///< real, < -1
  int complex = 0;  ///< in pairs: both counted
  int all() const { return above + below + complex; }
};

UnstableCount CountUnstable(const Cycle& cycle, bool forced) {
  UnstableCount count;
  const std::vector<std::complex<double>> values = Nontrivial(cycle, forced);
  for (std::size_t i = 0; i < values.size() && i < static_cast<std::size_t>(cycle.unstable); ++i) {
    ++(values[i].imag() != 0 ? count.complex : values[i].real() > 0 ? count.above : count.below);
  }
  return count;
}

/// Magnitude less one of the multiplier with a place in the order of magnitudes.
TestFunction MagnitudeOf(int place, bool forced) {
  return [place, forced](const BranchPoint& point) {
    const auto values = Nontrivial(point.cycle, forced);
    const auto i = static_cast<std::size_t>(place);
    return i < values.size() ? std::abs(values[i]) - 1 : -1.0;
  };
}

/// prod(1 + multiplier), which is real: complex ones come in pairs.
TestFunction PeriodDoublingTest(bool forced) {
  return [forced](const BranchPoint& point) {
    std::complex<double> product = 1;
    for (const auto& value : Nontrivial(point.cycle, forced)) product *= 1.0 + value;
    return product.real();
  };
}

/// The point at a distance, or if there is none a little further on: where branches cross the equations are singular.
std::optional<BranchPoint> PointNear(BranchStepper* stepper, const BranchPoint& from, double* distance, double most) {
  for (int i = 0; i < 2; ++i) {
    try {
      return stepper->PointAhead(from, *distance);
    } catch (const std::exception&) {
      *distance += 0.2 * (most - *distance);
    }
  }
  return std::nullopt;
}

/// The zero of a test function between a and b = a + distance: false position with halved weights (Illinois), every
/// third step a bisection, so that a kink does not hold it up. Nothing when there is no change of sign, or when no
/// cycle is found on the way.
std::optional<BranchPoint> Locate(BranchStepper* stepper, const BranchPoint& a, const BranchPoint& b, double distance,
                                  const TestFunction& test, double tolerance) {
  double low = 0, high = distance, at_low = test(a), at_high = test(b);
  if (!(at_low * at_high < 0)) return std::nullopt;
  const double slope_b = std::abs(b.tangent.lambda);
  double slope_low = std::abs(a.tangent.lambda), slope_high = slope_b;
  BranchPoint best = std::abs(at_low) < std::abs(at_high) ? a : b;
  double at_best = std::min(std::abs(at_low), std::abs(at_high));
  for (int i = 0; i < kMostTries && std::max(slope_low, slope_high) * (high - low) > tolerance; ++i) {
    double middle = i % 3 == 2 ? 0.5 * (low + high) : (low * at_high - high * at_low) / (at_high - at_low);
    const std::optional<BranchPoint> point = PointNear(stepper, a, &middle, high);
    if (!point) return std::nullopt;
    const double value = test(*point);
    if (std::abs(value) < at_best) {
      at_best = std::abs(value);
      best = *point;
    }
    const bool in_low = (value < 0) == (at_low < 0);
    (in_low ? low : high) = middle;
    (in_low ? slope_low : slope_high) = std::abs(point->tangent.lambda);
    (in_low ? at_high : at_low) *= 0.5;
    (in_low ? at_low : at_high) = value;
    if (value == 0) break;
  }
  return best;
}

class EventFinder {
 public:
  EventFinder(BranchStepper* stepper, const BranchPoint& a, const BranchPoint& b, double distance, std::size_t index,
              const ContinuationOptions& options)
      : stepper_(stepper), a_(a), b_(b), distance_(distance), index_(index), options_(options) {}

  std::vector<BranchEvent> Run(bool forced) {
    const UnstableCount before = CountUnstable(a_.cycle, forced), after = CountUnstable(b_.cycle, forced);
    int single = 0;  // multipliers that have passed alone
    if (a_.tangent.lambda * b_.tangent.lambda < 0) {
      Add(BranchEventKind::kFold, [](const BranchPoint& point) { return point.tangent.lambda; });
      ++single;
    }
    if (a_.determinant * b_.determinant < 0) {
      Add(BranchEventKind::kBranchPoint, [](const BranchPoint& point) { return point.determinant; });
      ++single;
    }
    if ((before.below - after.below) % 2 != 0) {
      Add(BranchEventKind::kPeriodDoubling, PeriodDoublingTest(forced));
      ++single;
    }
    const UnstableCount& more = before.all() > after.all() ? before : after;
    if (std::abs(before.all() - after.all()) - single >= 2 && more.complex > 0) {
      Add(BranchEventKind::kTorus, MagnitudeOf(std::min(before.all(), after.all()), forced));
    }
    if (a_.cycle.passage.character != b_.cycle.passage.character) AddCharacter();
    return std::move(events_);
  }

 private:
  void Add(BranchEventKind kind, const TestFunction& test) {
    const std::optional<BranchPoint> found = Locate(stepper_, a_, b_, distance_, test, options_.fold_tolerance);
    const BranchPoint& nearest = std::abs(test(a_)) < std::abs(test(b_)) ? a_ : b_;
    Add(kind, (found ? *found : nearest).cycle);
  }

  void Add(BranchEventKind kind, const Cycle& cycle) {
    events_.push_back({kind, cycle.lambda, cycle.period, index_, "", false, cycle});
  }

  void AddCharacter() {
    Add(BranchEventKind::kCharacter, b_.cycle);
    events_.back().lambda = 0.5 * (a_.cycle.lambda + b_.cycle.lambda);
    events_.back().text = a_.cycle.passage.character + " -> " + b_.cycle.passage.character;
  }

  BranchStepper* stepper_;
  const BranchPoint &a_, &b_;
  double distance_;
  std::size_t index_;
  const ContinuationOptions& options_;
  std::vector<BranchEvent> events_;
};

}  // namespace

std::vector<BranchEvent> FindEvents(BranchStepper* stepper, const BranchPoint& a, const BranchPoint& b, double distance,
                                    std::size_t index, const ContinuationOptions& options) {
  return EventFinder(stepper, a, b, distance, index, options).Run(stepper->forced());
}

}  // namespace uiclink
