#include "vehicle/watched_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace uiclink {
namespace {

const std::array<const char*, kCorners> kWheelNames{"front left", "front right", "rear left", "rear right"};

std::string FormatSeconds(double t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", t);
  return text;
}

std::size_t FindLeast(const std::array<double, kCorners>& values) {
  return static_cast<std::size_t>(std::ranges::min_element(values) - values.begin());
}

}  // namespace

void CheckOptions(const SimulationOptions& options) {
  if (!(options.duration > 0) || !std::isfinite(options.duration))
    throw std::invalid_argument("the duration of a simulation must be positive");
  if (!(options.output_hz >= 0) || options.output_hz > 1e5)
    throw std::invalid_argument("the output rate must be between 0 and 100000 per second");
  if (!(options.window > 0)) throw std::invalid_argument("the window of a simulation must be positive");
  if (!(options.checkpoint_interval > 0)) throw std::invalid_argument("the time between checkpoints must be positive");
}

bool ProgressCalls::Report(double t) {
  if (!report_ || ++steps_ % 64 != 0 || Clock::now() < next_) return true;
  next_ = Clock::now() + std::chrono::milliseconds(100);
  return report_(t);
}

WatchedRun::WatchedRun(MovingWagon& wagon, const SimulationOptions& options)
    : wagon_(wagon),
      options_(options),
      start_(wagon.state().t),
      end_(start_ + options.duration),
      record_(wagon.wagon(), start_, end_, options.window),
      progress_(options.on_progress) {
  result_.V = wagon.speed();
  const double samples = std::floor(options.duration * options.output_hz * (1 + 1e-12)) + 1;
  if (options.output_hz > 0) result_.samples.reserve(static_cast<std::size_t>(samples));
  if (options.output_hz > 0 && options.output_forces) result_.forces.reserve(static_cast<std::size_t>(samples));
  sample_count_ = options.output_hz > 0 ? static_cast<std::size_t>(samples) : 0;
  checkpoint_ = FindNextCheckpoint(start_);
  record_.Begin(wagon_.state().x);
  WatchLoads();
  Sample();
}

void WatchedRun::AfterStep(Advance advance) {
  const double t = wagon_.state().t;
  WatchLoads();
  record_.Add(wagon_, lift_ ? result_.state : wagon_.state());
  Sample();
  if (advance == Advance::kDerailed) EndDerailed();
  if (advance == Advance::kStopTime && !ended_) PassStopTime(t);
  if (!ended_ && !progress_.Report(t)) End(SimulationEnd::kStopped, "stopped at " + FormatSeconds(t));
}

SimulationResult WatchedRun::Finish() {
  if (!lift_) result_.state = wagon_.state();
  if (options_.on_checkpoint && !reported_end_) options_.on_checkpoint(result_.state);
  result_.simulated = result_.state.t - start_;
  record_.Summarise(&result_);
  return std::move(result_);
}

double WatchedRun::FindNextCheckpoint(double t) const {
  const double interval = options_.checkpoint_interval;
  // A time that is one but for rounding is one.
  const double n = std::floor(t / interval * (1 + 1e-12) + 1e-9) + 1;
  return n * interval;
}

void WatchedRun::PassStopTime(double t) {
  if (t >= end_) ended_ = true;
  if (t >= checkpoint_) {
    // From here on nothing but the state counts: a resumed run does the same.
    const WagonState state = wagon_.state();
    wagon_.Restart(state);
    checkpoint_ = FindNextCheckpoint(t);
    if (options_.on_checkpoint) options_.on_checkpoint(state);
    reported_end_ = ended_;
  }
}

void WatchedRun::End(SimulationEnd end, std::string reason) {
  result_.end = end;
  result_.end_reason = std::move(reason);
  ended_ = true;
}

void WatchedRun::EndDerailed() {
  const WagonState& state = wagon_.state();
  const double front = state.x[wheelset::kY];
  const double rear = state.x[kRearWheelset + wheelset::kY];
  const bool is_front = std::abs(front) >= std::abs(rear);
  const double y = is_front ? front : rear;
  result_.derailed = true;
  End(SimulationEnd::kDerailed, std::string("the ") + (is_front ? "front" : "rear") +
                                    " wheelset left the track to the " + (y > 0 ? "left" : "right") + " at " +
                                    FormatSeconds(state.t));
}

/// Smallest wheel load, and whether a wheel is in the air.
void WatchedRun::WatchLoads() {
  const WheelLoads loads = wagon_.loads();
  const std::size_t wheel = FindLeast(loads.Q);
  if (loads.Q[wheel] < result_.minimum_wheel_load || first_look_) {
    result_.minimum_wheel_load = loads.Q[wheel];
    result_.minimum_wheel_corner = wheel;
  }
  first_look_ = false;
  if (lift_) return;
  if (loads.q[FindLeast(loads.q)] > 0) return;
  result_.wheel_lift = true;
  if (options_.end_at_wheel_lift) EndAtLift();
}

/// The moment within the last step at which the first wheel has lifted, by bisection.
void WatchedRun::EndAtLift() {
  double low = wagon_.step_begin();
  double high = wagon_.state().t;
  WagonState at = wagon_.state();
  StateVector<double> rate;
  WheelLoads loads = wagon_.loads();
  for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
    const double middle = 0.5 * (low + high);
    StateVector<double> x;
    wagon_.Interpolate(middle, &x);
    WagonForces there;
    CalcForces(wagon_.wagon(), result_.V, wagon_.step_links(), x, &rate, &there);
    const WheelLoads loads_there = LoadsOf(there);
    if (loads_there.q[FindLeast(loads_there.q)] > 0) {
      low = middle;
    } else {
      high = middle;
      at = {.t = middle, .x = x, .links = wagon_.step_links()};
      loads = loads_there;
    }
  }
  lift_ = true;
  result_.state = at;
  const std::size_t wheel = FindLeast(loads.q);
  End(SimulationEnd::kWheelLift,
      std::string("the ") + kWheelNames[wheel] + " wheel lifted off its rail at " + FormatSeconds(at.t));
}

/// All samples that are due up to the end of the last step.
void WatchedRun::Sample() {
  const double t = lift_ ? result_.state.t : wagon_.state().t;
  while (next_sample_ < sample_count_) {
    const double due = start_ + static_cast<double>(next_sample_) / options_.output_hz;
    // The last one may be a rounding beyond the end.
    if (due > t && !(t >= end_ && next_sample_ + 1 == sample_count_)) return;
    SimulationSample sample{.t = due, .x = {}};
    const double at = std::min(due, t);
    wagon_.Interpolate(at, &sample.x);
    if (options_.output_forces) {
      StateVector<double> rate;
      WagonForces forces;
      CalcForces(wagon_.wagon(), result_.V, wagon_.step_links(), sample.x, &rate, &forces);
      result_.forces.push_back(forces);
    }
    result_.samples.push_back(sample);
    ++next_sample_;
  }
}

}  // namespace uiclink
