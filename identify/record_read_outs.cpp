#include "identify/record_read_outs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLateHalfSwings = 6;  // whose centre is the rest
constexpr std::size_t kFewestForSlope = 4;
constexpr double kRollingMargin = 1.02;
constexpr double kOwnShare = 0.1;  // of the spread in time that amplitude must leave

Record CopySamples(const SymptomInput& input) {
  Record samples;
  samples.g = input.record->g;
  samples.sampling_hz = input.record->sampling_hz;
  samples.t.assign(input.t().begin(), input.t().end());
  samples.y.assign(input.modelled.begin(), input.modelled.end());
  return samples;
}

/// Slope of a straight line.
class Slope {
 public:
  void Add(double x, double y) {
    const Eigen::Vector3d v(1, x, y);
    sums_ += v * v.transpose();
  }
  double operator()() const {
    const double n = sums_(0, 0), sxx = sums_(1, 1) - sums_(0, 1) * sums_(0, 1) / n;
    if (n < kFewestForSlope || !(sxx > 0)) return kNothing;
    return (sums_(1, 2) - sums_(0, 1) * sums_(0, 2) / n) / sxx;
  }

 private:
  Eigen::Matrix3d sums_ = Eigen::Matrix3d::Zero();
};

/// Slope of y over x when what follows z is taken out of both, weighted.
class PartialSlope {
 public:
  void Add(double x, double z, double y, double weight) {
    const Eigen::Vector4d v(1, x, z, y);
    sums_ += weight * v * v.transpose();
    ++n_;
  }
  /// NaN where x and z run together, so that there is nothing to tell them by.
  double operator()() const {
    if (n_ < kFewestForSlope) return kNothing;
    const auto about_mean = [this](int i, int j) { return sums_(i, j) - sums_(0, i) * sums_(0, j) / sums_(0, 0); };
    const double zz = about_mean(2, 2), follows = zz > 0 ? about_mean(1, 2) / zz : 0;
    const double left = about_mean(1, 1) - follows * about_mean(1, 2);
    return left < kOwnShare * about_mean(1, 1) ? kNothing : (about_mean(1, 3) - follows * about_mean(2, 3)) / left;
  }

 private:
  Eigen::Matrix4d sums_ = Eigen::Matrix4d::Zero();
  std::size_t n_ = 0;
};

}  // namespace

RecordReadOuts::RecordReadOuts(const SymptomInput& input)
    : input_(&input),
      noise_{.sigma = input.sigma, .quantum = input.quantum},
      samples_(CopySamples(input)),
      modelled_(ReadSwings(samples_, noise_)),
      loss_(modelled_.half, &HalfSwing::loss),
      frequency_(modelled_.half, &HalfSwing::frequency),
      sliding_(CountSlidingTurns(modelled_.turns, input.link)),
      modelled_harmonics_(CalcHarmonicContent(input.t(), input.modelled, modelled_.turns)),
      modelled_decrement_(ReadFrictionFromDecrement(modelled_.turns, sliding_, input.link)),
      modelled_centre_(ReadFrictionFromCentre(samples_, modelled_.turns, sliding_, input.link)) {}

void RecordReadOuts::AssignRanges(const Swings& measured, double largest) {
  measured_ = measured;
  ranges_.assign(CountCommon(measured), 0);
  if (ranges_.empty()) return;
  const double rolling = kRollingMargin * modelled_.half.back().amplitude;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const double amplitude = measured.half[i].amplitude;
    if (amplitude > rolling) ranges_[i] = amplitude > std::sqrt(rolling * largest) ? 2 : 1;
  }
}

Swings RecordReadOuts::ReadTurns(std::span<const double> y) {
  samples_.y.assign(y.begin(), y.end());
  return ReadSwings(samples_, noise_);
}

RecordReadOuts::Reading RecordReadOuts::Read(std::span<const double> y) {
  Reading reading{.swings = ReadTurns(y), .values = {}};
  ReadRanges(reading.swings, &reading.values);
  ReadFriction(reading.swings, &reading.values);
  ReadMiddle(reading.swings, &reading.values);
  ReadHarmonics(reading.swings, &reading.values);
  reading.values[kFrequencyTrend] = {CalcFrequencyTrend(reading.swings), 0};
  return reading;
}

