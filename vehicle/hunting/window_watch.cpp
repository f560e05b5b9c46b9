#include "vehicle/hunting/window_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vehicle/turn.h"

namespace uiclink {
namespace {

/// A stop counts as touched this far beyond its clearance [m]: an event is found to about 1e-15 m.
constexpr double kTouch = 1e-12;

}  // namespace

void WindowWatch::Begin(const Integrator& integrator) {
  t_ = integrator.state().t;
  x_ = integrator.state().x;
  for (std::size_t i = 0; i < kMotionCount; ++i) least_[i] = greatest_[i] = x_[kMotionIndex[i]];
  stops_ = {};
  WatchStops(0, x_);
  minimum_wheel_load_ = std::numeric_limits<double>::infinity();
  wheel_lift_ = false;
}

void WindowWatch::Add(const Integrator& integrator) {
  const WagonState& now = integrator.state();
  const double h = now.t - t_;
  WatchMotions(h, now.x);
  WatchStops(h, now.x);
  for (const WagonForces::Wheel& wheel : integrator.forces().wheels) {
    minimum_wheel_load_ = std::min(minimum_wheel_load_, wheel.Q);
    wheel_lift_ = wheel_lift_ || wheel.q <= 0;
  }
  t_ = now.t;
  x_ = now.x;
}

void WindowWatch::WatchMotions(double h, const StateVector<double>& x) {
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    const std::size_t at = kMotionIndex[i];
    const auto see = [&](double value) {
      least_[i] = std::min(least_[i], value);
      greatest_[i] = std::max(greatest_[i], value);
    };
    if (const auto turn = FindTurn(h, x_[at], x_[at + 1], x[at], x[at + 1])) see(turn->value);
    see(x[at]);
  }
}

void WindowWatch::WatchStops(double h, const StateVector<double>& x) {
  for (std::size_t i = 0; i < kStops; ++i) {
    const CornerDeflection<double> d = CalcDeflection(*wagon_, x, i < kAxles ? 2 * i : i - kAxles);
    const double value = i < kAxles ? d.dy : d.dx;
    const double rate = i < kAxles ? d.vy : d.vx;
    Stop& stop = stops_[i];
    if (h > 0) {
      if (const auto turn = FindTurn(h, stop.value, stop.rate, value, rate)) SeeStop(i, turn->value);
    }
    SeeStop(i, value);
    if (!(std::abs(value) - ClearanceOf(i) > kTouch)) stop.touches = false;
    stop.value = value;
    stop.rate = rate;
  }
}

void WindowWatch::SeeStop(std::size_t i, double value) {
  Stop& stop = stops_[i];
  stop.used = std::max(stop.used, std::abs(value));
  if (stop.touches || !wagon_->options.guidance || !(std::abs(value) - ClearanceOf(i) > kTouch)) return;
  stop.touches = true;
  ++stop.contacts;
}

double WindowWatch::ClearanceOf(std::size_t stop) const {
  return stop < kAxles ? wagon_->guidance.lateral.clearance : wagon_->guidance.longitudinal.clearance;
}

double WindowWatch::StiffnessOf(std::size_t stop) const {
  if (!wagon_->options.guidance) return 0;
  return stop < kAxles ? 2 * wagon_->guidance.lateral.k : wagon_->guidance.longitudinal.k;
}

GuidanceUse WindowWatch::CalcUse(std::size_t i) const {
  const Stop& stop = stops_[i];
  GuidanceUse use;
  use.clearance_used = stop.used;
  use.impacts = {.count = stop.contacts, .peak_N = StiffnessOf(i) * std::max(stop.used - ClearanceOf(i), 0.0)};
  return use;
}

GuidanceUse WindowWatch::Lateral(Axle axle) const { return CalcUse(static_cast<std::size_t>(axle)); }

GuidanceUse WindowWatch::Longitudinal(Axle axle) const {
  const std::size_t left = kAxles + 2 * static_cast<std::size_t>(axle);
  GuidanceUse use = CalcUse(left);
  const GuidanceUse right = CalcUse(left + 1);
  use.clearance_used = std::max(use.clearance_used, right.clearance_used);
  use.impacts.count += right.impacts.count;
  use.impacts.peak_N = std::max(use.impacts.peak_N, right.impacts.peak_N);
  return use;
}

std::array<double, kMotionCount> WindowWatch::CalcLargest() const {
  std::array<double, kMotionCount> largest{};
  for (std::size_t i = 0; i < kMotionCount; ++i) largest[i] = std::max(-least_[i], greatest_[i]);
  return largest;
}

std::array<double, kMotionCount> WindowWatch::CalcHalfWidths() const {
  std::array<double, kMotionCount> widths{};
  for (std::size_t i = 0; i < kMotionCount; ++i) widths[i] = 0.5 * (greatest_[i] - least_[i]);
  return widths;
}

std::array<double, kMotionCount> WindowWatch::CalcMiddles() const {
  std::array<double, kMotionCount> middles{};
  for (std::size_t i = 0; i < kMotionCount; ++i) middles[i] = 0.5 * (greatest_[i] + least_[i]);
  return middles;
}

}  // namespace uiclink
