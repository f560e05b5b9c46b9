#include "identify/swing_symptoms.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/noise_draws.h"
#include "identify/record_read_outs.h"
#include "identify/rolling_decay.h"
#include "identify/significance.h"

namespace uiclink {
namespace {

constexpr int kDraws = 100;  // each standard error is known to 7 %
constexpr unsigned kSeed = 20030303;
constexpr double kMissingShare = 0.2;  // of draws in which a read-out may be missing

struct Difference {
  double measured = 0, modelled = 0, z = 0;
  double difference = 0;  // less what noise alone makes of it
  Eigen::VectorXd draws;  // of the difference, about their mean
};

/// All records, measured and drawn.
struct Readings {
  std::vector<RecordReadOuts> read_outs;
  std::vector<RecordReadOuts::Reading> measured;
  std::vector<std::vector<ReadOutValues>> drawn;  // [record][draw]
  std::vector<std::vector<HalfSwing>> errors;     // standard deviation of each half swing over the draws
  double smallest[kAmplitudeRanges] = {}, largest[kAmplitudeRanges] = {};  // measured amplitudes in a range [m]
};

/// Sums for the standard deviation of every half swing.
class HalfSwingErrors {
 public:
  void Add(std::span<const HalfSwing> drawn, const RecordReadOuts& model) {
    const std::size_t n = std::min(drawn.size(), model.modelled().half.size());
    if (squares_.size() < n) squares_.resize(n), counts_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const HalfSwing &a = drawn[i], &b = model.modelled().half[i];
      squares_[i].amplitude += Square(a.amplitude - b.amplitude);
      squares_[i].loss += Square(a.loss - model.ModelledLoss(a.amplitude));
      squares_[i].frequency += Square(a.frequency - model.ModelledFrequency(a.amplitude));
      squares_[i].middle += Square(a.middle - b.middle);
      ++counts_[i];
    }
  }
  std::vector<HalfSwing> Get() const {
    std::vector<HalfSwing> errors = squares_;
    for (std::size_t i = 0; i < errors.size(); ++i)
      for (double HalfSwing::*q : {&HalfSwing::amplitude, &HalfSwing::loss, &HalfSwing::frequency, &HalfSwing::middle})
        errors[i].*q = std::sqrt(errors[i].*q / counts_[i]);
    return errors;
  }

