#include "vehicle/wagon_guards.h"

#include <algorithm>
#include <cmath>

#include "vehicle/integrator.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Kind = WagonGuards::Kind;

std::int8_t SignOf(double value) { return value > 0 ? 1 : -1; }

}  // namespace

void HermiteStep::At(double t, StateVector<double>* x) const {
  const double u = 1 - t;
  const double a = u * u * (1 + 2 * t), b = t * t * (3 - 2 * t), c = h * t * u * u, d = -h * t * t * u;
  for (std::size_t i = 0; i < kMaxState; ++i) (*x)[i] = a * x0[i] + b * x1[i] + c * f0[i] + d * f1[i];
}

WagonGuards::WagonGuards(const Wagon& wagon) : wagon_(&wagon), track_limit_(FindTrackLimit(wagon.contact)) {
  for (const auto* links : {&wagon.longitudinal, &wagon.lateral})
    for (const Link& link : *links) needs_acceleration_ = needs_acceleration_ || link.needs_acceleration();
  const auto add = [this](Kind kind, std::size_t corner) { guards_[count_++] = {kind, corner, 1}; };
  add(Kind::kLinks, 0);  // the least margin of all: what has come to its end changes over (LinkState::Switch)
  add(Kind::kTrack, 0);
  if (wagon.options.guidance) {
    for (std::size_t i = 0; i < kCorners; ++i) add(Kind::kLongitudinalStop, i);
    for (std::size_t i : {0, 2}) add(Kind::kLateralStop, i);  // both boxes of a wheelset touch together
  }
  const Suspension suspension = wagon.options.suspension;
  if (suspension == Suspension::kLinear) return;
  for (std::size_t i = 0; i < kCorners; ++i)
    add(suspension == Suspension::kParabolic ? Kind::kStage : Kind::kLeafReversal, i);
}

void WagonGuards::Start(double V, WagonState* state) {
  V_ = V;
  derailed_ = false;
  leaf_travel_.fill(0);
  Settle(state);
  FollowLeaves(state->x);
  SetSides(state->links, state->x);
}

void WagonGuards::SetSides(const LinkStates& links, const StateVector<double>& x) {
  Values values;
  Calc(links, x, values.data());
  for (std::size_t i = 0; i < count_; ++i) guards_[i].side = SignOf(values[i]);
}

double WagonGuards::Pass(const HermiteStep& step, WagonState* state) {
  Values values;
  Calc(state->links, step.x1, values.data());
  if (!HasAnyCrossed(values)) {
    for (std::size_t i = 0; i < count_; ++i) guards_[i].side = SignOf(values[i]);
    FollowLeaves(step.x1);
    return -1;
  }
  const double share = Find(step, state->links, values);
  step.At(share, &state->x);
  Calc(state->links, state->x, values.data());
  Cross(values, state);
  return share;
}

/// Goes over to the other side of the guards that have crossed.
void WagonGuards::Cross(const Values& values, WagonState* state) {
  std::array<bool, kMost> crossed{};
  for (std::size_t i = 0; i < count_; ++i) {
    crossed[i] = HasCrossed(i, values[i]);
    if (crossed[i] && guards_[i].kind == Kind::kLinks) Settle(state);
    if (crossed[i] && guards_[i].kind == Kind::kTrack) derailed_ = true;
  }
  FollowLeaves(state->x);
  Values after;
  Calc(state->links, state->x, after.data());
  // A value within rounding of zero does not say on which side it is.
  for (std::size_t i = 0; i < count_; ++i) {
    std::int8_t& side = guards_[i].side;
    const bool changes = crossed[i] && !IsFalling(guards_[i].kind);
    side = changes ? static_cast<std::int8_t>(-side) : SignOf(after[i]);
  }
}

bool WagonGuards::HasCrossed(std::size_t i, double value) const {
  const Guard& guard = guards_[i];
  return value * guard.side <= 0 && (guard.side > 0 || !IsFalling(guard.kind));
}

bool WagonGuards::HasAnyCrossed(const Values& values) const {
  for (std::size_t i = 0; i < count_; ++i)
    if (HasCrossed(i, values[i])) return true;
  return false;
}

/// Where the earliest of the secants of the crossed guards is zero, as a share of the bracket.
double WagonGuards::CalcSecant(const Values& low, const Values& high, double weight) const {
  double share = 1;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!HasCrossed(i, high[i])) continue;
    const double from = std::max(low[i] * guards_[i].side, 0.0);
    const double to = -weight * high[i] * guards_[i].side;
    share = std::min(share, from + to > 0 ? from / (from + to) : 0.5);
  }
  return share;
}

