#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/section_watch.h"
#include "vehicle/hunting/window_watch.h"

namespace uiclink {
namespace {

/// A run that is looked at for longer and longer stretches.
class Search {
 public:
  Search(Integrator& integrator, double V, const WagonState& start, const AttractorOptions& options)
      : integrator_(integrator), options_(options), watch_(integrator.wagon()) {
    WagonState at = start;
    at.t = 0;
    integrator_.Start(V, at);
  }

  RunOutcome Run() {
    try {
      Follow();
    } catch (const std::runtime_error& error) {
      outcome_.end = RunEnd::kFailed;
      outcome_.reason = error.what();
    }
    outcome_.state = integrator_.state();
    outcome_.simulated = outcome_.state.t;
    return outcome_;
  }

 private:
  std::size_t place() const {
    const bool body = options_.section_of == SectionOf::kBodyLateral;
    return kMotionIndex[static_cast<std::size_t>(body ? TrackedMotion::kBodyLateral : TrackedMotion::kFrontLateral)];
  }
  double middle() const { return Sectioned(watch_.CalcMiddles()); }
  double half_width() const { return Sectioned(watch_.CalcHalfWidths()); }
  double Sectioned(const std::array<double, kMotionCount>& of) const {
    const bool body = options_.section_of == SectionOf::kBodyLateral;
    return of[static_cast<std::size_t>(body ? TrackedMotion::kBodyLateral : TrackedMotion::kFrontLateral)];
  }

  void Follow() {
    // The middle is that of the second half of the settling: a motion that dies away has none of its own before.
    if (!Advance(0.5 * options_.settle, nullptr) || !Advance(0.5 * options_.settle, nullptr)) return;
    for (double length = options_.observe;; length *= 2) {
      const double left = options_.longest - integrator_.state().t;
      length = std::min(length, std::max(left, options_.observe));
      SectionWatch section(place(), middle(), 0.2 * half_width());
      // Figures are of the second half, as the section's scatter is: the first may still be on its way.
      if (!Advance(0.5 * length, &section) || !Advance(0.5 * length, &section)) return;
      Look(section, 0.5 * length);
      if (IsClear()) return;
      if (integrator_.state().t + options_.observe > options_.longest) break;
    }
    const bool settled = outcome_.motion.kind != MotionKind::kSettling && outcome_.motion.kind != MotionKind::kTooShort;
    if (!settled) outcome_.end = RunEnd::kUnsettled;
  }

  /// False when the wagon has derailed.
  bool Advance(double duration, SectionWatch* section) {
    const double until = integrator_.state().t + duration;
    watch_.Begin(integrator_);
    while (integrator_.state().t < until) {
      const uiclink::Advance advance = integrator_.Step(until);
      watch_.Add(integrator_);
      if (section != nullptr) section->Add(integrator_);
      if (advance != uiclink::Advance::kDerailed) continue;
      outcome_.end = RunEnd::kDerailed;
      outcome_.reason = fmt::format("a wheelset left the track at {:.2f} s", integrator_.state().t);
      return false;
    }
    outcome_.wheel_lift = watch_.wheel_lift();
    return true;
  }

  /// Figures of the stretch that has just been run, and the kind of motion by the section.
  void Look(const SectionWatch& section, double length) {
    outcome_.observed = length;
    outcome_.half_width = watch_.CalcHalfWidths();
    outcome_.middle = watch_.CalcMiddles();
    for (const Axle axle : {Axle::kFront, Axle::kRear}) {
      outcome_.lateral[static_cast<std::size_t>(axle)] = watch_.Lateral(axle);
      outcome_.longitudinal[static_cast<std::size_t>(axle)] = watch_.Longitudinal(axle);
    }
    outcome_.minimum_wheel_load = watch_.minimum_wheel_load();
    const std::vector<double>& times = section.times();
    const auto cycles = static_cast<double>(times.size()) - 1;
    outcome_.frequency = cycles > 0 ? cycles / (times.back() - times.front()) : 0;
    outcome_.motion = Rests() ? SectionMotion{.kind = MotionKind::kEquilibrium} : Classify(section);
    if (outcome_.motion.kind == MotionKind::kEquilibrium) outcome_.frequency = 0;
  }

  SectionMotion Classify(const SectionWatch& section) const {
    if (section.times().empty()) return {};  // it moves, but not through its middle: too short
    return ClassifySection(section.times(), section.Points(), CalcScales(section), options_.section);
  }

  /// Nothing moves any more but along the track, and it is not growing again.
  bool Rests() const {
    const double now = CalcLargestMotion();
    return now < options_.least_motion && now <= previous_;
  }
  double CalcLargestMotion() const {
    double largest = 0;
    for (std::size_t i = 0; i < kMotionCount; ++i)
      if (!IsLongitudinal(i)) largest = std::max(largest, outcome_.half_width[i]);
    return largest;
  }

  /// A deviation of a share of a coordinate's motion counts as that share. What hardly moves counts as the twentieth of
  /// what moves most; 1 mrad as 1 mm.
  static Eigen::VectorXd CalcScales(const SectionWatch& section) {
    const Eigen::VectorXd widths = section.CalcHalfWidths();
    return widths.cwiseMax(std::max(0.05 * widths.maxCoeff(), 1e-9));
  }

  /// No longer look would say more. Motions that seem irregular may still be transients, or turn out as slow
  /// modulations: they are looked at as long as there is time.
  bool IsClear() {
    previous_ = CalcLargestMotion();
    const MotionKind kind = outcome_.motion.kind;
    return kind == MotionKind::kEquilibrium || kind == MotionKind::kPeriodic || kind == MotionKind::kModulated;
  }

  Integrator& integrator_;
  const AttractorOptions& options_;
  WindowWatch watch_;
  RunOutcome outcome_;
  double previous_ = std::numeric_limits<double>::infinity();  ///< largest half width of the stretch before
};

}  // namespace

RunOutcome RunToAttractor(Integrator& integrator, double V, const WagonState& start, const AttractorOptions& options) {
  return Search(integrator, V, start, options).Run();
}

}  // namespace uiclink
