#include "vehicle/hunting/wagon_flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "vehicle/hunting/recorded_run.h"
#include "vehicle/hunting/variation.h"
#include "vehicle/simulation.h"
#include "vehicle/turn.h"

namespace uiclink {
namespace {

using Eigen::Index;

/// A joint within this share of its limit slides, if it moves that way: rounding of places.
constexpr double kAtLimit = 1e-9;

constexpr std::size_t kWatched = kMotionCount + kAxles + kCorners;

Index At(std::size_t i) { return static_cast<Index>(i); }

struct LinkMotion {
  double d = 0, v = 0;
};

std::array<LinkMotion, kLinks> CalcLinkMotions(const Wagon& wagon, const StateVector<double>& x) {
  std::array<LinkMotion, kLinks> motions;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> at = CalcDeflection(wagon, x, i);
    motions[i] = {at.dx, at.vx};
    motions[kCorners + i] = {at.dy, at.vy};
  }
  return motions;
}

StateVector<double> MotionsOf(const Eigen::VectorXd& state, std::size_t size) {
  StateVector<double> x{};
  std::copy_n(state.data(), size, x.begin());
  return x;
}

/// How a joint stands whose spring is relaxed at p.
LinkState::Joint JointAt(const Link& link, std::size_t joint, double p, const LinkMotion& at) {
  LinkState::Joint state{.p = p, .slides = 0, .engaged = 0};
  const double side = at.d >= p ? 1 : -1;
  const double gap = link.gap(joint);
  const double stretched = std::abs(at.d - p) - gap;
  const double k = link.sliders()[joint].k;
  if (stretched <= 0 || k == 0) return state;
  state.engaged = static_cast<std::int8_t>(gap > 0 ? side : 0);
  const double along = std::max(0.0, side * at.v);
  const double sliding = link.CalcSlidingForce(joint, side, side * along) / k;
  const double breakout = link.CalcBreakoutForce(joint, side, side * along) / k;
  if (side * at.v > LinkState::kAtRest && stretched >= sliding * (1 - kAtLimit) &&
      (stretched <= sliding * (1 + kAtLimit) || stretched > breakout)) {
    state.slides = static_cast<std::int8_t>(side);
    state.p = at.d - side * (sliding + gap);
  } else if (stretched > breakout) {
    state.p = at.d - side * (breakout + gap);
  }
  return state;
}

/// Smallest and largest of what is watched, within the steps too, and how often joints slip and guides are met.
class Watch {
 public:
  Watch(const Wagon& wagon, const StateVector<double>& x) : wagon_(wagon), before_(Look(x)) {
    for (std::size_t i = 0; i < kWatched; ++i) least_[i] = greatest_[i] = before_[i].value;
  }

  void See(double h, const StateVector<double>& x) {
    const Points now = Look(x);
    for (std::size_t i = 0; i < kWatched; ++i) {
      Widen(i, now[i].value);
      if (const auto turn = FindTurn(h, before_[i].value, before_[i].rate, now[i].value, now[i].rate))
        Widen(i, turn->value);
    }
    before_ = now;
  }
  void SeeEvent(const LinkStates& before, const LinkStates& after) {
    for (std::size_t link = 0; link < kLinks; ++link) {
      for (std::size_t joint = 0; joint < LinkAt(wagon_, link).sliders().size(); ++joint) {
        const bool starts =
            LinkAt(before, link).joints[joint].slides == 0 && LinkAt(after, link).joints[joint].slides != 0;
        if (starts) ++slips_[link < kCorners ? 0 : 1];
      }
    }
  }

  void Summarise(Passage* passage) const {
    passage->least = Eigen::Map<const Eigen::VectorXd>(least_.data(), At(kWatched));
    passage->greatest = Eigen::Map<const Eigen::VectorXd>(greatest_.data(), At(kWatched));
    passage->character = fmt::format("slips {} lateral {} longitudinal", slips_[1], slips_[0]);
    if (!wagon_.options.guidance) return;
    std::string touched;
    const std::array<std::pair<const char*, bool>, 3> guides{
        {{"front", Reaches(kMotionCount, wagon_.guidance.lateral.clearance)},
         {"rear", Reaches(kMotionCount + 1, wagon_.guidance.lateral.clearance)},
         {"longitudinal", ReachesLengthwise()}}};
    for (const auto& [name, met] : guides)
      if (met) touched += fmt::format("{}{}", touched.empty() ? "" : " ", name);
    if (!touched.empty()) passage->character += ", guidance " + touched;
  }

