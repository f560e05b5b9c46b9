#include "vehicle/hunting/history_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "data/file.h"
#include "data/input_error.h"
#include "reports/csv.h"
#include "vehicle/hunting/guidance_history.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr std::size_t kLeastSamples = 64;
constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

std::vector<std::string_view> SplitCells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find(',', begin);
    cells.push_back(line.substr(begin, end - begin));
    if (end == std::string_view::npos) return cells;
    begin = end + 1;
  }
}

/// The lines of a file one after the other, without their ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool Next(std::string_view* line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    *line = rest_.substr(0, end);
    if (line->ends_with('\r')) line->remove_suffix(1);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }
  int number() const { return number_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

class Reader {
 public:
  Reader(const std::string& text, const std::string& file) : file_(file), lines_(text) {}

  HistoryFile Read() {
    ReadHead();
    std::string_view line;
    while (lines_.Next(&line))
      if (!line.empty()) ReadRow(SplitCells(line));
    CheckSamples();
    return std::move(history_);
  }

 private:
  [[noreturn]] void Fail(int line, const std::string& message) const { throw InputError(file_, line, message); }

  std::size_t Find(const std::string& word) const {
    const auto found = std::ranges::find(head_, word);
    return found == head_.end() ? kNowhere : static_cast<std::size_t>(found - head_.begin());
  }
  std::size_t FindColumn(const char* name, const char* unit) const {
    const std::string word = ColumnWord({name, unit, {}});
    const std::size_t column = Find(word);
    if (column == kNowhere)
      Fail(1, "expected the columns of a histories.csv that wagon simulate wrote, found no column " + word);
    return column;
  }

  void ReadHead() {
    std::string_view line;
    if (!lines_.Next(&line)) Fail(0, "expected a histories.csv that wagon simulate wrote, found an empty file");
    for (const std::string_view cell : SplitCells(line)) head_.emplace_back(cell);
    time_ = FindColumn("time", "s");
    for (std::size_t i = 0; i < kMotions; ++i) places_[i] = FindColumn(kStateNames[i], kStateUnits[i]);
    for (std::size_t i = 0; i < kCorners; ++i) {
      guide_x_[i] = Find(ColumnWord({std::string(kCornerNames[i]) + "_guide_x", "N", {}}));
      guide_y_[i] = Find(ColumnWord({std::string(kCornerNames[i]) + "_guide_y", "N", {}}));
    }
  }

  double Number(const std::vector<std::string_view>& cells, std::size_t column) const {
    const std::string_view cell = cells[column];
    double value = 0;
    const char* const end = cell.data() + cell.size();
    const auto [rest, error] = std::from_chars(cell.data(), end, value);
    if (error != std::errc() || rest != end || !std::isfinite(value))
      Fail(lines_.number(), fmt::format("expected a number for {}, found \"{}\"", head_[column], cell));
    return value;
  }

  void ReadRow(const std::vector<std::string_view>& cells) {
    if (cells.size() != head_.size())
      Fail(lines_.number(), fmt::format("expected {} cells as in the head, found {}", head_.size(), cells.size()));
    SimulationSample sample{.t = Number(cells, time_), .x = {}};
    for (std::size_t i = 0; i < kMotions; ++i) sample.x[i] = Number(cells, places_[i]);
    history_.samples.push_back(sample);
    for (std::size_t i = 0; i < kCorners; ++i) {
      if (guide_x_[i] != kNowhere) history_.guide_x[i].push_back(Number(cells, guide_x_[i]));
      if (guide_y_[i] != kNowhere) history_.guide_y[i].push_back(Number(cells, guide_y_[i]));
    }
  }

  void CheckSamples() {
    const std::vector<SimulationSample>& samples = history_.samples;
    if (samples.size() < kLeastSamples)
      Fail(0, fmt::format("expected at least {} samples for a spectrum, found {}", kLeastSamples, samples.size()));
    const double distance = (samples.back().t - samples.front().t) / static_cast<double>(samples.size() - 1);
    if (!(distance > 0)) Fail(0, "expected times that grow, found the same at the first and the last sample");
    constexpr double kEven = 1e-3;  // of their distance
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double due = samples.front().t + static_cast<double>(i) * distance;
      if (std::abs(samples[i].t - due) <= kEven * distance) continue;
      Fail(static_cast<int>(i) + 2,
           fmt::format("expected evenly spaced times, {:g} s apart, found {:g} s instead of {:g} s", distance,
                       samples[i].t, due));
    }
    history_.hz = 1 / distance;
  }

  std::string file_;
  Lines lines_;
  std::vector<std::string> head_;
  std::size_t time_ = 0;
  std::array<std::size_t, kMotions> places_{};
  std::array<std::size_t, kCorners> guide_x_{}, guide_y_{};
  HistoryFile history_;
};

}  // namespace

HistoryFile ParseHistory(const std::string& text, const std::string& file) { return Reader(text, file).Read(); }

HistoryFile ReadHistoryFile(const std::filesystem::path& path) {
  return ParseHistory(ReadFileWhole(path), path.string());
}

std::string CompareGuides(const HistoryFile& history, const Wagon& wagon, const std::string& file) {
  const GuidanceHistory ours = CalcGuidanceHistory(wagon, history.samples);
  double largest = 0, off = 0;
  const auto compare = [&](const std::vector<double>& theirs, const std::vector<double>& force, double share) {
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      largest = std::max({largest, std::abs(theirs[i]), std::abs(share * force[i])});
      off = std::max(off, std::abs(theirs[i] - share * force[i]));
    }
  };
  for (std::size_t i = 0; i < kCorners; ++i) {
    compare(history.guide_x[i], ours.longitudinal[i].force, 1);
    compare(history.guide_y[i], ours.lateral[AxleOf(i)].force, 0.5);
  }
  // Both are computed from the same numbers by the same formula.
  if (off <= 1e-6 * largest) return {};
  return fmt::format(
      "{}: the forces of its guides are off by up to {:.3g} N (of {:.3g} N) from those of this wagon in "
      "the same motion: is it of another wagon, cargo, or --no-guidance?",
      file, off, largest);
}

}  // namespace uiclink
