#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "model/event_solver.h"
#include "model/trajectory.h"
#include "tests/cli/program_run.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {

using Json = nlohmann::json;

/// A lateral free decay of the plain model, let go at 25 mm: what `identify` should recover.
struct PlainDecay {
  double k = 3.41, k1 = 2.21, T0 = 0.018;  ///< truth, near set 2 with the slider of table 4.1's order
  double rate_hz = 200;
  double duration_s = 12;
  double noise_mm = 0.0125;
  double amplitude_mm = 25;
  unsigned seed = 1;

  std::vector<double> CalcReadingsMm() const {
    Oscillator<double> link;
    link.k = k;
    link.Add({.k = k1, .T0 = T0});
    Trajectory<double> run;
    Solve(link, AtExtremum(link, 1e-3 * amplitude_mm), duration_s, &run);
    std::vector<double> y(static_cast<std::size_t>(std::lround(duration_s * rate_hz)));
    CalcDisplacements(run, {.first = 0, .step = 1 / rate_hz, .size = y.size()}, y);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, noise_mm);
    for (double& reading : y) reading = 1e3 * reading + noise(random);
    return y;
  }

  /// Lines of time and reading; `header` stands above them.
  std::string Text(const std::string& header = "# direction: lateral\n# mass_kg: 378.2\n") const {
    const std::vector<double> y = CalcReadingsMm();
    std::string text = header;
    for (std::size_t i = 0; i < y.size(); ++i)
      text += fmt::format("{:.6f}\t{:.4f}\n", static_cast<double>(i) / rate_hz, y[i]);
    return text;
  }
};

/// A test of the built program `identify` in an empty folder of its own.
class IdentifyProgram : public testing::Test {
 protected:
  ProgramResult Run(const std::vector<std::string>& arguments) const { return RunIn({.folder = Folder()}, arguments); }

  /// As a user without rights on files of others.
  ProgramResult RunAsNobody(const std::vector<std::string>& arguments) const {
    return RunIn({.folder = Folder(), .unprivileged = true}, arguments);
  }

  ProgramResult RunIn(const RunOptions& options, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), UICLINK_IDENTIFY);
    return RunProgram(arguments, options);
  }

  const std::filesystem::path& Folder() const { return folder_.path(); }
  void Write(const std::string& file, const std::string& text) const { folder_.Write(file, text); }
  bool Exists(const std::string& file) const { return std::filesystem::exists(Folder() / file); }
  std::string Read(const std::string& file) const { return ReadAll(Folder() / file); }
  Json ReadJson(const std::string& file) const { return Json::parse(Read(file)); }

  /// The names of everything in the folder, sorted.
  std::vector<std::string> List() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(Folder())) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  /// Copies shipped records and gives their names, which are relative so that messages are the same everywhere.
  std::vector<std::string> CopyMeasurements(const std::string& direction, int count) const {
    std::vector<std::string> names;
    for (int i = 1; i <= count; ++i) {
      names.push_back(fmt::format("{}_{:02}.txt", direction, i));
      std::filesystem::copy_file(std::filesystem::path(UICLINK_SOURCE_DIR) / "measurements" / names.back(),
                                 Folder() / names.back());
    }
    return names;
  }

  void CopyBadRecord(const std::string& name) const {
    std::filesystem::copy_file(std::filesystem::path(UICLINK_SOURCE_DIR) / "tests/cli/bad_records" / name,
                               Folder() / name);
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace uiclink