 private:
  struct Point {
    double value = 0, rate = 0;
  };
  using Points = std::array<Point, kWatched>;

  Points Look(const StateVector<double>& x) const {
    Points points;
    for (std::size_t i = 0; i < kMotionCount; ++i) points[i] = {x[kMotionIndex[i]], x[kMotionIndex[i] + 1]};
    const std::array<LinkMotion, kLinks> links = CalcLinkMotions(wagon_, x);
    for (std::size_t axle = 0; axle < kAxles; ++axle) {
      const LinkMotion& at = links[kCorners + 2 * axle];
      points[kMotionCount + axle] = {at.d, at.v};
    }
    for (std::size_t i = 0; i < kCorners; ++i) points[kMotionCount + kAxles + i] = {links[i].d, links[i].v};
    return points;
  }
  void Widen(std::size_t i, double value) {
    least_[i] = std::min(least_[i], value);
    greatest_[i] = std::max(greatest_[i], value);
  }
  bool Reaches(std::size_t i, double clearance) const { return std::max(greatest_[i], -least_[i]) > clearance; }
  bool ReachesLengthwise() const {
    for (std::size_t i = 0; i < kCorners; ++i)
      if (Reaches(kMotionCount + kAxles + i, wagon_.guidance.longitudinal.clearance)) return true;
    return false;
  }

  const Wagon& wagon_;
  Points before_;
  std::array<double, kWatched> least_{}, greatest_{};
  std::array<int, 2> slips_{};
};

const std::vector<std::string>& WatchedNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all(kMotionNames.begin(), kMotionNames.end());
    all.insert(all.end(),
               {"front_lateral_box", "rear_lateral_box", "front_left_longitudinal_box", "front_right_longitudinal_box",
                "rear_left_longitudinal_box", "rear_right_longitudinal_box"});
    return all;
  }();
  return names;
}

}  // namespace

class WagonFlow::Impl {
 public:
  Impl(WagonFamily family, double lambda, const WagonFlowOptions& options)
      : family_(std::move(family)), options_(options) {
    Use(lambda);
  }

  /// Prepares the wagon of a value.
  const Wagon& Use(double lambda) {
    if (!wagon_ || (!family_.varies_speed && lambda != lambda_)) {
      integrator_.reset();
      wagon_ = family_.make(lambda);
      integrator_ =
          std::make_unique<Integrator>(*wagon_, IntegratorOptions{.tolerance = options_.tolerance, .method = {}});
      if (sliders_.empty()) Begin();
    }
    lambda_ = lambda;
    return *wagon_;
  }
  double SpeedAt(double lambda) const { return family_.varies_speed ? lambda : family_.speed; }

  Eigen::VectorXd FromWagonState(const WagonState& state) const {
    Eigen::VectorXd vector(scales_.size());
    vector.head(motions_) = Eigen::Map<const Eigen::VectorXd>(state.x.data(), motions_);
    const std::array<LinkMotion, kLinks> at = CalcLinkMotions(*wagon_, state.x);
    for (std::size_t i = 0; i < sliders_.size(); ++i) {
      const Link& link = LinkAt(*wagon_, sliders_[i].link);
      const LinkState& links = LinkAt(state.links, sliders_[i].link);
      const LinkState::Joint& joint = links.joints[sliders_[i].joint];
      const LinkMotion& m = at[sliders_[i].link];
      vector[motions_ + At(i)] = joint.slides == 0 ? joint.p
                                                   : links.CalcPosition(link, sliders_[i].joint, m.d, m.v) -
                                                         joint.slides * link.gap(sliders_[i].joint);
    }
    return vector;
  }

  WagonState ToWagonState(const Eigen::VectorXd& vector) const {
    WagonState state;
    state.x = MotionsOf(vector, static_cast<std::size_t>(motions_));
    const std::array<LinkMotion, kLinks> at = CalcLinkMotions(*wagon_, state.x);
    std::array<LinkState::Joint, kMaxExtendedSliders> joints;
    Index place = motions_;
    for (std::size_t i = 0; i < kLinks; ++i) {
      const Link& link = LinkAt(*wagon_, i);
      const std::size_t count = link.sliders().size();
      for (std::size_t j = 0; j < count; ++j) joints[j] = JointAt(link, j, vector[place++], at[i]);
      LinkAt(state.links, i) = LinkState::WithJoints(link, at[i].d, at[i].v, std::span(joints).first(count));
    }
    return state;
  }

