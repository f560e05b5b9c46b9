// The diagnosis: what it costs to ask ten records what the plain model lacks, how that grows with records, samples and
// effects, and what one evaluation of an extended model costs beside the plain model's.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/diagnosis.h"
#include "identify/extended_columns.h"
#include "identify/link_coordinates.h"
#include "identify/record_columns.h"
#include "tests/bench/limit.h"
#include "tests/bench/ratio.h"
#include "tests/support/effect_values.h"

namespace uiclink {
namespace {

constexpr int kMeasured = 10;  // lateral records in measurements/

/// The first `count` measured lateral records (from the first again when there are not as many), every
/// `keep_every`-th sample of them.
std::vector<Record> ReadLateral(int count, std::size_t keep_every) {
  std::vector<Record> records;
  for (int i = 0; i < count; ++i) {
    Record record = ReadRecord(fmt::format("{}/measurements/lateral_{:02}.txt", UICLINK_SOURCE_DIR, i % kMeasured + 1));
    std::size_t kept = 0;
    for (std::size_t j = 0; j < record.t.size(); j += keep_every, ++kept) {
      record.t[kept] = record.t[j];
      record.y[kept] = record.y[j];
    }
    record.t.resize(kept);
    record.y.resize(kept);
    record.sampling_hz /= static_cast<double>(keep_every);
    records.push_back(std::move(record));
  }
  return records;
}

/// Fits of the plain model, as the diagnosis takes them up.
std::shared_ptr<Identification> FitPlain(int count, std::size_t keep_every = 1) {
  IdentifyOptions options;
  options.threads = 1;
  return std::make_shared<Identification>(Identify(Direction::kLateral, ReadLateral(count, keep_every), options));
}

/// Prepared when it is first measured, so that what `--benchmark_filter` leaves out costs nothing.
Limit DiagnosisOf(std::string name, int count, std::size_t keep_every, double most_wall_s) {
  const auto plain = std::make_shared<std::shared_ptr<Identification>>();
  return {.name = std::move(name),
          .measure =
              [=] {
                if (*plain == nullptr) *plain = FitPlain(count, keep_every);
                return MeasureCall([&] { Diagnose(**plain, {.threads = 1, .progress = {}}); });
              },
          .most_wall_s = most_wall_s,
          .iterations = 3};
}

// --- how it grows ---------------------------------------------------------------------------------------------------

struct Job {
  std::string name;
  std::shared_ptr<Identification> plain;
  std::vector<double> seconds = {};
};

/// Processor time of all jobs, in turn, and each as a multiple of the first.
void PrintInTurn(const char* title, std::vector<Job> jobs, int runs) {
  for (int run = 0; run < runs; ++run)
    for (Job& job : jobs)
      job.seconds.push_back(MeasureCall([&] { Diagnose(*job.plain, {.threads = 1, .progress = {}}); }).cpu_s);
  fmt::print("\n{}\n", title);
  const double first = Median(jobs[0].seconds);
  for (const Job& job : jobs) {
    const double median = Median(job.seconds);
    fmt::print("{:<36}{:>10} {:>8.2f}\n", job.name, FormatDuration(median), median / first);
  }
}

void PrintGrowth() {
  std::vector<Job> by_records, by_samples;
  for (const int count : {10, 1, 3, 20}) by_records.push_back({fmt::format("{} records", count), FitPlain(count)});
  for (const std::size_t keep : {1, 2, 4})
    by_samples.push_back({fmt::format("10 records at {} Hz", 200 / keep), FitPlain(10, keep)});
  PrintInTurn("Diagnosis, one thread, by records: processor time, share of the first line", by_records, 3);
  PrintInTurn("The same by samples", by_samples, 3);
}

/// The records and the plain fit that effects are tried on.
struct Plain {
  explicit Plain(const Identification& id) {
    Levels levels;
    for (const std::size_t i : id.UsedIndices()) {
      const RecordResult& record = id.records[i];
      data.push_back(record.Data());
      FromOscillator(record.link, &levels, &state.link.shape);
      state.link.levels.push_back(levels);
      state.link.starts.push_back(record.start);
    }
    state.own.resize(data.size());
  }

