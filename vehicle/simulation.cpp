#include "vehicle/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "vehicle/motion_record.h"

namespace uiclink {

const std::array<const char*, kMotionCount> kMotionNames{"front_lateral",      "rear_lateral",      "body_lateral",
                                                         "front_longitudinal", "rear_longitudinal", "body_yaw",
                                                         "body_roll"};

const std::array<std::size_t, kMotionCount> kMotionIndex{
    wheelset::kY,      kRearWheelset + wheelset::kY, kBody + body::kY,
    wheelset::kX,      kRearWheelset + wheelset::kX, kBody + body::kPsi,
    kBody + body::kPhi};

namespace {

using Clock = std::chrono::steady_clock;

const std::array<const char*, kCorners> kWheelNames{"front left", "front right", "rear left", "rear right"};

std::string FormatSeconds(double t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", t);
  return text;
}

/// Calls on_progress about ten times per second, and looks at the clock only now and then.
class Progress {
 public:
  explicit Progress(const std::function<bool(double)>& report) : report_(report) {}

  /// False when the run is to stop.
  bool Report(double t) {
    if (!report_ || ++steps_ % 64 != 0 || Clock::now() < next_) return true;
    next_ = Clock::now() + std::chrono::milliseconds(100);
    return report_(t);
  }

 private:
  const std::function<bool(double)>& report_;
  long steps_ = 0;
  Clock::time_point next_ = Clock::now();
};

void CheckOptions(const SimulationOptions& options) {
  if (!(options.duration > 0) || !std::isfinite(options.duration))
    throw std::invalid_argument("the duration of a simulation must be positive");
  if (!(options.output_hz >= 0) || options.output_hz > 1e5)
    throw std::invalid_argument("the output rate must be between 0 and 100000 per second");
  if (!(options.window > 0)) throw std::invalid_argument("the window of a simulation must be positive");
  if (!(options.checkpoint_interval > 0)) throw std::invalid_argument("the time between checkpoints must be positive");
}

class Run {
 public:
  Run(Integrator& integrator, double V, const WagonState& start, const SimulationOptions& options)
      : integrator_(integrator),
        wagon_(integrator.wagon()),
        options_(options),
        start_(start.t),
        end_(start.t + options.duration),
        record_(wagon_, start.t, end_, options.window) {
    result_.V = V;
    const double samples = std::floor(options.duration * options.output_hz * (1 + 1e-12)) + 1;
    if (options.output_hz > 0) result_.samples.reserve(static_cast<std::size_t>(samples));
    if (options.output_hz > 0 && options.output_forces) result_.forces.reserve(static_cast<std::size_t>(samples));
    sample_count_ = options.output_hz > 0 ? static_cast<std::size_t>(samples) : 0;
    integrator_.Start(V, start);
    checkpoint_ = FindNextCheckpoint(start.t);
    record_.Begin(integrator_.state().x);
    WatchLoads();
    Sample();
  }

  SimulationResult Finish(Progress progress) {
    while (!ended_) {
      const Advance advance = integrator_.Step(std::min(checkpoint_, end_));
      const double t = integrator_.state().t;
      WatchLoads();
      record_.Add(integrator_, lift_ ? result_.state : integrator_.state());
      Sample();
      if (advance == Advance::kDerailed) EndDerailed();
      if (advance == Advance::kStopTime && !ended_) PassStopTime(t);
      if (!ended_ && !progress.Report(t)) End(SimulationEnd::kStopped, "stopped at " + FormatSeconds(t));
    }
    if (!lift_) result_.state = integrator_.state();
    if (options_.on_checkpoint && !reported_end_) options_.on_checkpoint(result_.state);
    result_.simulated = result_.state.t - start_;
    record_.Summarise(&result_);
    return std::move(result_);
  }

 private:
  double FindNextCheckpoint(double t) const {
    const double interval = options_.checkpoint_interval;
    // A time that is one but for rounding is one.
    const double n = std::floor(t / interval * (1 + 1e-12) + 1e-9) + 1;
    return n * interval;
  }

  void PassStopTime(double t) {
    if (t >= end_) ended_ = true;
    if (t >= checkpoint_) {
      // From here on nothing but the state counts: a resumed run does the same.
      const WagonState state = integrator_.state();
      integrator_.Start(result_.V, state);
      checkpoint_ = FindNextCheckpoint(t);
      if (options_.on_checkpoint) options_.on_checkpoint(state);
      reported_end_ = ended_;
    }
  }

  void End(SimulationEnd end, std::string reason) {
    result_.end = end;
    result_.end_reason = std::move(reason);
    ended_ = true;
  }

  void EndDerailed() {
    const WagonState& state = integrator_.state();
    const double front = state.x[wheelset::kY];
    const double rear = state.x[kRearWheelset + wheelset::kY];
    const bool is_front = std::abs(front) >= std::abs(rear);
    const double y = is_front ? front : rear;
    result_.derailed = true;
    End(SimulationEnd::kDerailed, std::string("the ") + (is_front ? "front" : "rear") +
                                      " wheelset left the track to the " + (y > 0 ? "left" : "right") + " at " +
                                      FormatSeconds(state.t));
  }

  static std::size_t FindLeast(const WagonForces& forces, double WagonForces::Wheel::*quantity) {
    const auto least = std::min_element(
        forces.wheels.begin(), forces.wheels.end(),
        [quantity](const WagonForces::Wheel& a, const WagonForces::Wheel& b) { return a.*quantity < b.*quantity; });
    return static_cast<std::size_t>(least - forces.wheels.begin());
  }

