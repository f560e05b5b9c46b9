// rig SETTINGS.toml --out DIR: writes synthetic ring-down records, DIR/lateral_01.txt and so on.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "measurements/rig/rig.h"

namespace {

namespace fs = std::filesystem;
namespace rig = uiclink::rig;

constexpr int kNothingDone = 2;

struct Options {
  fs::path settings;
  fs::path out;
  fs::path truth;
  std::optional<int> count;
  std::optional<std::uint64_t> seed;
};

void WriteFile(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: expected a file that can be written", path.string()));
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
}

void WriteRecords(const Options& options) {
  rig::Settings settings = rig::ReadSettings(options.settings);
  settings.records = options.count.value_or(settings.records);
  settings.seed = options.seed.value_or(settings.seed);
  MakeFolder(options.out);
  std::vector<rig::RigRecord> records;
  for (int index = 1; index <= settings.records; ++index) {
    records.push_back(rig::MakeRecord(settings, index));
    WriteFile(options.out / fmt::format("{}_{:02}.txt", settings.direction, index),
              rig::FormatRecord(records.back(), settings, index));
  }
  if (!options.truth.empty()) WriteFile(options.truth, rig::FormatTruth(records, settings));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  bool list_effects = false;
  CLI::App app{"Makes synthetic ring-down records of a UIC double-link suspension.", "rig"};
  app.footer(
      "Examples:\n"
      "  rig measurements/rig/settings/lateral.toml --out measurements\n"
      "  rig my.toml --out records --count 200 --seed 7 --truth truth.toml\n"
      "  rig --effects\n"
      "Exit codes: 0 done; 2 nothing could be done.");
  auto* settings = app.add_option("SETTINGS", options.settings, "settings file (TOML)");
  auto* out = app.add_option("--out", options.out, "folder for the records");
  app.add_option("--count", options.count, "number of records instead of the file's")->check(CLI::Range(1, 1000000));
  app.add_option("--seed", options.seed, "seed instead of the file's");
  app.add_option("--truth", options.truth, "also write what the records were made from to this file (TOML)");
  app.add_flag("--effects", list_effects, "print the effects that can be switched on, and leave");
  settings->needs(out);
  try {
    app.parse(argc, argv);
    if (list_effects) {
      fmt::print("{}\nBeyond the catalogue:\n\n{}", rig::FormatEffectTable(rig::EffectCatalogue()),
                 rig::FormatEffectTable(rig::OutsideCatalogue()));
      return 0;
    }
    if (options.settings.empty()) throw CLI::RequiredError("SETTINGS");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kNothingDone;
  }
  try {
    WriteRecords(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kNothingDone;
  }
  return 0;
}