void RecordReadOuts::ReadRanges(const Swings& swings, ReadOutValues* values) const {
  std::array<ReadOutValue, kAmplitudeRanges> loss{}, frequency{};
  std::array<double, kAmplitudeRanges> n{}, weights{};
  for (std::size_t r = 0; r < kAmplitudeRanges; ++r) loss[r] = frequency[r] = {0, 0};
  for (std::size_t i = 0; i < std::min(CountCommon(swings), ranges_.size()); ++i) {
    const HalfSwing& swing = swings.half[i];
    const std::size_t r = ranges_[i];
    const double weight = swing.amplitude * swing.amplitude;  // a turn's time is known as 1/amplitude
    loss[r].measured += swing.loss, loss[r].modelled += loss_(swing.amplitude);
    frequency[r].measured += weight * swing.frequency;
    frequency[r].modelled += weight * frequency_(swing.amplitude);
    n[r] += 1, weights[r] += weight;
  }
  for (std::size_t r = 0; r < kAmplitudeRanges; ++r) {
    if (n[r] == 0) continue;
    (*values)[kLossSmall + r] = {loss[r].measured / n[r], loss[r].modelled / n[r]};
    (*values)[kFrequencySmall + r] = {frequency[r].measured / weights[r], frequency[r].modelled / weights[r]};
  }
}

void RecordReadOuts::ReadFriction(const Swings& swings, ReadOutValues* values) const {
  const Oscillator<double>& link = input_->link;
  (*values)[kFrictionDecrement] = {ReadFrictionFromDecrement(swings.turns, sliding_, link), modelled_decrement_};
  (*values)[kFrictionCentre] = {ReadFrictionFromCentre(samples_, swings.turns, sliding_, link), modelled_centre_};
  const std::size_t last = std::min(swings.turns.size(), modelled_.turns.size());
  const std::size_t first = last > kLateHalfSwings + 2 ? last - kLateHalfSwings - 2 : 0;
  if (first < sliding_) return;  // no late motion
  (*values)[kFrictionLock] = {ReadFrictionFromLock(swings.turns, first, last, input_->offset, link),
                              ReadFrictionFromLock(modelled_.turns, first, last, input_->offset, link)};
}

void RecordReadOuts::ReadMiddle(const Swings& swings, ReadOutValues* values) const {
  const std::size_t n = CountCommon(swings);
  Slope measured_t, modelled_t, measured_a, modelled_a;
  for (std::size_t i = 0; i < n; ++i) {
    const HalfSwing &model = modelled_.half[i], &swing = swings.half[i];
    const double square = model.amplitude * model.amplitude;
    measured_t.Add(model.t, swing.middle), modelled_t.Add(model.t, model.middle);
    measured_a.Add(square, swing.middle), modelled_a.Add(square, model.middle);
  }
  (*values)[kMiddleTrend] = {measured_t(), modelled_t()};
  (*values)[kMiddleAmplitude] = {measured_a(), modelled_a()};
  if (n < kLateHalfSwings) return;
  double measured = 0, modelled = 0;
  for (std::size_t i = n - kLateHalfSwings; i < n; ++i)
    measured += swings.half[i].middle, modelled += modelled_.half[i].middle;
  (*values)[kRest] = {measured / kLateHalfSwings - input_->offset, modelled / kLateHalfSwings - input_->offset};
}

void RecordReadOuts::ReadHarmonics(const Swings& swings, ReadOutValues* values) const {
  const std::array<double, 4> content = CalcHarmonicContent(samples_.t, samples_.y, swings.turns);
  for (std::size_t i = 0; i < content.size(); ++i) (*values)[kSecondCos + i] = {content[i], modelled_harmonics_[i]};
}

double RecordReadOuts::CalcFrequencyTrend(const Swings& swings) const {
  PartialSlope slope;
  for (std::size_t i = 0; i < std::min(CountCommon(swings), ranges_.size()); ++i) {
    if (ranges_[i] != 0) continue;
    const HalfSwing& swing = swings.half[i];
    slope.Add(measured_.half[i].t - measured_.half[0].t, measured_.half[i].amplitude,
              swing.frequency - frequency_(swing.amplitude), swing.amplitude * swing.amplitude);
  }
  return slope();
}

}  // namespace uiclink