  Passage Pass(const Eigen::VectorXd& start, double T, double lambda, bool derivatives) {
    const Wagon& wagon = Use(lambda);
    const double V = SpeedAt(lambda);
    if (!(T > 0) || !std::isfinite(T) || !start.allFinite() || !(V > 0))
      throw std::runtime_error("a passage needs a finite state, a period and a speed above 0");
    integrator_->Start(V, ToWagonState(start));
    start_ = integrator_->state().x;
    run_.Clear();
    run_.modes.push_back(integrator_->state().links);
    Watch watch(wagon, integrator_->state().x);
    Passage passage;
    passage.slaved_start = FindSliding(integrator_->state().links);
    Run(T, derivatives, &watch);
    watch.Summarise(&passage);
    const WagonState& end = integrator_->state();
    passage.end = FromWagonState(end);
    passage.rate = Eigen::VectorXd::Zero(scales_.size());
    passage.rate.head(motions_) = Eigen::Map<const Eigen::VectorXd>(integrator_->rate().data(), motions_);
    passage.slaved_end = FindSliding(end.links);
    const auto moves = CalcLinkMotions(wagon, end.x);
    const auto accelerates = CalcLinkMotions(wagon, integrator_->rate());
    for (const int i : passage.slaved_end) {
      const std::size_t link = PlaceOf(i).link;
      passage.rate[i] = moves[link].v - LimitSlope(i, end) * accelerates[link].v;
    }
    passage.held = FindHeld();
    for (const int i : passage.held) passage.end[i] = start[i];
    if (derivatives) Vary(lambda, &passage);
    return passage;
  }

  std::optional<Guess> GuessCycle(const WagonState& from, double lambda, double duration);

  const WagonFamily& family() const { return family_; }
  const Eigen::VectorXd& scales() const { return scales_; }
  const Wagon& wagon() const { return *wagon_; }
  std::size_t motions() const { return static_cast<std::size_t>(motions_); }
  /// Which joint's memory a component of the state is.
  const SliderPlace& PlaceOf(int component) const {
    return sliders_[static_cast<std::size_t>(component) - static_cast<std::size_t>(motions_)];
  }

 private:
  /// How the place of a joint that slides depends on the speed of its link: p = d - side L(|v|), dp = dd - L' dv [s].
  double LimitSlope(int component, const WagonState& state) const {
    const SliderPlace& place = PlaceOf(component);
    const Link& link = LinkAt(*wagon_, place.link);
    if (!link.needs_acceleration()) return 0;
    const double side = LinkAt(state.links, place.link).joints[place.joint].slides;
    return link.CalcLimitSlope(place.joint, side, CalcLinkMotions(*wagon_, state.x)[place.link].v);
  }

  /// How the place of a joint that slides depends on the parameter where the motions stay:
  /// dp = dd - L' dv - side d reach.
  double CalcPlaceSlope(int component, const ParameterSlopes& parameter) const {
    const SliderPlace& place = PlaceOf(component);
    const WagonState& state = integrator_->state();
    const double side = LinkAt(state.links, place.link).joints[place.joint].slides;
    const ParameterSlopes::Deflection moved = parameter.CalcDeflection(place.link, state.x);
    return moved.d - LimitSlope(component, state) * moved.v -
           side * parameter.CalcSlidingReach(place, side, CalcLinkMotions(*wagon_, state.x)[place.link].v);
  }

  void Begin() {
    motions_ = At(wagon_->size());
    sliders_ = ListSliders(*wagon_);
    scales_ = Eigen::VectorXd::Constant(motions_ + At(sliders_.size()), options_.unit);
    // Rates by the time scale of hunting, 1/s to 10/s: a share of the same size in all of them is one motion.
    const StateVector<double> scales = CalcErrorScales(*wagon_);
    for (Index i = kMotions; i < motions_; ++i) scales_[i] = options_.unit / 1e-3 * scales[static_cast<std::size_t>(i)];
    for (std::size_t i = 0; i < kMotions; ++i)
      if (std::string_view(kStateNames[i]).ends_with("_rate")) scales_[At(i)] = options_.unit * kHuntingRate;
    for (const std::size_t beta : {std::size_t{wheelset::kBeta}, kRearWheelset + wheelset::kBeta})
      scales_[At(beta)] = options_.unit * kHuntingRate;
  }

