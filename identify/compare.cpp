#include "identify/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <utility>

#include "data/checksum.h"
#include "data/file.h"
#include "identify/compare_effects.h"
#include "identify/extended_fit.h"
#include "identify/noise.h"
#include "identify/release.h"
#include "identify/start_values.h"
#include "model/closed_form.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr double kStandardAmplitudes[] = {0.002, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030};  // [m]
constexpr std::size_t kBins = 8;  // of the measured amplitudes
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A record and what can be said about it without a model.
struct Measured {
  Record record;
  Noise noise;
  Phases phases;
};

// ---------------------------------------------------------------- the sets

std::vector<ComparedSet> DescribeSets(const std::vector<std::string>& files, const std::vector<ParameterSet>& sets) {
  std::set<std::string> names;
  for (const ParameterSet& set : sets) names.insert(set.name);
  const bool distinct = names.size() == sets.size() && !names.contains("");
  std::vector<ComparedSet> described;
  for (std::size_t i = 0; i < sets.size(); ++i)
    described.push_back({.file = files[i],
                         .label = distinct ? sets[i].name : files[i],
                         .source = sets[i].source,
                         .g = sets[i].g,
                         .load_N = sets[i].load_N});
  return described;
}

/// Why a set is not simulated; empty if it is.
std::string FindObstacle(const std::optional<DirectionParameters>& parameters, Direction direction) {
  if (!parameters)
    return fmt::format("expected a table [{0}], found none: not simulated in {0} direction", Name(direction));
  if (parameters->sliders.size() > kMaxFittedSliders)
    return fmt::format("expected at most {} sliders, found {}: the {} parameters are listed only", kMaxFittedSliders,
                       parameters->sliders.size(), Name(direction));
  return "";
}

/// By set; those that cannot be simulated are empty.
std::vector<SetModel> MakeModels(const std::vector<ComparedSet>& sets, const Comparison& comparison) {
  std::vector<SetModel> models(sets.size());
  for (std::size_t s = 0; s < sets.size(); ++s)
    if (comparison.why_not[s].empty())
      models[s] = MakeSetModel(comparison.parameters[s], sets[s].g, comparison.direction, sets[s].file);
  return models;
}

/// The link in the coordinates of a fit, which have logarithms of everything. A slider without friction exerts no force
/// and is left out; if none is left, one of 1e-7 of the load stands in, which takes 0.1 um of amplitude in a cycle.
FitState StateOf(const Oscillator<double>& link, const Phases& phases) {
  Oscillator<double> positive;
  positive.k = link.k;
  for (const Slider<double>& slider : link.sliders())
    if (slider.T0 > 0) positive.Add(slider);
  if (positive.size() == 0) positive.Add({.k = 1e-3, .T0 = 1e-7});
  FitState state;
  state.levels.resize(1);
  FromOscillator(positive, state.levels.data(), &state.shape);
  const Extremum& first = phases.extrema.front();
  state.starts = {{first.y - phases.centre, first.t, phases.centre}};
  return state;
}

// ---------------------------------------------------------------- cycles

/// The cycle that starts at amplitude A. Frequency and loss are NaN where the mass stops before the other side.
Cycle CycleFrom(const Oscillator<double>& link, double A) {
  const HalfCycle first = CalcHalfCycle(link, A);
  if (!(first.next_amplitude > 0)) return {.amplitude = A / 4, .frequency = kNan, .loss = kNan};
  const HalfCycle second = CalcHalfCycle(link, first.next_amplitude);
  const double end = second.next_amplitude;
  if (!(end > 0)) return {.amplitude = (A + 2 * first.next_amplitude) / 4, .frequency = kNan, .loss = kNan};
  return {.amplitude = (A + 2 * first.next_amplitude + end) / 4,
          .frequency = 1 / (first.duration + second.duration),
          .loss = (A - end) / 2};
}

/// The cycle of the given mean amplitude: its start is bisected, since the mean rises with the start.
Cycle CycleAbout(const Oscillator<double>& link, double amplitude) {
  double low = 0.5 * amplitude, high = amplitude;
  while (CycleFrom(link, high).amplitude < amplitude) high *= 2;
  for (int i = 0; i < 50; ++i) {  // to rounding: 2^-50
    const double middle = 0.5 * (low + high);
    (CycleFrom(link, middle).amplitude < amplitude ? low : high) = middle;
  }
  return CycleFrom(link, high);
}

/// The cycle of one set about an amplitude: in closed form for the plain model, otherwise from simulated decays.
using CycleOfSet = std::function<Cycle(double amplitude)>;

std::vector<CycleOfSet> MakeCycles(const std::vector<SetModel>& models, double largest) {
  std::vector<CycleOfSet> cycles;
  for (const SetModel& model : models) {
    if (!model.simulated) {
      cycles.emplace_back([](double) { return Cycle{.frequency = kNan, .loss = kNan}; });
    } else if (model.IsPlain()) {
      cycles.emplace_back([link = model.link](double amplitude) { return CycleAbout(link, amplitude); });
    } else {
      cycles.emplace_back([table = CycleTable(model, largest)](double amplitude) { return table.About(amplitude); });
    }
  }
  return cycles;
}

