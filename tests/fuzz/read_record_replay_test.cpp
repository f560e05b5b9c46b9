// Replays every file that the reader must survive, and small mutations of each, with every compiler and in every run.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "data/file.h"
#include "tests/fuzz/parse.h"

namespace uiclink::fuzz {
namespace {

struct Seed {
  std::string name;
  std::string text;
  unsigned char options = 0;
};

std::vector<std::filesystem::path> FilesIn(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(UICLINK_SOURCE_DIR) / folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<Seed> Seeds() {
  std::vector<Seed> seeds;
  for (const auto& path : FilesIn("tests/cli/bad_records")) {
    seeds.push_back({path.filename().string(), ReadFileWhole(path), 0});
  }
  for (const auto& path : FilesIn("tests/fuzz/corpus")) {  // as the fuzzer writes them: options first
    const std::string content = ReadFileWhole(path);
    if (content.empty()) continue;
    seeds.push_back({path.filename().string(), content.substr(1), static_cast<unsigned char>(content[0])});
  }
  return seeds;
}

/// One to four edits: a byte changed, a piece removed, doubled, or replaced by something that means much to the reader.
std::string Mutate(std::string text, std::mt19937_64* random) {
  static const std::vector<std::string> words = {",",
                                                 ";",
                                                 "\t",
                                                 "\n",
                                                 "\r",
                                                 "\r\n",
                                                 "#",
                                                 "%",
                                                 "nan",
                                                 "1e999",
                                                 "-",
                                                 "+",
                                                 "1e-320",
                                                 "# mass_kg:",
                                                 "\xFF",
                                                 "[V]",
                                                 "[ms]",
                                                 "0,0",
                                                 "1.7e308",
                                                 std::string(1, '\0'),
                                                 "# sampling_hz: 1e300\n",
                                                 "# displacement_unit: um\n"};
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>((*random)() % n); };
  for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = below(std::min<std::size_t>(text.size() - at, 40) + 1);
    switch (below(4)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      default:
        text.replace(at, below(2) * length, words[below(words.size())]);
    }
  }
  return text;
}

TEST(ReadRecordReplayTest, SurvivesEveryKnownFile) {
  const std::vector<Seed> seeds = Seeds();
  ASSERT_GT(seeds.size(), 20U);
  for (const Seed& seed : seeds) {
    for (unsigned byte = 0; byte < 16; ++byte) {
      EXPECT_NO_THROW(Parse(seed.text, OptionsFor(static_cast<unsigned char>(byte)))) << seed.name << ", " << byte;
    }
    EXPECT_NO_THROW(Parse(seed.text, OptionsFor(seed.options))) << seed.name;
  }
}

TEST(ReadRecordReplayTest, SurvivesMutations) {
  constexpr int kVariants = 100;
  constexpr std::size_t kLongest = 6000;  // the first few hundred lines: a mutation there is as good as further on
  std::mt19937_64 random(20030312);
  int records = 0;
  int faults = 0;
  for (const Seed& seed : Seeds()) {
    const std::string text = seed.text.substr(0, kLongest);
    for (int i = 0; i < kVariants; ++i) {
      const std::string mutant = Mutate(text, &random);
      const auto options = static_cast<unsigned char>(random());
      bool is_record = false;
      EXPECT_NO_THROW(is_record = Parse(mutant, OptionsFor(options))) << seed.name << ", variant " << i;
      ++(is_record ? records : faults);
    }
  }
  // Mutations that never get through, or always, would test little.
  EXPECT_GT(records, 100);
  EXPECT_GT(faults, 100);
}

}  // namespace
}  // namespace uiclink::fuzz