 private:
  static double Square(double x) { return x * x; }
  std::vector<HalfSwing> squares_;
  std::vector<double> counts_;
};

Readings ReadAll(std::span<const SymptomInput> records) {
  Readings readings;
  std::vector<Swings> measured;
  for (const SymptomInput& input : records) {
    readings.read_outs.emplace_back(input);
    measured.push_back(readings.read_outs.back().ReadTurns(input.y()));
  }
  double largest = 0;
  for (const Swings& swings : measured)
    if (!swings.half.empty()) largest = std::max(largest, swings.half[0].amplitude);
  for (std::size_t r = 0; r < records.size(); ++r) {
    readings.read_outs[r].AssignRanges(measured[r], largest);
    readings.measured.push_back(readings.read_outs[r].Read(records[r].y()));
    const std::vector<HalfSwing>& half = readings.measured[r].swings.half;
    for (std::size_t i = 0; i < std::min(half.size(), readings.read_outs[r].modelled().half.size()); ++i) {
      const std::size_t range = readings.read_outs[r].RangeOf(i);
      double &low = readings.smallest[range], &high = readings.largest[range];
      low = low > 0 ? std::min(low, half[i].amplitude) : half[i].amplitude;
      high = std::max(high, half[i].amplitude);
    }
  }
  return readings;
}

void DrawAll(std::span<const SymptomInput> records, Readings* readings) {
  NoiseDraws draws(records, kSeed);
  std::vector<HalfSwingErrors> errors(records.size());
  readings->drawn.resize(records.size());
  std::vector<double> y;
  for (int b = 0; b < kDraws; ++b) {
    const std::vector<Eigen::VectorXd>& noise = draws.Next();
    for (std::size_t r = 0; r < records.size(); ++r) {
      y.assign(records[r].modelled.begin(), records[r].modelled.end());
      for (std::size_t i = 0; i < y.size(); ++i) y[i] += noise[r][static_cast<Eigen::Index>(i)];
      const RecordReadOuts::Reading reading = readings->read_outs[r].Read(y);
      readings->drawn[r].push_back(reading.values);
      errors[r].Add(reading.swings.half, readings->read_outs[r]);
    }
  }
  for (const HalfSwingErrors& error : errors) readings->errors.push_back(error.Get());
}

/// One record's difference and its draws about their mean; nothing where it cannot be read.
std::optional<Difference> CalcDifference(const ReadOutValue& value, std::span<const ReadOutValues> drawn,
                                         std::size_t j) {
  if (!std::isfinite(value.measured - value.modelled)) return std::nullopt;
  Difference d{.measured = value.measured, .modelled = value.modelled, .draws = Eigen::VectorXd::Zero(kDraws)};
  double sum = 0, n = 0;
  for (const ReadOutValues& values : drawn)
    if (const double x = values[j].measured - values[j].modelled; std::isfinite(x)) sum += x, ++n;
  if (n < (1 - kMissingShare) * kDraws) return std::nullopt;
  for (int b = 0; b < kDraws; ++b) {
    const double x = drawn[static_cast<std::size_t>(b)][j].measured - drawn[static_cast<std::size_t>(b)][j].modelled;
    d.draws[b] = std::isfinite(x) ? x - sum / n : 0.0;
  }
  d.difference = value.measured - value.modelled - sum / n;
  if (!(d.draws.squaredNorm() > 0)) return std::nullopt;
  return d;
}

/// Mean over the records, each weighted by the inverse of its variance. The draws of records that share a link hang
/// together, so the error is that of the mean of the draws.
std::optional<Difference> Combine(const Readings& readings, std::size_t j) {
  Difference mean{.draws = Eigen::VectorXd::Zero(kDraws)};
  double weights = 0;
  for (std::size_t r = 0; r < readings.measured.size(); ++r) {
    const std::optional<Difference> d = CalcDifference(readings.measured[r].values[j], readings.drawn[r], j);
    if (!d) continue;
    const double weight = 1 / d->draws.squaredNorm();
    weights += weight;
    mean.measured += weight * d->measured, mean.modelled += weight * d->modelled;
    mean.difference += weight * d->difference, mean.draws += weight * d->draws;
  }
  if (!(weights > 0)) return std::nullopt;
  mean.measured /= weights, mean.modelled /= weights, mean.difference /= weights, mean.draws /= weights;
  mean.z = mean.difference / std::sqrt(mean.draws.squaredNorm() / (kDraws - 1));
  return mean;
}

/// "1.52 times", or what stands in its place where the model has nothing.
std::string FormatLoss(double measured, double modelled) {
  const double ratio = measured / modelled;
  if (modelled > 0 && ratio > 0.05 && ratio < 20)
    return fmt::format("loses {:.2f} times the energy that the model loses", ratio);
  return fmt::format("loses {:.2g} mJ/kN in a half cycle, the model {:.2g} mJ/kN", 1e6 * measured, 1e6 * modelled);
}

constexpr const char* kRangeNames[kAmplitudeRanges] = {"small", "medium", "large"};

void AddRanges(const Readings& readings, Symptoms* symptoms) {
  for (std::size_t i = 0; i < kAmplitudeRanges; ++i) {
    const std::string range =
        fmt::format("between {:.1f} and {:.1f} mm", 1e3 * readings.smallest[i], 1e3 * readings.largest[i]);
    if (const auto d = Combine(readings, kLossSmall + i))
      symptoms->list.push_back(
          {.id = fmt::format("loss_per_half_cycle_{}", kRangeNames[i]),
           .sentence = fmt::format("{} the record {}", range, FormatLoss(d->measured, d->modelled)),
           .measured = 1e3 * d->measured,
           .modelled = 1e3 * d->modelled,
           .unit = "J/kN",
           .z = d->z});
    if (const auto d = Combine(readings, kFrequencySmall + i))
      symptoms->list.push_back(
          {.id = fmt::format("backbone_{}", kRangeNames[i]),
           .sentence = fmt::format("{} the record swings at {:.4f} Hz, the model at the same amplitude at {:.4f} Hz "
                                   "({:+.2f} %)",
                                   range, d->measured, d->modelled, 100 * (d->measured / d->modelled - 1)),
           .measured = d->measured,
           .modelled = d->modelled,
           .unit = "Hz",
           .z = d->z});
  }
  if (const auto d = Combine(readings, kFrequencyTrend))
    symptoms->list.push_back(
        {.id = "frequency_in_time",
         .sentence = fmt::format("while the joints only roll the frequency {} by {:.2g} mHz in 10 s; the "
                                 "model's does not change",
                                 d->measured > 0 ? "rises" : "falls", 1e4 * std::abs(d->measured)),
         .measured = d->measured,
         .modelled = d->modelled,
         .unit = "Hz/s",
         .z = d->z});
}

void AddFriction(const Readings& readings, Symptoms* symptoms) {
  const struct {
    ReadOut read_out;
    const char *id, *from;
  } kinds[] = {{kFrictionDecrement, "T0_from_decrement", "the decrement at large amplitude"},
               {kFrictionLock, "T0_from_lock", "the late motion, k1 a + k |o|"},
               {kFrictionCentre, "T0_from_centre", "the shift of the sliding centre"}};
  for (const auto& kind : kinds) {
    const auto d = Combine(readings, kind.read_out);
    if (!d) continue;
    symptoms->list.push_back(
        {.id = kind.id,
         .sentence = fmt::format("read from {}, T0 is {:.5f} in the record and {:.5f} in the model "
                                 "({:+.1f} %)",
                                 kind.from, d->measured, d->modelled, 100 * (d->measured / d->modelled - 1)),
         .measured = d->measured,
         .modelled = d->modelled,
         .unit = "-",
         .z = d->z});
  }
}

/// Of the late motion of the first record that has one [s].
double CalcHalfPeriod(const Readings& readings) {
  for (const RecordReadOuts::Reading& reading : readings.measured)
    if (!reading.swings.half.empty()) return 0.5 / reading.swings.half.back().frequency;
  return 0;
}

void AddMiddle(const Readings& readings, Symptoms* symptoms) {
  if (const auto d = Combine(readings, kMiddleTrend)) {
    const double half_period = CalcHalfPeriod(readings);
    symptoms->list.push_back(
        {.id = "mid_line_in_time",
         .sentence =
             fmt::format("the mid-line moves by {:+.4f} mm in a half cycle ({:+.4f} mm/s), the model's by {:+.4f} mm",
                         1e3 * half_period * d->measured, 1e3 * d->measured, 1e3 * half_period * d->modelled),
         .measured = 1e3 * d->measured,
         .modelled = 1e3 * d->modelled,
         .unit = "mm/s",
         .z = d->z});
  }
  if (const auto d = Combine(readings, kMiddleAmplitude)) {
    double top = 0;
    for (const double amplitude : readings.largest) top = std::max(top, amplitude);
    const double square = top * top;
    symptoms->list.push_back(
        {.id = "mid_line_against_amplitude",
         .sentence = fmt::format("at {:.0f} mm the mid-line lies {:+.3f} mm from where small motions have it, the "
                                 "model's {:+.3f} mm",
                                 1e3 * top, 1e3 * square * d->measured, 1e3 * square * d->modelled),
         .measured = d->measured,
         .modelled = d->modelled,
         .unit = "1/m",
         .z = d->z});
  }
  if (const auto d = Combine(readings, kRest))
    symptoms->list.push_back({.id = "rest_off_centre",
                              .sentence = fmt::format("the late motion has its centre {:+.4f} mm from the zero of the "
                                                      "fit, the model's {:+.4f} mm",
                                                      1e3 * d->measured, 1e3 * d->modelled),
                              .measured = 1e3 * d->measured,
                              .modelled = 1e3 * d->modelled,
                              .unit = "mm",
                              .z = d->z});
}

/// A harmonic has two components; their difference from the model is a chi-square variable of two degrees of freedom.
void AddHarmonic(const Readings& readings, std::size_t cosine, const char* id, const char* name, Symptoms* symptoms) {
  const auto c = Combine(readings, cosine), s = Combine(readings, cosine + 1);
  if (!c || !s) return;
  Eigen::Matrix2d covariance;
  covariance << c->draws.squaredNorm(), c->draws.dot(s->draws), c->draws.dot(s->draws), s->draws.squaredNorm();
  covariance /= kDraws - 1;
  const Eigen::Vector2d d(c->difference, s->difference);
  const double chi2 = d.dot(covariance.ldlt().solve(d));
  const double measured = std::hypot(c->measured, s->measured), modelled = std::hypot(c->modelled, s->modelled);
  symptoms->list.push_back(
      {.id = id,
       .sentence =
           fmt::format("at its own phase the motion holds {:.3f} % of {}, the model {:.3f} %; the difference is "
                       "{:.3f} % of the amplitude",
                       100 * measured, name, 100 * modelled, 100 * d.norm()),
       .measured = 100 * measured,
       .modelled = 100 * modelled,
       .unit = "%",
       .z = CalcNormalEquivalent(CalcLogChiSquareTail(chi2, 2))});
}

std::string NameExponent(const DecayExponent& e) {
  if (!e.known) return "";
  if (e.low <= 1 && e.high < 2 && e.high >= 1) return ", as dry friction has it (1)";
  if (e.low > 1 && e.low <= 2 && e.high >= 2 && e.high < 3) return ", as viscous damping has it (2)";
  if (e.low > 2 && e.low <= 3 && e.high >= 3) return ", as quadratic drag or micro-slip has it (3)";
  if (e.high < 1) return ", below that of dry friction (1)";
  if (e.low > 1 && e.high < 2) return ", between dry friction (1) and viscous damping (2)";
  if (e.low > 2 && e.high < 3) return ", between viscous damping (2) and quadratic drag or micro-slip (3)";
  return ", which does not tell dry friction (1), viscous damping (2) and quadratic drag (3) apart";
}

void AddExponent(const Readings& readings, Symptoms* symptoms) {
  std::vector<RollingTail> tails;
  for (std::size_t r = 0; r < readings.measured.size(); ++r)
    tails.push_back(FindRollingTail(readings.measured[r].swings, readings.read_outs[r].modelled()));
  symptoms->exponent = FitDecayExponent(tails);
  const DecayExponent& e = symptoms->exponent;
  if (!(e.from > 0)) return;
  std::string sentence = fmt::format(
      "while the joints only roll, from {:.1f} to {:.1f} mm, a half cycle takes {:.4f} mm off the amplitude of the "
      "record and {:.4f} mm off that of the model",
      1e3 * e.from, 1e3 * e.to, 1e3 * e.loss, 1e3 * e.modelled_loss);
  if (e.known)
    sentence += fmt::format("; the loss of a cycle grows as amplitude^{:.2f} ({:.2f} to {:.2f}){}", e.p, e.low, e.high,
                            NameExponent(e));
  symptoms->list.push_back({.id = "rolling_loss",
                            .sentence = sentence,
                            .measured = 1e3 * e.loss,
                            .modelled = 1e3 * e.modelled_loss,
                            .unit = "mm",
                            .z = e.z});
}

/// Curves over amplitude compare at the same amplitude, curves over time at the same half swing.
void AddCurves(const Readings& readings, Symptoms* symptoms) {
  SymptomCurve envelope{"envelope", "Envelope", "time [s]", "amplitude [mm]", {}, {}, {}, {}, {}};
  SymptomCurve loss{"loss", "Energy lost per half cycle", "amplitude [mm]", "loss [J/kN]", {}, {}, {}, {}, {}};
  SymptomCurve backbone{"backbone", "Backbone", "amplitude [mm]", "frequency [Hz]", {}, {}, {}, {}, {}};
  SymptomCurve middle{"mid_line", "Mid-line", "time [s]", "reading [mm]", {}, {}, {}, {}, {}};
  const auto add = [](SymptomCurve* curve, std::size_t r, double x, double measured, double modelled, double error) {
    curve->record.push_back(static_cast<int>(r));
    curve->x.push_back(x), curve->measured.push_back(measured);
    curve->modelled.push_back(modelled), curve->error.push_back(error);
  };
  for (std::size_t r = 0; r < readings.measured.size(); ++r) {
    const RecordReadOuts& model = readings.read_outs[r];
    const std::vector<HalfSwing>& half = readings.measured[r].swings.half;
    const std::vector<HalfSwing>& errors = readings.errors[r];
    for (std::size_t i = 0; i < std::min({half.size(), model.modelled().half.size(), errors.size()}); ++i) {
      const HalfSwing &swing = half[i], &same = model.modelled().half[i], &error = errors[i];
      const double a = swing.amplitude;
      add(&envelope, r, swing.t, 1e3 * a, 1e3 * same.amplitude, 1e3 * error.amplitude);
      add(&loss, r, 1e3 * a, 1e3 * swing.loss, 1e3 * model.ModelledLoss(a), 1e3 * error.loss);
      add(&backbone, r, 1e3 * a, swing.frequency, model.ModelledFrequency(a), error.frequency);
      add(&middle, r, swing.t, 1e3 * swing.middle, 1e3 * same.middle, 1e3 * error.middle);
    }
  }
  for (SymptomCurve* curve : {&envelope, &loss, &backbone, &middle}) symptoms->curves.push_back(std::move(*curve));
}

}  // namespace

void FindSwingSymptoms(std::span<const SymptomInput> records, Symptoms* symptoms) {
  Readings readings = ReadAll(records);
  DrawAll(records, &readings);
  AddRanges(readings, symptoms);
  AddFriction(readings, symptoms);
  AddMiddle(readings, symptoms);
  AddHarmonic(readings, kSecondCos, "second_harmonic", "a second harmonic (even: one-sided)", symptoms);
  AddHarmonic(readings, kThirdCos, "third_harmonic", "a third harmonic (odd: alike on both sides)", symptoms);
  AddExponent(readings, symptoms);
  AddCurves(readings, symptoms);
}

}  // namespace uiclink