/// Measured cycles in bins of equal width of the amplitude, beside the sets' cycles at the same amplitudes.
std::vector<AmplitudePoint> BinCycles(std::vector<Cycle> cycles, const std::vector<SetModel>& models) {
  if (cycles.empty()) return {};
  std::sort(cycles.begin(), cycles.end(), [](const Cycle& l, const Cycle& r) { return l.amplitude > r.amplitude; });
  const double top = cycles.front().amplitude, width = (top - cycles.back().amplitude) / kBins;
  const std::vector<CycleOfSet> of_set = MakeCycles(models, top);
  std::vector<AmplitudePoint> bins(kBins);
  for (AmplitudePoint& bin : bins) bin.frequency = bin.loss = std::vector<double>(models.size(), 0.0);
  for (const Cycle& cycle : cycles) {
    const double place = width > 0 ? (top - cycle.amplitude) / width : 0;
    AmplitudePoint& bin = bins[std::min(kBins - 1, static_cast<std::size_t>(place))];
    ++bin.cycles;
    bin.amplitude += cycle.amplitude;
    bin.measured_frequency += cycle.frequency;
    bin.measured_loss += cycle.loss;
    for (std::size_t s = 0; s < models.size(); ++s) {
      const Cycle model = of_set[s](cycle.amplitude);
      bin.frequency[s] += model.frequency;
      bin.loss[s] += model.loss;
    }
  }
  std::erase_if(bins, [](const AmplitudePoint& bin) { return bin.cycles == 0; });
  for (AmplitudePoint& bin : bins) {
    const double n = bin.cycles;
    for (double* value : {&bin.amplitude, &bin.measured_frequency, &bin.measured_loss}) *value /= n;
    for (std::size_t s = 0; s < models.size(); ++s) bin.frequency[s] /= n, bin.loss[s] /= n;
  }
  return bins;
}

std::vector<BackbonePoint> CalcBackbone(const std::vector<SetModel>& models) {
  std::vector<BackbonePoint> points;
  for (const double amplitude : kStandardAmplitudes) {
    BackbonePoint point{.amplitude = amplitude, .frequency = {}, .loss = {}};
    for (const SetModel& model : models) {
      point.frequency.push_back(!model.simulated  ? kNan
                                : model.IsPlain() ? CalcFrequency(model.link, amplitude)
                                                  : CalcExtendedFrequency(model, amplitude));
      point.loss.push_back(!model.simulated  ? kNan
                           : model.IsPlain() ? CalcLossPerCycle(model.link, amplitude)
                                             : CalcExtendedLoss(model, amplitude));
    }
    points.push_back(point);
  }
  return points;
}

// ---------------------------------------------------------------- the records

/// Takes the records of one direction out of `records`; those without a usable free decay go to left_out.
std::vector<Measured> Measure(std::vector<Record>* records, Comparison* comparison) {
  std::vector<Measured> measured;
  for (Record& record : *records) {
    if (record.direction != comparison->direction) continue;
    Measured m{.record = std::exchange(record, {}), .noise = {}, .phases = {}};
    m.noise = EstimateNoise(m.record.t, m.record.y, m.record.uncertainty);
    m.phases = FindPhases(m.record, m.noise);
    if (m.phases.usable) {
      measured.push_back(std::move(m));
    } else {
      comparison->left_out.push_back({m.record.file, m.phases.reason});
    }
  }
  return measured;
}

SetOnRecord DescribeStart(const FitData& data, double chi2, const Start& start, bool converged) {
  return {.used = true,
          .rms = data.sigma * std::sqrt(chi2 / static_cast<double>(data.size)),
          .start = start,
          .converged = converged};
}

/// What effects need of each record (amplitudes, phases, drifts) is fitted with its start.
SetOnRecord FitExtendedStart(const Measured& measured, const SetModel& model, const FitData& data) {
  ExtendedState plain{.link = StateOf(model.link, measured.phases), .shared = {}, .own = {}};
  ExtendedState state = Convert(Extension(), plain, model.extension);
  state.shared = model.shared;
  ExtendedControl control;
  control.window_s = GrowingWindows(measured.phases);
  control.fix_link = control.fix_shared = true;
  control.function_tolerance = 1e-9;  // as FitControl
  const ExtendedOutcome outcome = FitExtended({&data, 1}, Sharing::kLink, model.extension, state, control);
  return DescribeStart(data, outcome.chi2, outcome.state.link.starts[0], outcome.converged);
}

/// Fits the start of the record with the link held, through growing windows: the phase error of a wrong link grows with
/// time, and a fit of the whole record at once may end a period off.
SetOnRecord FitStart(const Measured& measured, const SetModel& model) {
  FitData data = MakeFitData(measured.record, measured.noise, measured.phases);
  data.g = model.link.g;
  if (!model.IsPlain()) return FitExtendedStart(measured, model, data);
  FitControl control;
  control.window_s = GrowingWindows(measured.phases);
  control.fix_link = true;
  const FitOutcome outcome = Fit({&data, 1}, Sharing::kLink, StateOf(model.link, measured.phases), control);
  return DescribeStart(data, outcome.chi2, outcome.state.starts[0], outcome.converged);
}