  void Run(double T, bool keep, Watch* watch) {
    for (;;) {
      const Advance advance = integrator_->Step(T);
      const WagonState& now = integrator_->state();
      const double begin = integrator_->step_begin();
      watch->See(now.t - begin, now.x);
      if (advance == Advance::kDerailed)
        throw std::runtime_error(
            fmt::format("the wagon derails after {:.3f} s at {:.3f} m/s", now.t, integrator_->speed()));
      if (keep && now.t > begin) {
        const StateVector<double>& x0 = run_.steps.empty() ? start_ : run_.steps.back().x1;
        run_.steps.push_back({.t0 = begin, .t1 = now.t, .x0 = x0, .x1 = now.x, .mode = run_.modes.size() - 1});
      }
      if (advance == Advance::kEvent) {
        watch->SeeEvent(run_.modes.back(), now.links);
        run_.modes.push_back(now.links);
      }
      if (advance == Advance::kStopTime) return;
    }
  }

  std::vector<int> FindSliding(const LinkStates& links) const {
    std::vector<int> sliding;
    for (std::size_t i = 0; i < sliders_.size(); ++i)
      if (LinkAt(links, sliders_[i].link).joints[sliders_[i].joint].slides != 0)
        sliding.push_back(static_cast<int>(motions_ + At(i)));
    return sliding;
  }

  /// Joints that nothing has moved in the whole run.
  std::vector<int> FindHeld() const {
    std::vector<int> held;
    for (std::size_t i = 0; i < sliders_.size(); ++i) {
      const auto joint = [&](const LinkStates& links) {
        return LinkAt(links, sliders_[i].link).joints[sliders_[i].joint];
      };
      const double p = joint(run_.modes.front()).p;
      const bool keeps = std::ranges::all_of(
          run_.modes, [&](const LinkStates& links) { return joint(links).slides == 0 && joint(links).p == p; });
      if (keeps) held.push_back(static_cast<int>(motions_ + At(i)));
    }
    return held;
  }

  void Vary(double lambda, Passage* passage);

  static constexpr double kHuntingRate = 10;  ///< [1/s]
  static constexpr double kGuessWindow =
      5;                                 ///< of amplitude and middle before a guess, two periods of slow hunting [s]
  static constexpr double kRest = 1e-7;  ///< a body that moves less does not hunt [m]

  WagonFamily family_;
  WagonFlowOptions options_;
  double lambda_ = 0;
  std::shared_ptr<const Wagon> wagon_;
  std::unique_ptr<Integrator> integrator_;
  Index motions_ = 0;
  std::vector<SliderPlace> sliders_;
  Eigen::VectorXd scales_;
  RecordedRun run_;
  StateVector<double> start_{};
};

/// Columns for what is free at the start, the rest by what it is: held memory keeps its value, slaved memory has none.
void WagonFlow::Impl::Vary(double lambda, Passage* passage) {
  const Index size = scales_.size();
  const std::vector<int> free = FreeComponents(*passage);
  const std::vector<Index> columns(free.begin(), free.end());
  std::optional<ParameterSlopes> parameter;
  if (!family_.varies_speed)
    parameter.emplace(family_.make(lambda - family_.step), family_.make(lambda + family_.step), 2 * family_.step);
  Variation variation(*wagon_, SpeedAt(lambda), scales_, parameter ? &*parameter : nullptr);
  variation.Follow(run_, Eigen::MatrixXd::Identity(size, size)(Eigen::all, columns));
  passage->by_start = Eigen::MatrixXd::Zero(size, size);
  passage->by_start(Eigen::all, columns) = variation.end();
  passage->by_parameter = variation.end_by_parameter();
  for (const int i : passage->slaved_end) {
    const Index link = At(PlaceOf(i).link);
    const Eigen::RowVectorXd follows =
        variation.deflections().row(link) - LimitSlope(i, integrator_->state()) * variation.velocities().row(link);
    passage->by_start.row(i) = follows * passage->by_start.topRows(motions_);
    passage->by_parameter[i] = follows * passage->by_parameter.head(motions_);
    if (parameter) passage->by_parameter[i] += CalcPlaceSlope(i, *parameter);
  }
  for (const int i : passage->held) passage->by_start(i, i) = 1;
}

namespace {

/// Finds the moments at which the body passes a place upwards, once it has been well below.
class UpwardPassing {
 public:
  UpwardPassing(double middle, double amplitude) : middle_(middle), below_(middle - 0.5 * amplitude) {}
  /// @return whether the place is passed between y0 and y1.
  bool See(double y0, double y1) {
    if (y1 < below_) armed_ = true;
    if (!armed_ || !(y0 < middle_ && y1 >= middle_)) return false;
    armed_ = false;
    return true;
  }

