#include "vehicle/four_integrators.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "vehicle/runge_kutta.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

// The control of the step size is ARKODE's for this pair: PI, embedded solution of order 3.
constexpr double kBias = 1.2, kSafety = 0.99;
constexpr double kProportional = 0.8 / 3, kIntegral = 0.31 / 3;
constexpr double kMostGrowth = 25, kMostGrowthAtStart = 1e4, kMostShrinkage = 0.1;
constexpr double kKeep = 1.5;  ///< a step that could grow by less stays as it is
constexpr double kShrinkAgain = 0.3;
constexpr double kFirstStep = 1e-4;  ///< as that of Integrator [s]

void Put(const StateVector<double>& from, std::size_t lane, FourStates* to) {
  for (std::size_t i = 0; i < kMaxState; ++i) (*to)[i].Set(lane, from[i]);
}
void Take(const FourStates& from, std::size_t lane, StateVector<double>* to) {
  for (std::size_t i = 0; i < kMaxState; ++i) (*to)[i] = from[i][lane];
}

/// What the step is to be multiplied by.
double CalcFactor(double log_error, double log_error_before) {
  return kSafety * std::exp(kIntegral * log_error_before - kProportional * log_error);
}

}  // namespace

void FourIntegrators::Start(std::size_t index, const Wagon& wagon, double V, const WagonState& state,
                            const IntegratorOptions& options) {
  if (!(V > 0) || !std::isfinite(V)) throw std::invalid_argument("the speed of the wagon must be positive");
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    throw std::invalid_argument("the tolerance of an integration must be positive");
  if (!options.method.empty() && options.method != kDefaultMethod)
    throw std::invalid_argument("wagons side by side know the method '" + std::string(kDefaultMethod) + "' alone");
  bool fits = CanShareLanes(wagon.options, wagon.options);
  for (const Lane& other : lanes_) fits = fits && (!other.runs || CanShareLanes(wagon.options, other.wagon->options));
  if (!fits) throw std::invalid_argument("these wagons cannot be computed side by side");

  Lane& lane = lanes_[index];
  lane.wagon = &wagon;
  lane.V = V;
  lane.largest_step =
      std::min(options.max_step, CalcStableStep(wagon, V, kClassicalRealExtent, kClassicalImaginaryExtent));
  lane.guards = WagonGuards(wagon);
  StateVector<double> weights = CalcErrorScales(wagon);
  for (double& w : weights) w = 1 / (w * options.tolerance);
  Put(weights, index, &weights_);
  four_.SetWagon(index, wagon, V);
  Begin(index, state);
}

void FourIntegrators::Restart(std::size_t index, const WagonState& state) { Begin(index, state); }

void FourIntegrators::Stop(std::size_t index) {
  lanes_[index].runs = false;
  lanes_[index].after = Lane::After::kNothing;
  lanes_change_ = true;
}

void FourIntegrators::Begin(std::size_t index, const WagonState& state) {
  Lane& lane = lanes_[index];
  lane.state = state;
  if (lane.wagon->options.suspension != Suspension::kLeaf)
    std::fill(lane.state.x.begin() + kLeafForces, lane.state.x.end(), 0.0);
  lane.begin = state.t;
  lane.h = 0;
  lane.next = kFirstStep;
  lane.log_error = 0;
  lane.most_growth = kMostGrowthAtStart;
  lane.failures = 0;
  lane.guards.Start(lane.V, &lane.state);
  lane.step_links = lane.state.links;
  CalcBegin(&lane);
  lane.after = Lane::After::kEvent;
  lanes_change_ = lanes_change_ || !lane.runs;
  lane.runs = true;
}

/// Rate and wheel loads after a start or an event.
void FourIntegrators::CalcBegin(Lane* lane) {
  WagonForces forces;
  CalcForces(*lane->wagon, lane->V, lane->state.links, lane->state.x, &lane->rate, &forces);
  ++lane->counts.rhs_calls;
  lane->loads = LoadsOf(forces);
}

/// Lanes without a run compute along: with numbers that are some wagon's.
void FourIntegrators::FillEmptyLanes() {
  lanes_change_ = false;
  const auto filled = std::ranges::find(lanes_, true, &Lane::runs);
  if (filled == lanes_.end()) return;
  for (std::size_t i = 0; i < kWagons; ++i) {
    if (lanes_[i].runs) continue;
    lanes_[i].wagon = nullptr;
    four_.SetWagon(i, *filled->wagon, filled->V);
    four_.SetLinks(i, filled->state.links);
    Put(filled->state.x, i, &x_);
    for (FourStates& k : k_) Put({}, i, &k);
    Put({}, i, &weights_);
  }
}