void FitStarts(const std::vector<Measured>& measured, const std::vector<SetModel>& models, Comparison* comparison) {
  for (const Measured& m : measured)
    comparison->records.push_back({.file = m.record.file,
                                   .samples = MakeFitData(m.record, m.noise, m.phases).size,
                                   .noise = m.noise.sigma,
                                   .results = std::vector<SetOnRecord>(models.size())});
  ParallelFor(measured.size() * models.size(), 0, [&](std::size_t i) {
    const std::size_t r = i / models.size(), s = i % models.size();
    if (models[s].simulated) comparison->records[r].results[s] = FitStart(measured[r], models[s]);
  });
}

void Summarise(Comparison* comparison) {
  double samples = 0;
  comparison->overall.assign(comparison->parameters.size(), {});
  for (const ComparedRecord& record : comparison->records) {
    const auto n = static_cast<double>(record.samples);
    samples += n;
    comparison->noise += n * record.noise * record.noise;
    for (std::size_t s = 0; s < record.results.size(); ++s)
      comparison->overall[s].rms += n * record.results[s].rms * record.results[s].rms;
  }
  if (samples == 0) return;
  comparison->noise = std::sqrt(comparison->noise / samples);
  for (std::size_t s = 0; s < comparison->overall.size(); ++s) {
    SetOnRecord& overall = comparison->overall[s];
    overall.used = comparison->why_not[s].empty();
    overall.converged = overall.used && std::all_of(comparison->records.begin(), comparison->records.end(),
                                                    [&](const auto& record) { return record.results[s].converged; });
    overall.rms = std::sqrt(overall.rms / samples);
  }
}

Comparison CompareDirection(Direction direction, const std::vector<ParameterSet>& sets,
                            const std::vector<ComparedSet>& described, std::vector<Record>* records) {
  Comparison comparison;
  comparison.direction = direction;
  for (const ParameterSet& set : sets) {
    comparison.parameters.push_back(set[direction].value_or(DirectionParameters{}));
    comparison.why_not.push_back(FindObstacle(set[direction], direction));
  }
  const std::vector<SetModel> models = MakeModels(described, comparison);
  comparison.backbone = CalcBackbone(models);
  const std::vector<Measured> measured = Measure(records, &comparison);
  FitStarts(measured, models, &comparison);
  Summarise(&comparison);
  std::vector<Cycle> cycles;
  for (const Measured& m : measured)
    for (const Cycle& cycle : FindCycles(m.phases.extrema)) cycles.push_back(cycle);
  comparison.points = BinCycles(std::move(cycles), models);
  return comparison;
}

}  // namespace

int Comparison::FindBest() const {
  int best = -1, simulated = 0;
  for (std::size_t s = 0; s < overall.size(); ++s) {
    if (!overall[s].used) continue;
    ++simulated;
    if (best < 0 || overall[s].rms < overall[static_cast<std::size_t>(best)].rms) best = static_cast<int>(s);
  }
  return simulated > 1 ? best : -1;
}

int CompareResult::CountUsed() const {
  std::size_t used = 0;
  for (const Comparison& comparison : comparisons) used += comparison.records.size();
  return static_cast<int>(used);
}

int CompareResult::CountLeftOut() const {
  std::size_t left_out = rejected.size();
  for (const Comparison& comparison : comparisons) {
    left_out += comparison.left_out.size();
    left_out += static_cast<std::size_t>(std::count_if(comparison.why_not.begin(), comparison.why_not.end(),
                                                       [](const std::string& why) { return !why.empty(); }));
  }
  return static_cast<int>(left_out);
}

std::vector<ValidationSet> MakeComparedSets(const CompareResult& result, const std::vector<ParameterSet>& sets) {
  std::vector<ValidationSet> made;
  for (std::size_t i = 0; i < sets.size(); ++i)
    made.push_back({.role = "given",
                    .label = result.sets[i].label,
                    .file = result.sets[i].file,
                    .sha256 = CalcSha256(ReadFileWhole(result.sets[i].file)),
                    .set = sets[i]});
  return made;
}

CompareResult Compare(const std::vector<std::string>& files, const std::vector<ParameterSet>& sets,
                      std::vector<Record> records) {
  CompareResult result;
  result.sets = DescribeSets(files, sets);
  for (const Record& record : records)
    for (const std::string& notice : record.notices) result.notices.push_back(record.file + ": note: " + notice);
  const bool on_records = !records.empty();
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
    const bool wanted = on_records ? std::any_of(records.begin(), records.end(),
                                                 [&](const Record& r) { return r.direction == direction; })
                                   : std::any_of(sets.begin(), sets.end(),
                                                 [&](const ParameterSet& set) { return set[direction].has_value(); });
    if (wanted) result.comparisons.push_back(CompareDirection(direction, sets, result.sets, &records));
  }
  return result;
}

}  // namespace uiclink