  std::vector<FitData> data;
  ExtendedState state;  // a link for each record
};

/// One effect at a size that shows clearly, or (nullptr) none, evaluated on one record.
class Evaluation {
 public:
  Evaluation(const Plain& plain, const Effect* effect)
      : plain_(plain),
        extension_(effect != nullptr ? Extension({effect}) : Extension()),
        columns_(extension_, CountSliders(plain.state.link.shape)) {
    if (effect == nullptr) return;
    const std::vector<double> values = MakeEffectValues(*effect, 1, {.swing = plain.data[0].swing, .speed = 0.15});
    const auto put = [&](std::span<const Extension::Unknown> unknowns, std::vector<double>* coordinates) {
      for (const Extension::Unknown& unknown : unknowns) {
        const double value = values[unknown.parameter];  // inverse squares are coordinates already
        coordinates->push_back(unknown.Parameter().coordinate == Coordinate::kLog ? std::log(value) : value);
      }
    };
    put(extension_.shared(), &shared_);
    put(extension_.own(), &own_);
  }

  void Run(bool derivatives) {
    const Start& start = plain_.state.link.starts[0];
    columns_.Evaluate(plain_.data[0], plain_.data[0].size, 1, plain_.state.link.levels[0].data(),
                      plain_.state.link.shape.data(), start.data(), shared_.data(), own_.data(), derivatives);
  }

 private:
  const Plain& plain_;
  Extension extension_;
  ExtendedColumns columns_;
  std::vector<double> shared_, own_;
};

/// Each effect beside the plain model's own solver: an evaluation of a record, and the whole trial on ten.
void PrintEffects() {
  constexpr int kRuns = 20, kRounds = 9;
  const auto id = FitPlain(kMeasured);
  const Plain plain(*id);
  const EffectSearch search(plain.data, Sharing::kShape, {.threads = 1, .progress = {}});
  const ExtendedOutcome fitted = search.Refit(Extension(), plain.state);
  const Oscillator<double> link = ToOscillator(plain.state.link.levels[0], plain.state.link.shape, plain.data[0].g);
  RecordColumns<1> plain_columns;
  const Side plain_side = Timed("plain", kRuns, [&] {
    plain_columns.EvaluateWithDerivatives(plain.data[0], plain.data[0].size, link, plain.state.link.starts[0].data());
  });
  fmt::print(
      "\nOne record with derivatives, beside the plain model's solver, and without; the whole trial of an effect on {} "
      "records\n{:<24}{:>12}{:>12}{:>8}{:>12}{:>12}\n",
      kMeasured, "", "extended", "plain", "times", "values only", "trial");
  std::vector<const Effect*> effects(Effects().begin(), Effects().end());
  effects.insert(effects.begin(), nullptr);
  double all = 0;
  for (const Effect* effect : effects) {
    Evaluation evaluation(plain, effect);
    const Side with = Timed("", kRuns, [&] { evaluation.Run(true); });
    const Side without = Timed("", kRuns, [&] { evaluation.Run(false); });
    std::vector<double> ours, theirs, values;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(with.seconds());
      theirs.push_back(plain_side.seconds());
      values.push_back(without.seconds());
    }
    double trial = 0;
    if (effect != nullptr) {
      const std::vector<const Effect*> tried = {effect};
      trial = MeasureCall([&] { search.Try(Extension(), fitted, tried); }).cpu_s;
      all += trial;
    }
    fmt::print("{:<24}{:>12}{:>12}{:>8.1f}{:>12}{:>12}\n", effect != nullptr ? effect->id : "none",
               FormatDuration(Median(ours)), FormatDuration(Median(theirs)), Median(ours) / Median(theirs),
               FormatDuration(Median(values)), effect != nullptr ? FormatDuration(trial) : "");
  }
  fmt::print("{:<68}{:>12}\n", "all effects, one by one", FormatDuration(all));
}

int Main(int argc, char** argv) {
  const int status = RunLimits(argc, argv,
                               {DiagnosisOf("diagnosis, 10 lateral records, one thread", kMeasured, 1, 10),
                                DiagnosisOf("diagnosis, 20 lateral records, one thread", 2 * kMeasured, 1, 0)});
  if (status == 2) return status;
  PrintEffects();
  PrintGrowth();
  return status;
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  try {
    return uiclink::Main(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_diagnose: {}\n", error.what());
    return 2;
  }
}