/// After a start or an event.
void FourIntegrators::PutState(std::size_t index) {
  const Lane& lane = lanes_[index];
  four_.SetLinks(index, lane.state.links);
  Put(lane.state.x, index, &x_);
  Put(lane.rate, index, &k_[0]);
  SetGuards(index);
}

void FourIntegrators::SetGuards(std::size_t index) {
  const Lane& lane = lanes_[index];
  const auto bound = [index](const std::array<LinkState, kCorners>& links, FourGuards::Bounds* bounds) {
    for (std::size_t i = 0; i < kCorners; ++i) {
      bounds->lower[i].Set(index, links[i].lower);
      bounds->upper[i].Set(index, links[i].upper);
      bounds->travel[i].Set(index, links[i].travel);
    }
  };
  bound(lane.state.links.longitudinal, &guards_.longitudinal);
  bound(lane.state.links.lateral, &guards_.lateral);
  guards_.longitudinal_clearance.Set(index, lane.wagon->guidance.longitudinal.clearance);
  guards_.lateral_clearance.Set(index, lane.wagon->guidance.lateral.clearance);
  guards_.stage_compression.Set(index, lane.wagon->parabolic.s0);
  // A lane that needs accelerations is always looked at closely.
  guards_.track.Set(index, lane.guards.needs_acceleration() ? -1 : lane.guards.track_limit());
  for (std::size_t i = 0; i < kCorners; ++i) {
    for (auto* sides : {&guards_.longitudinal_stop, &guards_.lateral_stop, &guards_.stage, &guards_.leaf})
      (*sides)[i].Set(index, 0);
    guards_.leaf_rest[i].Set(index, WagonGuards::kFar);
  }
  for (std::size_t i = 0; i < lane.guards.size(); ++i) {
    const WagonGuards::Guard& guard = lane.guards[i];
    const std::size_t c = guard.corner;
    const std::int8_t travel = lane.guards.leaf_travel(c);
    if (guard.kind == WagonGuards::Kind::kLongitudinalStop) guards_.longitudinal_stop[c].Set(index, guard.side);
    if (guard.kind == WagonGuards::Kind::kLateralStop) guards_.lateral_stop[c].Set(index, guard.side);
    if (guard.kind == WagonGuards::Kind::kStage) guards_.stage[c].Set(index, guard.side);
    if (guard.kind != WagonGuards::Kind::kLeafReversal) continue;
    guards_.leaf[c].Set(index, travel);
    guards_.leaf_rest[c].Set(index, travel == 0 ? 0 : WagonGuards::kLeafAtRest);  // when it starts has to be seen
  }
}

/// Takes over what the last call has made. Not before: until then the last steps can be interpolated.
void FourIntegrators::Commit() {
  Lanes share(0.0);
  for (std::size_t i = 0; i < kWagons; ++i) share.Set(i, lanes_[i].after == Lane::After::kStep ? 1 : 0);
  CopyLanes(share, x_end_, &x_);
  CopyLanes(share, k_.back(), &k_.front());
  for (std::size_t i = 0; i < kWagons; ++i) {
    if (lanes_[i].after == Lane::After::kEvent && lanes_[i].runs) PutState(i);
    lanes_[i].after = Lane::After::kNothing;
  }
}

void FourIntegrators::MakeSteps() {
  FourStates x;
  for (std::size_t stage = 1; stage < kFourStages; ++stage) {
    FourStates* const to = stage + 1 == kFourStages ? &x_end_ : &x;
    CombineStages(x_, k_, stage, h_, to);
    CalcRates(four_, *to, &k_[stage], &loads_);
  }
  CalcErrors(k_, weights_, h_, &errors_);
  CalcLeastGuards(four_, guards_, x_end_, &least_guards_);
}