  /// Smallest wheel load, and whether a wheel is in the air.
  void WatchLoads() {
    const WagonForces& forces = integrator_.forces();
    const std::size_t wheel = FindLeast(forces, &WagonForces::Wheel::Q);
    if (forces.wheels[wheel].Q < result_.minimum_wheel_load || first_look_) {
      result_.minimum_wheel_load = forces.wheels[wheel].Q;
      result_.minimum_wheel_corner = wheel;
    }
    first_look_ = false;
    if (lift_) return;
    const std::size_t least = FindLeast(forces, &WagonForces::Wheel::q);
    if (forces.wheels[least].q > 0) return;
    result_.wheel_lift = true;
    if (options_.end_at_wheel_lift) EndAtLift();
  }

  /// The moment within the last step at which the first wheel has lifted, by bisection.
  void EndAtLift() {
    double low = integrator_.step_begin();
    double high = integrator_.state().t;
    WagonState at = integrator_.state();
    StateVector<double> rate;
    WagonForces forces = integrator_.forces();
    for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
      const double middle = 0.5 * (low + high);
      StateVector<double> x;
      integrator_.Interpolate(middle, &x);
      WagonForces there;
      CalcForces(wagon_, result_.V, integrator_.step_links(), x, &rate, &there);
      if (there.wheels[FindLeast(there, &WagonForces::Wheel::q)].q > 0) {
        low = middle;
      } else {
        high = middle;
        at = {.t = middle, .x = x, .links = integrator_.step_links()};
        forces = there;
      }
    }
    lift_ = true;
    result_.state = at;
    const std::size_t wheel = FindLeast(forces, &WagonForces::Wheel::q);
    End(SimulationEnd::kWheelLift,
        std::string("the ") + kWheelNames[wheel] + " wheel lifted off its rail at " + FormatSeconds(at.t));
  }

  /// All samples that are due up to the end of the last step.
  void Sample() {
    const double t = lift_ ? result_.state.t : integrator_.state().t;
    while (next_sample_ < sample_count_) {
      const double due = start_ + static_cast<double>(next_sample_) / options_.output_hz;
      // The last one may be a rounding beyond the end.
      if (due > t && !(t >= end_ && next_sample_ + 1 == sample_count_)) return;
      SimulationSample sample{.t = due, .x = {}};
      const double at = std::min(due, t);
      integrator_.Interpolate(at, &sample.x);
      if (options_.output_forces) {
        StateVector<double> rate;
        WagonForces forces;
        CalcForces(wagon_, result_.V, integrator_.step_links(), sample.x, &rate, &forces);
        result_.forces.push_back(forces);
      }
      result_.samples.push_back(sample);
      ++next_sample_;
    }
  }

  Integrator& integrator_;
  const Wagon& wagon_;
  const SimulationOptions& options_;
  double start_, end_;
  MotionRecord record_;
  SimulationResult result_;
  double checkpoint_ = 0;
  std::size_t sample_count_ = 0, next_sample_ = 0;
  bool first_look_ = true;
  bool ended_ = false, lift_ = false, reported_end_ = false;
};

}  // namespace

SimulationResult Simulate(Integrator& integrator, double V, const WagonState& start, const SimulationOptions& options) {
  CheckOptions(options);
  const auto begin = Clock::now();
  const IntegratorCounts before = integrator.counts();
  Run run(integrator, V, start, options);
  SimulationResult result = run.Finish(Progress(options.on_progress));
  const IntegratorCounts& after = integrator.counts();
  result.counts = {.steps = after.steps - before.steps,
                   .rhs_calls = after.rhs_calls - before.rhs_calls,
                   .failed_steps = after.failed_steps - before.failed_steps,
                   .events = after.events - before.events};
  result.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

SimulationResult Simulate(const Wagon& wagon, double V, const WagonState& start, const SimulationOptions& options) {
  Integrator integrator(wagon, options.integrator);
  return Simulate(integrator, V, start, options);
}

WagonState Perturb(const Wagon& wagon, const WagonState& state, const Perturbation& by) {
  WagonState moved = state;
  StateVector<double>& x = moved.x;
  const auto pose = [&](double y) {
    const ContactCurve::Place place = wagon.contact.Find(y);
    return ContactCurve::Evaluate(wagon.contact.pose_cubic(place.cell), place.t);
  };
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    double* w = &x[axle * wheelset::kSize];
    const KinematicPose<double> before = pose(w[wheelset::kY]);
    w[wheelset::kY] += axle == 0 ? by.front_y : by.rear_y;
    w[wheelset::kPsi] += axle == 0 ? by.front_psi : by.rear_psi;
    const KinematicPose<double> after = pose(w[wheelset::kY]);
    w[wheelset::kZ] += after.z - before.z;
    w[wheelset::kPhi] += after.phi - before.phi;
  }
  x[kBody + body::kY] += by.body_y;
  x[kBody + body::kPhi] += by.body_phi;
  x[kBody + body::kPsi] += by.body_psi;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
    moved.links.longitudinal[i].Switch(wagon.longitudinal[i], d.dx, d.vx, 0);
    moved.links.lateral[i].Switch(wagon.lateral[i], d.dy, d.vy, 0);
  }
  return moved;
}

}  // namespace uiclink