 private:
  double middle_, below_;
  bool armed_ = false;
};

constexpr std::size_t kBodyY = kBody + body::kY;

}  // namespace

std::optional<WagonFlow::Guess> WagonFlow::Impl::GuessCycle(const WagonState& from, double lambda, double duration) {
  Use(lambda);
  SimulationOptions options;
  options.duration = duration;
  options.window = std::min(duration, kGuessWindow);
  options.end_at_wheel_lift = false;
  const SimulationResult run = Simulate(*integrator_, SpeedAt(lambda), from, options);
  const MotionFigures& body = run.motions[static_cast<std::size_t>(TrackedMotion::kBodyLateral)];
  if (run.derailed || body.amplitude < kRest) return std::nullopt;

  UpwardPassing passing(body.mean, body.amplitude);
  integrator_->Start(SpeedAt(lambda), run.state);
  Guess guess;
  std::optional<double> first;
  const double end = run.state.t + 2 * kGuessWindow;
  double before = run.state.x[kBodyY];
  while (integrator_->Step(end) != Advance::kStopTime) {
    const double now = integrator_->state().x[kBodyY];
    const bool passes = passing.See(before, now);
    before = now;
    if (!passes) continue;
    const double t = integrator_->state().t;
    if (first) {
      guess.period = t - *first;
      return guess;
    }
    first = t;
    guess.state = FromWagonState(integrator_->state());
  }
  return std::nullopt;
}

WagonFlow::WagonFlow(WagonFamily family, double lambda, const WagonFlowOptions& options)
    : impl_(std::make_unique<Impl>(std::move(family), lambda, options)) {}
WagonFlow::~WagonFlow() = default;

int WagonFlow::size() const { return static_cast<int>(impl_->scales().size()); }
const Eigen::VectorXd& WagonFlow::scales() const { return impl_->scales(); }
const std::vector<std::string>& WagonFlow::watched() const { return WatchedNames(); }

Passage WagonFlow::Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) {
  return impl_->Pass(start, T, lambda, wanted == Derivatives::kAll);
}

void WagonFlow::Follow(const Eigen::VectorXd& from, const std::vector<int>& slaved, Eigen::VectorXd* state) const {
  if (slaved.empty()) return;
  const auto before = CalcLinkMotions(impl_->wagon(), MotionsOf(from, impl_->motions()));
  const auto after = CalcLinkMotions(impl_->wagon(), MotionsOf(*state, impl_->motions()));
  for (const int i : slaved) {
    const SliderPlace& place = impl_->PlaceOf(i);
    const Link& link = LinkAt(impl_->wagon(), place.link);
    const LinkMotion &was = before[place.link], &is = after[place.link];
    const double side = was.d >= from[i] ? 1 : -1;
    const auto limit = [&](double v) {
      return link.CalcSlidingForce(place.joint, side, side * std::max(0.0, side * v)) / link.sliders()[place.joint].k;
    };
    (*state)[i] = from[i] + (is.d - was.d) - side * (limit(is.v) - limit(was.v));
  }
}

const WagonFamily& WagonFlow::family() const { return impl_->family(); }
double WagonFlow::SpeedAt(double lambda) const { return impl_->SpeedAt(lambda); }
const Wagon& WagonFlow::WagonAt(double lambda) { return impl_->Use(lambda); }
Eigen::VectorXd WagonFlow::FromWagonState(const WagonState& state) const { return impl_->FromWagonState(state); }
WagonState WagonFlow::ToWagonState(const Eigen::VectorXd& state, double lambda) {
  impl_->Use(lambda);
  return impl_->ToWagonState(state);
}

Eigen::VectorXcd WagonFlow::FromMode(const LinearMode& mode) const {
  Eigen::VectorXcd vector = Eigen::VectorXcd::Zero(impl_->scales().size());
  for (std::size_t i = 0; i < impl_->motions(); ++i) vector[At(i)] = mode.shape[i];
  return vector;
}

std::optional<WagonFlow::Guess> WagonFlow::GuessCycle(const WagonState& from, double lambda, double duration) {
  return impl_->GuessCycle(from, lambda, duration);
}

WagonFamily FamilyBySpeed(const Wagon& wagon) {
  const auto copy = std::make_shared<const Wagon>(wagon);
  return {.make = [copy](double) { return copy; }};
}

}  // namespace uiclink