FourIntegrators::Advances FourIntegrators::Step(const std::array<double, kWagons>& t_stop) {
  Commit();
  if (lanes_change_) FillEmptyLanes();
  for (std::size_t i = 0; i < kWagons; ++i) {
    Lane& lane = lanes_[i];
    const double left = lane.runs ? std::max(t_stop[i] - lane.state.t, 0.0) : 0;
    // What would leave less than a rounding is taken along.
    lane.h = lane.next * (1 + 1e-9) < left ? lane.next : left;
    h_.Set(i, lane.h);
  }
  MakeSteps();
  Advances advances;
  for (std::size_t i = 0; i < kWagons; ++i) {
    if (!lanes_[i].runs) continue;
    lanes_[i].counts.rhs_calls += kFourStages - 1;
    if (ControlStep(&lanes_[i], errors_[i])) advances[i] = EndStep(i, least_guards_[i], t_stop[i]);
    if (failed(i)) Stop(i);
  }
  return advances;
}

/// Whether the step is taken, and the size of the next.
bool FourIntegrators::ControlStep(Lane* lane, double error) {
  const double log_error = std::log(std::max(kBias * error, 1e-10));
  const double factor = CalcFactor(log_error, lane->log_error);
  if (!(error <= 1)) {
    ++lane->counts.failed_steps;
    ++lane->failures;
    // Also for an error that is no number.
    const double most = lane->failures == 1 && std::isfinite(error) ? 1 : kShrinkAgain;
    lane->next = lane->h * (factor < most ? std::max(factor, kMostShrinkage) : most);
    lane->most_growth = 1;
    return false;
  }
  const double bounded = std::clamp(factor, kMostShrinkage, lane->most_growth);
  const double wanted = bounded > 1 - 1e-6 && bounded < kKeep ? lane->h : lane->h * bounded;
  // A step that the stop time has cut short says nothing against the one that was wanted.
  lane->next = std::min(lane->h < lane->next ? std::max(wanted, lane->next) : wanted, lane->largest_step);
  lane->log_error = log_error;
  lane->most_growth = kMostGrowth;
  lane->failures = 0;
  ++lane->counts.steps;
  return true;
}

Advance FourIntegrators::EndStep(std::size_t index, double least_guard, double t_stop) {
  Lane& lane = lanes_[index];
  lane.begin = lane.state.t;
  if (!(least_guard > 0)) {
    lane.step_links = lane.state.links;
    const double share = lane.guards.Pass(LastStep(index), &lane.state);
    if (share >= 0) {
      lane.state.t = lane.begin + share * lane.h;
      lane.after = Lane::After::kEvent;
      ++lane.counts.events;
      CalcBegin(&lane);
      lane.runs = !lane.guards.derailed();
      lanes_change_ = lanes_change_ || !lane.runs;
      return lane.runs ? Advance::kEvent : Advance::kDerailed;
    }
    SetGuards(index);
  }
  Take(x_end_, index, &lane.state.x);
  lane.after = Lane::After::kStep;
  const bool stops = lane.begin + lane.h * (1 + 1e-12) >= t_stop;
  lane.state.t = stops ? t_stop : lane.begin + lane.h;
  return stops ? Advance::kStopTime : Advance::kStep;
}

HermiteStep FourIntegrators::LastStep(std::size_t index) const {
  HermiteStep step{.x0 = {}, .f0 = {}, .x1 = {}, .f1 = {}, .h = lanes_[index].h};
  Take(x_, index, &step.x0);
  Take(k_.front(), index, &step.f0);
  Take(x_end_, index, &step.x1);
  Take(k_.back(), index, &step.f1);
  return step;
}

const LinkStates& FourIntegrators::step_links(std::size_t index) const {
  const Lane& lane = lanes_[index];
  return lane.after == Lane::After::kEvent ? lane.step_links : lane.state.links;
}

WheelLoads FourIntegrators::loads(std::size_t index) const {
  WheelLoads loads = lanes_[index].loads;
  if (lanes_[index].after != Lane::After::kStep) return loads;
  for (std::size_t i = 0; i < kCorners; ++i) {
    loads.Q[i] = loads_.Q[i][index];
    loads.q[i] = loads_.q[i][index];
  }
  return loads;
}

void FourIntegrators::Interpolate(std::size_t index, double t, StateVector<double>* x) const {
  const Lane& lane = lanes_[index];
  if (t == lane.state.t) {
    *x = lane.state.x;
    return;
  }
  LastStep(index).At((t - lane.begin) / lane.h, x);
}

}  // namespace uiclink
