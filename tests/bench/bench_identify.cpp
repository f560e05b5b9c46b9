// The main job: what it costs to identify ten records, as a program from start to end with its files written, as a call
// of the library, and stage by stage.

#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "data/file.h"
#include "data/parameter_set_file.h"
#include "identify/identification.h"
#include "identify/joint_fit.h"
#include "identify/report.h"
#include "measurements/rig/rig.h"
#include "tests/bench/limit.h"
#include "tests/cli/temporary_folder.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

constexpr int kRecords = 10;

std::vector<std::string> MeasuredFiles(Direction direction) {
  std::vector<std::string> files;
  for (int i = 1; i <= kRecords; ++i)
    files.push_back(fmt::format("{}/measurements/{}_{:02}.txt", UICLINK_SOURCE_DIR, Name(direction), i));
  return files;
}

std::vector<Record> ReadRecords(const std::vector<std::string>& files) {
  std::vector<Record> records;
  for (const std::string& file : files) records.push_back(ReadRecord(file));
  return records;
}

/// A lateral link without anything that the model lacks; links that re-seat, if `scattered`.
rig::Settings PlainSettings(bool scattered) {
  rig::Settings settings = PlainLateral(1);
  if (scattered) settings.scatter = kReseating;
  return settings;
}

std::vector<Record> MakeRecords(const rig::Settings& settings) {
  std::vector<Record> records;
  for (int i = 1; i <= kRecords; ++i)
    records.push_back(
        ParseRecord(rig::FormatRecord(rig::MakeRecord(settings, i), settings, i), fmt::format("lateral_{:02}.txt", i)));
  return records;
}

