#pragma once

// The record that the tests of the reader write in every way that it may be written.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "data/input_error.h"
#include "identify/record.h"

namespace uiclink {

inline constexpr int kSamples = 40;

inline double Time(int i) { return i / 200.0; }
inline double DisplacementMm(int i) { return std::round(1000 * 25 * std::cos(0.1 * i) * std::exp(-0.01 * i)) / 1000; }

/// kSamples lines, each from its time [s] and displacement [mm].
inline std::string MakeRows(const std::function<std::string(double, double)>& row, int samples = kSamples) {
  std::string text;
  for (int i = 0; i < samples; ++i) text += row(Time(i), DisplacementMm(i));
  return text;
}

inline std::string Plain(double t, double y) { return fmt::format("{:.3f}\t{:.3f}\n", t, y); }

inline std::string Replace(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

inline std::string WithCommas(const std::string& text) { return Replace(text, ".", ","); }

/// The record is the one of Time and DisplacementMm.
inline void ExpectStandard(const Record& record, double scale = 1e-3) {
  ASSERT_EQ(record.t.size(), kSamples);
  ASSERT_EQ(record.y.size(), kSamples);
  EXPECT_TRUE(record.uniform);
  EXPECT_NEAR(record.sampling_hz, 200, 1e-9);
  for (int i = 0; i < kSamples; ++i) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_NEAR(record.t[n], Time(i), 1e-12) << i;
    EXPECT_NEAR(record.y[n], scale * DisplacementMm(i), 1e-15) << i;  // one rounding of 25e-3
  }
}

inline void ExpectStandard(const std::string& text, const ReadOptions& options = {}) {
  SCOPED_TRACE(text.substr(0, 120));
  ExpectStandard(ParseRecord(text, "lateral_01.txt", options));
}

class RecordFileTest : public testing::Test {
 protected:
  RecordFileTest() {
    std::string name = (std::filesystem::temp_directory_path() / "uiclink_record_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~RecordFileTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Path(const std::string& name) const { return folder_ / name; }

  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    std::ofstream(Path(name), std::ios::binary) << content;
    return Path(name);
  }

  static std::string FileFault(const std::filesystem::path& path, const ReadOptions& options = {}) {
    try {
      ReadRecord(path, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no fault";
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace uiclink
