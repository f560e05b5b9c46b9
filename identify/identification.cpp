#include "identify/identification.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "identify/joint_fit.h"
#include "identify/slider_choice.h"
#include "identify/strangers.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

Population Describe(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  Population result;
  for (const double v : values) result.mean += v / n;
  for (const double v : values) result.spread += (v - result.mean) * (v - result.mean);
  result.spread = values.size() > 1 ? std::sqrt(result.spread / (n - 1)) : 0;
  result.std = values.size() > 1 ? result.spread / std::sqrt(n) : 0;
  return result;
}

SineSummary SummariseSine(const Identification& result) {
  std::vector<const SineFit*> fits;
  for (const RecordResult& record : result.records)
    if (record.used && record.sine) fits.push_back(&*record.sine);
  const auto describe = [&](double SineFit::*member) {
    std::vector<double> values;
    for (const SineFit* fit : fits) values.push_back(fit->*member);
    return values.empty() ? Population{} : Describe(values);
  };
  return {.k = describe(&SineFit::k),
          .sum_ki = describe(&SineFit::sum_ki),
          .T0 = describe(&SineFit::T0),
          .k_corrected = describe(&SineFit::k_corrected),
          .sum_ki_corrected = describe(&SineFit::sum_ki_corrected),
          .T0_corrected = describe(&SineFit::T0_corrected),
          .records = static_cast<int>(fits.size())};
}

/// A lower minimum counts if the model explains the record there. Where the model lacks something, the lowest minimum
/// is the one that hides it best.
void SearchIfExplained(RecordResult* record) {
  RecordResult searched = *record;
  RearrangeSliders(&searched);
  if (!searched.information.structured) *record = std::move(searched);
}

/// Several sliders have many minima. The record that is described best is searched for lower ones; from its link the
/// others find the way to theirs, and those that lag behind it are searched as well.
void FindLowerMinima(int threads, Identification* result) {
  const std::vector<std::size_t> used = result->UsedIndices();
  const auto misfit = [&](std::size_t i) {
    return result->records[i].information.rms / result->records[i].noise.sigma;
  };
  const std::size_t best =
      *std::min_element(used.begin(), used.end(), [&](std::size_t a, std::size_t b) { return misfit(a) < misfit(b); });
  SearchIfExplained(&result->records[best]);
  const RecordResult& donor = result->records[best];
  const Oscillator<double> link = ToOscillator(donor.own.state.levels[0], donor.own.state.shape, result->g);
  const bool explained = !donor.information.structured;
  ParallelFor(used.size(), threads, [&](std::size_t i) {
    RecordResult& record = result->records[used[i]];
    if (used[i] == best) return;
    RefitRecord(link, &record);
    if (explained && record.information.structured) SearchIfExplained(&record);
  });
}

int DefaultSliders(Direction direction) { return direction == Direction::kLateral ? 1 : kMaxFittedSliders; }

}  // namespace

std::vector<std::size_t> Identification::UsedIndices() const {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (records[i].used) used.push_back(i);
  return used;
}

int Identification::CountUsed() const { return static_cast<int>(UsedIndices().size()); }

void FitAll(const IdentifyOptions& options, Identification* result) {
  const std::vector<std::size_t> used = result->UsedIndices();
  ParallelFor(
      used.size(), options.threads,
      [&](std::size_t i) {
        ScatteredStarts starts = options.starts;
        starts.seed += static_cast<unsigned>(used[i]);
        FitRecord(result->sliders, starts, &result->records[used[i]]);
      },
      [&](std::size_t done) {
        if (options.progress)
          options.progress("fitting records", static_cast<int>(done), static_cast<int>(used.size()));
      });
  if (result->sliders > 1) FindLowerMinima(options.threads, result);
  result->sharing = TestSharing(*result);
  result->shared = result->sharing.shared;
  FitJointly(options.threads, result);
}

Identification Identify(Direction direction, std::vector<Record> records, const IdentifyOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Identification result;
  result.direction = direction;
  result.records.resize(records.size());
  ParallelFor(records.size(), options.threads, [&](std::size_t i) {
    result.records[i].record = std::move(records[i]);
    PrepareRecord(options.sine, &result.records[i]);
  });
  LeaveOutStrangers(&result);
  if (result.CountUsed() > 0) {
    result.g = result.records[result.UsedIndices()[0]].record.g;
    result.sine = SummariseSine(result);
    result.sliders = options.sliders > 0 ? options.sliders : DefaultSliders(direction);
    if (options.sliders == kAutoSliders) {
      ChooseSliders(options, &result);
    } else {
      FitAll(options, &result);
    }
  }
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

std::vector<FitData> CollectData(const Identification& plain) {
  std::vector<FitData> data;
  for (const std::size_t i : plain.UsedIndices()) data.push_back(plain.records[i].Data());
  return data;
}

FitState CollectState(const Identification& plain, Sharing sharing) {
  FitState state;
  Levels levels;
  FromOscillator(plain.link, &levels, &state.shape);
  if (sharing == Sharing::kLink) state.levels.push_back(levels);
  for (const std::size_t i : plain.UsedIndices()) {
    const RecordResult& record = plain.records[i];
    Shape shape;
    FromOscillator(record.link, &levels, &shape);
    if (sharing == Sharing::kShape) state.levels.push_back(levels);
    if (sharing == Sharing::kShape && plain.sliders > 1) state.shapes.push_back(shape);
    state.starts.push_back(record.start);
  }
  return state;
}

}  // namespace uiclink
