#include "vehicle/motion_record.h"

#include <algorithm>
#include <cmath>

#include "vehicle/spectrum_peaks.h"
#include "vehicle/turn.h"

namespace uiclink {
namespace {

/// A stop counts as touched this far beyond its clearance [m]: an event is found to about 1e-15 m.
constexpr double kTouch = 1e-12;

}  // namespace

void SlidingMaximum::See(double t, double value) {
  while (kept_.size() > first_ && kept_.back().value <= value) kept_.pop_back();
  kept_.push_back({t, value});
}

void SlidingMaximum::Forget(double before) {
  while (first_ < kept_.size() && kept_[first_].t < before) ++first_;
  if (2 * first_ < kept_.size()) return;  // moved together when half of it is waste: seldom
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(first_));
  first_ = 0;
}

double SlidingMaximum::LargestSince(double t) const {
  for (std::size_t i = first_; i < kept_.size(); ++i)
    if (kept_[i].t >= t) return kept_[i].value;
  return 0;
}

MotionRecord::MotionRecord(const Wagon& wagon, double start, double end, double window)
    : wagon_(wagon), start_(start), window_(std::min(window, end - start)) {
  ring_size_ = static_cast<std::size_t>(window_ * kSpectrumHz) + 1;
  ring_.resize(ring_size_);
  for (std::vector<Extreme>& e : extremes_) e.reserve(4096);
  for (Stop& stop : stops_) stop.begun.reserve(256);
}

MotionRecord::Point MotionRecord::CalcMotion(std::size_t motion, const StateVector<double>& x) const {
  return {x[kMotionIndex[motion]], x[kMotionIndex[motion] + 1]};
}

MotionRecord::Point MotionRecord::CalcStop(std::size_t stop,
                                           const std::array<CornerDeflection<double>, kCorners>& d) const {
  if (stop < kAxles) return {d[2 * stop].dy, d[2 * stop].vy};
  return {d[stop - kAxles].dx, d[stop - kAxles].vx};
}

double MotionRecord::ClearanceOf(std::size_t stop) const {
  return stop < kAxles ? wagon_.guidance.lateral.clearance : wagon_.guidance.longitudinal.clearance;
}

double MotionRecord::StiffnessOf(std::size_t stop) const {
  if (!wagon_.options.guidance) return 0;
  return stop < kAxles ? 2 * wagon_.guidance.lateral.k : wagon_.guidance.longitudinal.k;
}

void MotionRecord::SeeStop(std::size_t stop, double value, double t) {
  Stop& s = stops_[stop];
  const double distance = std::abs(value);
  s.used = std::max(s.used, distance);
  s.recent.See(t, distance);
  if (!(distance - ClearanceOf(stop) > kTouch) || !wagon_.options.guidance || s.touches) return;
  s.touches = true;
  ++s.contacts;
  s.begun.push_back(t);
}

void MotionRecord::LeaveStop(std::size_t stop, double value) {
  if (!(std::abs(value) - ClearanceOf(stop) > kTouch)) stops_[stop].touches = false;
}

void MotionRecord::Begin(const StateVector<double>& x) {
  t_ = start_;
  std::array<CornerDeflection<double>, kCorners> d;
  for (std::size_t i = 0; i < kCorners; ++i) d[i] = CalcDeflection(wagon_, x, i);
  for (std::size_t i = 0; i < kMotionCount; ++i) motions_[i] = CalcMotion(i, x);
  for (std::size_t i = 0; i < kStops; ++i) {
    stop_points_[i] = CalcStop(i, d);
    SeeStop(i, stop_points_[i].value, start_);
  }
  for (std::size_t i = 0; i < kMotionCount; ++i) ring_[0][i] = motions_[i].value;
  sampled_ = 1;
}

void MotionRecord::Add(const MovingWagon& wagon, const WagonState& state) {
  const double h = state.t - t_;
  std::array<CornerDeflection<double>, kCorners> d;
  for (std::size_t i = 0; i < kCorners; ++i) d[i] = CalcDeflection(wagon_, state.x, i);
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    const Point now = CalcMotion(i, state.x);
    if (const auto turn = FindTurn(h, motions_[i].value, motions_[i].rate, now.value, now.rate))
      extremes_[i].push_back({t_ + turn->share * h, turn->value});
    motions_[i] = now;
  }
  for (std::size_t i = 0; i < kStops; ++i) {
    const Point now = CalcStop(i, d);
    const Point before = stop_points_[i];
    if (const auto turn = FindTurn(h, before.value, before.rate, now.value, now.rate))
      SeeStop(i, turn->value, t_ + turn->share * h);
    SeeStop(i, now.value, state.t);
    LeaveStop(i, now.value);
    stop_points_[i] = now;
  }
  SampleStep(wagon, state.t);
  t_ = state.t;
  ForgetOld(state.t);
}