/// Illinois method: the end that stays for the second time counts half. The answer is behind the event, by less than
/// 1e-13 s.
double WagonGuards::Find(const HermiteStep& step, const LinkStates& links, const Values& at_end) const {
  const double close = 1e-13 / step.h;
  double low = 0, high = 1;
  Values at_low, at_high = at_end, values;
  Calc(links, step.x0, at_low.data());
  double weight = 1;
  bool before = false;
  for (int n = 0; n < 100 && high - low > close; ++n) {
    const double width = high - low;
    // Never closer to an end than half of what is asked for: so the bracket closes from both sides.
    const double margin = std::min(0.5 * width, std::max(0.5 * close, n > 30 ? 0.25 * width : 0));
    const double share = std::clamp(CalcSecant(at_low, at_high, weight) * width, margin, width - margin);
    StateVector<double> x;
    step.At(low + share, &x);
    Calc(links, x, values.data());
    const bool crossed = HasAnyCrossed(values);
    (crossed ? high : low) += crossed ? share - width : share;
    (crossed ? at_high : at_low) = values;
    weight = n == 0 || crossed != before ? 1 : crossed ? 2 * weight : 0.5 * weight;
    before = crossed;
  }
  return high;
}

double WagonGuards::CalcLinkMargin(const LinkStates& links, const StateVector<double>& x, const Deflections& at) const {
  StateVector<double> rate;
  if (needs_acceleration_) CalcRate(*wagon_, V_, links, x, &rate);
  double margin = kFar;
  for (std::size_t i = 0; i < kCorners; ++i) {
    CornerDeflection<double> moves;
    if (needs_acceleration_) moves = CalcDeflection(*wagon_, rate, i);
    margin = std::min({margin, links.longitudinal[i].CalcMargin(wagon_->longitudinal[i], at[i].dx, at[i].vx, moves.vx),
                       links.lateral[i].CalcMargin(wagon_->lateral[i], at[i].dy, at[i].vy, moves.vy)});
  }
  return margin;
}

void WagonGuards::Calc(const LinkStates& links, const StateVector<double>& x, double* values) const {
  Deflections at;
  for (std::size_t i = 0; i < kCorners; ++i) at[i] = CalcDeflection(*wagon_, x, i);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t c = guards_[i].corner;
    double& value = values[i];
    switch (guards_[i].kind) {
      case Kind::kLinks:
        value = CalcLinkMargin(links, x, at);
        break;
      case Kind::kTrack:
        value = track_limit_ - std::max(std::abs(x[wheelset::kY]), std::abs(x[kRearWheelset + wheelset::kY]));
        break;
      case Kind::kLongitudinalStop:
        value = std::abs(at[c].dx) - wagon_->guidance.longitudinal.clearance;
        break;
      case Kind::kLateralStop:
        value = std::abs(at[c].dy) - wagon_->guidance.lateral.clearance;
        break;
      case Kind::kStage:
        value = at[c].s - wagon_->parabolic.s0;
        break;
      case Kind::kLeafReversal:
        value = leaf_travel_[c] == 0 ? kFar : leaf_travel_[c] * at[c].vs + kLeafAtRest;
        break;
    }
  }
}

void WagonGuards::Settle(WagonState* state) const {
  const auto settle = [&](const Link& link, LinkState* joints, std::size_t corner, bool longitudinal) {
    const CornerDeflection<double> at = CalcDeflection(*wagon_, state->x, corner);
    StateVector<double> rate{};
    for (int n = 0; n < 32; ++n) {
      // A link at rest takes its direction of travel from the acceleration: without one its reversals, and slips that
      // are shorter than a step, would not be seen.
      if (needs_acceleration_ || joints->travel == 0) CalcRate(*wagon_, V_, state->links, state->x, &rate);
      const CornerDeflection<double> moves = CalcDeflection(*wagon_, rate, corner);
      const bool changed =
          longitudinal ? joints->Switch(link, at.dx, at.vx, moves.vx) : joints->Switch(link, at.dy, at.vy, moves.vy);
      if (!changed || !link.needs_acceleration()) return;
    }
  };
  for (std::size_t i = 0; i < kCorners; ++i) {
    settle(wagon_->longitudinal[i], &state->links.longitudinal[i], i, true);
    settle(wagon_->lateral[i], &state->links.lateral[i], i, false);
  }
}

void WagonGuards::FollowLeaves(const StateVector<double>& x) {
  if (wagon_->options.suspension != Suspension::kLeaf) return;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double v = CalcDeflection(*wagon_, x, i).vs;
    std::int8_t& travel = leaf_travel_[i];
    // An event is found to within rounding of -kLeafAtRest.
    if (travel == 0 ? std::abs(v) > kLeafAtRest : travel * v <= -0.5 * kLeafAtRest) travel = SignOf(v);
  }
}

}  // namespace uiclink