/// One record of a million samples, written by a process of its own: what it needs must not count as ours.
void WriteLongRecord(const fs::path& file) {
  const pid_t child = fork();
  if (child == 0) {
    rig::Settings settings = PlainSettings(false);
    settings.sensor.sampling_hz = 1e6 / settings.duration_s;
    settings.sensor.keep_every = 1;
    settings.steps_per_sample = 1;
    const rig::RigRecord record = rig::MakeRecord(settings, 1);
    fmt::memory_buffer text;
    for (std::size_t i = 0; i < record.t.size(); ++i)  // the rig's own format has too few decimals of the time
      fmt::format_to(std::back_inserter(text), "{:.6f}\t{:.3f}\n", record.t[i], record.y_mm[i]);
    WriteFileWhole(file, {text.data(), text.size()});
    _exit(0);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error("the rig made no record of a million samples");
}

// --- the program ---------------------------------------------------------------------------------------------------

/// The whole identification: process start, reading, fits, report and files. Diagnosis and wagon have benchmarks of
/// their own.
Limit MainJob(std::string name, const fs::path& out, std::vector<std::string> records) {
  std::vector<std::string> words = {UICLINK_IDENTIFY};
  words.insert(words.end(), records.begin(), records.end());
  words.insert(words.end(), {"--no-diagnosis", "--no-wagon", "--out", out.string()});
  return {.name = std::move(name),
          .measure = [words = std::move(words)] { return MeasureProgram(words); },
          .most_wall_s = 1,
          .most_peak_MB = 100};
}

// --- the library ---------------------------------------------------------------------------------------------------

/// Everything that follows the reader: phases, a fit of each record with its check from scattered starts and its
/// bounds, the joint fit with its bounds.
Limit AllFits(std::string name, int threads, std::function<std::vector<Record>()> read) {
  const auto records = std::make_shared<std::vector<Record>>();
  return {.name = std::move(name), .measure = [records, threads, read = std::move(read)] {
            if (records->empty()) *records = read();
            std::vector<Record> copy = *records;
            const Direction direction = *copy[0].direction;
            IdentifyOptions options;
            options.threads = threads;
            return MeasureCall([&] { Identify(direction, std::move(copy), options); });
          }};
}

// --- the stages ----------------------------------------------------------------------------------------------------

using Stages = std::vector<std::pair<std::string, double>>;  // name and processor time on one thread [s]

/// The main job of one direction taken apart, in the order in which the program and Identify() run it.
Stages MeasureStages(Direction direction, const fs::path& out) {
  Stages stages;
  const auto time = [&stages](const char* name, const std::function<void()>& work) {
    stages.emplace_back(name, MeasureCall(work).cpu_s);
  };
  stages.emplace_back("start and end of the program", MeasureProgram({UICLINK_IDENTIFY, "--version"}).cpu_s);

  RunResult run;
  Identification& id = run.directions.emplace_back();
  id.direction = direction;
  id.sliders = direction == Direction::kLateral ? 1 : kMaxFittedSliders;
  time("reader", [&] {
    for (Record& record : ReadRecords(MeasuredFiles(direction))) id.records.emplace_back().record = std::move(record);
  });
  const auto time_each = [&](const char* name, const std::function<void(RecordResult&)>& work) {
    time(name, [&] {
      for (RecordResult& record : id.records) work(record);
    });
  };
  time_each("noise", [](RecordResult& r) { r.noise = EstimateNoise(r.record.t, r.record.y); });
  time_each("phases", [](RecordResult& r) { r.phases = FindPhases(r.record, r.noise); });
  time_each("frequency method", [](RecordResult& r) { r.sine = FitSine(r.record, r.phases); });
  for (RecordResult& record : id.records) record.used = record.phases.usable;
  const ScatteredStarts none{.count = 0};
  time_each("fit of each record, with bounds", [&](RecordResult& r) { FitRecord(id.sliders, none, &r); });
  const double once = stages.back().second;
  time_each("its check from scattered starts", [&](RecordResult& r) { FitRecord(id.sliders, {}, &r); });
  stages.back().second -= once;
  time("joint fit, with bounds", [&] {
    id.sharing = TestSharing(id);
    id.shared = id.sharing.shared;
    FitJointly(1, &id);
  });
  std::string report, json, parameters, residuals;
  time("report, JSON, parameter set", [&] {
    report = FormatReport(run);
    json = FormatJson(run);
    parameters = FormatParameterSet(MakeParameterSet(run));
  });
  time("residuals as text", [&] { residuals = FormatResiduals(run); });
  time("files", [&] {
    WriteFileWhole(out / "parameters.toml", parameters);
    WriteFileWhole(out / "result.json", json);
    WriteFileWhole(out / "residuals.csv", residuals);
  });
  return stages;
}

Stages MedianStages(Direction direction, const fs::path& out) {
  constexpr int kRuns = 5;
  std::vector<Stages> runs;
  for (int i = 0; i < kRuns; ++i) runs.push_back(MeasureStages(direction, out));
  Stages medians = runs[0];
  for (std::size_t s = 0; s < medians.size(); ++s) {
    std::vector<double> seconds;
    for (const Stages& run : runs) seconds.push_back(run[s].second);
    medians[s].second = Median(seconds);
  }
  return medians;
}

void PrintStages(const fs::path& out) {
  const Stages lateral = MedianStages(Direction::kLateral, out);
  const Stages longitudinal = MedianStages(Direction::kLongitudinal, out);
  fmt::print("\nProcessor time of the main job by stage, one thread [ms]\n{:<36}{:>10}{:>14}\n", "", "lateral",
             "longitudinal");
  double sum[2] = {};
  for (std::size_t s = 0; s < lateral.size(); ++s) {
    fmt::print("{:<36}{:>10.1f}{:>14.1f}\n", lateral[s].first, 1e3 * lateral[s].second, 1e3 * longitudinal[s].second);
    sum[0] += lateral[s].second;
    sum[1] += longitudinal[s].second;
  }
  fmt::print("{:<36}{:>10.1f}{:>14.1f}\n", "all", 1e3 * sum[0], 1e3 * sum[1]);
}

int Main(int argc, char** argv) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out", million = folder.path() / "lateral_million.txt";
  WriteLongRecord(million);
  const auto measured = [](Direction direction) { return [=] { return ReadRecords(MeasuredFiles(direction)); }; };
  const auto made = [](bool scattered) { return [=] { return MakeRecords(PlainSettings(scattered)); }; };
  // The programs first, while this process is small; see MeasureProgram.
  const int status =
      RunLimits(argc, argv,
                {MainJob("program, 10 lateral records", out, MeasuredFiles(Direction::kLateral)),
                 MainJob("program, 10 longitudinal records", out, MeasuredFiles(Direction::kLongitudinal)),
                 MainJob("program, one record of 1e6 samples", out, {million.string()}),
                 AllFits("fits, 10 lateral records", 0, measured(Direction::kLateral)),
                 AllFits("fits, 10 lateral records, one thread", 1, measured(Direction::kLateral)),
                 AllFits("fits, 10 longitudinal records", 0, measured(Direction::kLongitudinal)),
                 AllFits("fits, 10 records of one plain link", 0, made(false)),
                 AllFits("fits, 10 records of plain links that scatter", 0, made(true))});
  if (status != 2) PrintStages(out);
  return status;
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  try {
    return uiclink::Main(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_identify: {}\n", error.what());
    return 2;
  }
}