void MotionRecord::SampleStep(const MovingWagon& wagon, double t) {
  for (;;) {
    const double due = start_ + static_cast<double>(sampled_) / kSpectrumHz;
    if (due > t) return;
    StateVector<double> x;
    wagon.Interpolate(due, &x);
    for (std::size_t i = 0; i < kMotionCount; ++i) ring_[sampled_ % ring_size_][i] = x[kMotionIndex[i]];
    ++sampled_;
  }
}

/// Keeps the memory within what a window holds.
void MotionRecord::ForgetOld(double t) {
  for (std::vector<Extreme>& e : extremes_) {
    if (e.size() < e.capacity()) continue;
    std::erase_if(e, [&](const Extreme& x) { return x.t < t - window_; });
  }
  for (Stop& stop : stops_) {
    stop.recent.Forget(t - window_);
    if (stop.begun.size() == stop.begun.capacity())
      std::erase_if(stop.begun, [&](double b) { return b < t - window_; });
  }
}

std::vector<double> MotionRecord::CollectSamples(std::size_t motion) const {
  const std::size_t n = std::min(sampled_, ring_size_);
  std::vector<double> samples(n);
  for (std::size_t i = 0; i < n; ++i) samples[i] = ring_[(sampled_ - n + i) % ring_size_][motion];
  return samples;
}

MotionFigures MotionRecord::CalcFigures(std::size_t motion, double t_end) const {
  const std::vector<double> samples = CollectSamples(motion);
  auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  const double now = motions_[motion].value;  // where the run ends, between two samples
  double least = std::min(*low, now), most = std::max(*high, now);
  for (const Extreme& e : extremes_[motion]) {
    if (e.t < t_end - window_) continue;
    least = std::min(least, e.value);
    most = std::max(most, e.value);
  }
  MotionFigures figures{
      .amplitude = 0.5 * (most - least), .mean = 0.5 * (most + least), .frequencies = {}, .frequency_amplitudes = {}};
  for (const SpectrumPeak& peak : FindSpectrumPeaks(samples, kSpectrumHz, 4)) {
    figures.frequencies.push_back(peak.frequency);
    figures.frequency_amplitudes.push_back(peak.amplitude);
  }
  return figures;
}

/// The force follows from the displacement, its peak from the largest.
Impacts MotionRecord::CalcImpacts(std::size_t stop, int count, double used) const {
  const double beyond = used - ClearanceOf(stop);
  return {.count = count, .peak_N = beyond > kTouch ? StiffnessOf(stop) * beyond : 0};
}

GuidanceUse MotionRecord::CalcUse(std::size_t stop) const {
  const Stop& s = stops_[stop];
  const double since = t_ - window_;
  const double recent = s.recent.LargestSince(since);
  const auto begun = std::count_if(s.begun.begin(), s.begun.end(), [since](double t) { return t >= since; });
  return {.clearance_used = s.used,
          .impacts = CalcImpacts(stop, s.contacts, s.used),
          .clearance_used_in_window = recent,
          .impacts_in_window = CalcImpacts(stop, static_cast<int>(begun), recent)};
}

void MotionRecord::Summarise(SimulationResult* result) const {
  for (std::size_t i = 0; i < kMotionCount; ++i) result->motions[i] = CalcFigures(i, t_);
  const auto merge = [](const Impacts& part, Impacts* whole) {
    whole->count += part.count;
    whole->peak_N = std::max(whole->peak_N, part.peak_N);
  };
  for (std::size_t i = 0; i < kStops; ++i) {
    const GuidanceUse part = CalcUse(i);
    GuidanceUse& whole = i < kAxles ? result->lateral[i] : result->longitudinal[AxleOf(i - kAxles)];
    whole.clearance_used = std::max(whole.clearance_used, part.clearance_used);
    whole.clearance_used_in_window = std::max(whole.clearance_used_in_window, part.clearance_used_in_window);
    merge(part.impacts, &whole.impacts);
    merge(part.impacts_in_window, &whole.impacts_in_window);
  }
}

}  // namespace uiclink
