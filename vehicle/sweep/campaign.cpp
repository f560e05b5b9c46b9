#include "vehicle/sweep/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>

#include "data/file.h"
#include "vehicle/start_state.h"

namespace uiclink {
namespace {

/// A decimal number, where a sum of steps has left rounding behind it: 0.1 + 2 x 0.1 = 0.3.
double RoundDecimal(double value) { return std::strtod(fmt::format("{:.12g}", value).c_str(), nullptr); }

/// Reads one table of axes after the other, and knows which axis was seen where.
class AxisReader {
 public:
  explicit AxisReader(Campaign* campaign) : campaign_(campaign) {}

  void ReadBase(Table table) {
    for (const std::string& key : table.Keys()) {
      const std::optional<std::size_t> axis = Find(&table, key, {});
      if (!axis) continue;
      campaign_->base[*axis] = ReadValue(&table, key, SweepAxes()[*axis]);
      campaign_->said[*axis] = true;
    }
  }

  void ReadGrid(Table table) {
    for (const std::string& key : table.Keys()) {
      const std::optional<std::size_t> axis = Find(&table, key, {});
      if (!axis) continue;
      std::vector<AxisValue> values = ReadValues(&table, key, SweepAxes()[*axis]);
      CheckEachOnce(&table, key, values);
      campaign_->grid.push_back({*axis, std::move(values)});
    }
    std::ranges::sort(campaign_->grid, {}, &Campaign::Grid::axis);
  }

  void ReadSample(Table table) {
    campaign_->samples = static_cast<std::uint32_t>(ReadWhole(&table, "n", 1, 1e7));
    const std::string draws = table.OptionalString("draws").value_or("common");
    campaign_->own_draws = draws == "own";
    if (draws != "common" && draws != "own")
      table.Report("draws", "draws = \"common\" or \"own\"", "\"" + draws + "\"");
    for (const std::string& key : table.Keys()) {
      if (key == "n" || key == "draws") continue;
      const std::optional<std::size_t> axis = Find(&table, key, {"n", "draws"});
      std::optional<Table> law = axis ? table.OptionalTable(key) : std::nullopt;
      if (law) campaign_->sampled.push_back({*axis, ReadDistribution(&*law, SweepAxes()[*axis])});
    }
    std::ranges::sort(campaign_->sampled, {}, &Campaign::Sampled::axis);
  }

  static double ReadWhole(Table* table, const std::string& key, double low, double high) {
    const double value = table->Number(key, {.unit = "-", .low = low, .high = high});
    if (std::isnan(value) || value == std::floor(value)) return std::isnan(value) ? low : value;
    table->Report(key, "a whole number " + key, fmt::format("{}", value));
    return low;
  }

 private:
  /// The axis of a key that no table before had.
  std::optional<std::size_t> Find(Table* table, const std::string& key, const std::vector<std::string>& others) {
    const std::optional<std::size_t> axis = FindAxis(key);
    if (!axis) {  // left to Table: as an unknown key, with the nearest one of those that there are
      if (hinted_.insert(table->name()).second) {
        std::vector<std::string> names = others;
        for (const SweepAxis& known : SweepAxes()) names.push_back(known.name);
        table->Know(names);
      }
      return std::nullopt;
    }
    if (const auto [entry, is_new] = seen_.emplace(*axis, table->name()); !is_new) {
      table->Report(key, fmt::format("{} in one table alone", key), fmt::format("it in [{}] too", entry->second));
      table->Know({key});
      return std::nullopt;
    }
    return axis;
  }

  static void CheckText(Table* table, const std::string& key, const SweepAxis& axis, const std::string& text) {
    if (!axis.words.empty() && std::ranges::find(axis.words, text) == axis.words.end()) {
      table->Report(key, fmt::format("{} one of {}", key, fmt::join(axis.words, ", ")), "\"" + text + "\"");
    } else if (text.empty()) {
      table->Report(key, fmt::format("a text {}", key), "an empty one");
    } else if (axis.name == "start" && text != "equilibrium") {
      try {
        ParsePerturbation(text);
      } catch (const UsageError& error) {
        const std::string what = error.what();  // "--start: expected ..., found ..."
        const std::size_t begin = what.find("expected ") + 9, found = what.rfind(", found ");
        table->Report(key, "start with " + what.substr(begin, found - begin), what.substr(found + 8));
      }
    }
  }

  static AxisValue ReadValue(Table* table, const std::string& key, const SweepAxis& axis) {
    if (axis.IsNumber()) return table->Number(key, *axis.range);
    const std::string text = table->String(key);
    CheckText(table, key, axis, text);
    return text;
  }

  static std::vector<AxisValue> ReadValues(Table* table, const std::string& key, const SweepAxis& axis) {
    if (axis.IsNumber() && table->HasTable(key)) {
      Table range = *table->OptionalTable(key);
      return ReadRange(&range, axis);
    }
    std::vector<AxisValue> values;
    if (axis.IsNumber()) {
      for (const double value : table->Numbers(key, *axis.range)) values.emplace_back(value);
    } else {
      for (const std::string& text : table->Strings(key)) {
        CheckText(table, key, axis, text);
        values.emplace_back(text);
      }
    }
    if (values.empty()) table->Report(key, fmt::format("{} with one value at least", key), "none");
    return values;
  }

  static std::vector<AxisValue> ReadRange(Table* range, const SweepAxis& axis) {
    const double from = range->Number("from", *axis.range), to = range->Number("to", *axis.range);
    const double step = range->Number("step", Range::Positive(axis.range->unit));
    if (from > to) range->Report("to", fmt::format("to >= from = {:g}", from), fmt::format("{:g}", to));
    if (!((to - from) / step < kMostRuns)) {  // also where one of them is missing
      if ((to - from) / step >= kMostRuns)
        range->Report("step", fmt::format("at most {} values", static_cast<int>(kMostRuns)),
                      fmt::format("step = {}", step));
      return {from};
    }
    std::vector<AxisValue> values;
    // A last step that rounding has made too long by a millionth is meant.
    for (double i = 0; from + i * step <= to + 1e-6 * step; ++i) values.emplace_back(RoundDecimal(from + i * step));
    return values;
  }

  /// Twice the same value would be twice the same run.
  static void CheckEachOnce(Table* table, const std::string& key, const std::vector<AxisValue>& values) {
    std::set<AxisValue> seen;
    for (const AxisValue& value : values) {
      if (value != value || seen.insert(value).second) continue;  // NaN is a fault that was told
      table->Report(key, fmt::format("each value of {} once", key), fmt::format("{} twice", FormatValue(value)));
    }
  }

  static Distribution ReadDistribution(Table* law, const SweepAxis& axis) {
    Distribution distribution;
    const std::string word = law->String("distribution");
    if (word == "choice") {
      distribution.law = Distribution::Law::kChoice;
      distribution.choices = ReadValues(law, "values", axis);
      return distribution;
    }
    const Range range = axis.range.value_or(Range::Any("-"));
    distribution.low = range.low, distribution.high = range.high;
    if (word == "uniform" && axis.IsNumber()) {
      distribution.a = law->Number("low", range), distribution.b = law->Number("high", range);
      if (distribution.a > distribution.b)
        law->Report("high", fmt::format("high >= low = {:g}", distribution.a), fmt::format("{:g}", distribution.b));
    } else if ((word == "normal" || word == "log-normal") && axis.IsNumber()) {
      distribution.law = word == "normal" ? Distribution::Law::kNormal : Distribution::Law::kLogNormal;
      Range mean = range;
      if (word == "log-normal") mean.low = std::max(mean.low, 0.0), mean.low_included = false;
      distribution.a = law->Number("mean", mean);
      distribution.b = law->Number("std", Range::Positive(range.unit));
      distribution.low = law->OptionalNumber("low", range).value_or(range.low);
      distribution.high = law->OptionalNumber("high", range).value_or(range.high);
    } else {
      law->Know({"low", "high", "mean", "std", "values"});
      law->Report("distribution",
                  axis.IsNumber() ? "distribution = uniform, normal, log-normal or choice" : "distribution = choice",
                  "\"" + word + "\"");
    }
    return distribution;
  }

  Campaign* campaign_;
  std::map<std::size_t, std::string> seen_;
  std::set<std::string> hinted_;
};

/// An axis that cannot change anything would multiply the runs for nothing.
void CheckUse(const Campaign& campaign, Table* table) {
  const auto check = [&](std::size_t index) {
    const SweepAxis& axis = SweepAxes()[index];
    const bool used = !axis.is_motion || (axis.is_start ? campaign.kind->UsesStart() : campaign.kind->UsesSpeed());
    if (used) return;
    table->Report("run", fmt::format("axes that runs of kind {} use", campaign.kind->name()), axis.name);
  };
  for (const Campaign::Grid& grid : campaign.grid) check(grid.axis);
  for (const Campaign::Sampled& sampled : campaign.sampled) check(sampled.axis);
}

void CheckSize(const Campaign& campaign, Table* table) {
  double runs = std::max(campaign.samples, 1u);
  for (const Campaign::Grid& grid : campaign.grid) runs *= static_cast<double>(grid.values.size());
  if (runs > kMostRuns)
    table->Report("grid", fmt::format("at most {} runs", static_cast<int>(kMostRuns)), fmt::format("{}", runs));
}

/// Whether the campaign has this axis with a value beside the one that draws nothing.
bool Draws(const Campaign& campaign, const std::string& name, const AxisValue& nothing) {
  const std::size_t axis = *FindAxis(name);
  return std::ranges::any_of(campaign.grid, [axis](const Campaign::Grid& grid) { return grid.axis == axis; }) ||
         (campaign.said[axis] && campaign.base[axis] != nothing);
}

/// Several samples and nothing that is drawn for them would be the same run over and over.
void CheckSamples(const Campaign& campaign, Table* table) {
  if (!campaign.sampled.empty() || campaign.samples <= 1) return;
  if (Draws(campaign, "scatter_percent", 0.0) || Draws(campaign, "draw", "nothing")) return;
  table->Report("sample", "something to draw in [sample], scatter_percent or draw", "nothing");
}

}  // namespace

AxisValue Distribution::Draw(CounterRandom random) const {
  if (law == Law::kChoice) {
    const auto at = static_cast<std::size_t>(random.Uniform() * static_cast<double>(choices.size()));
    return choices[std::min(at, choices.size() - 1)];
  }
  const double ln_variance = std::log1p((b / a) * (b / a));
  constexpr int kDraws = 1000;
  for (int i = 0; i < kDraws; ++i) {
    double value = 0;
    if (law == Law::kUniform) value = a + (b - a) * random.Uniform();
    if (law == Law::kNormal) value = a + b * random.Normal();
    if (law == Law::kLogNormal) value = a * std::exp(std::sqrt(ln_variance) * random.Normal() - 0.5 * ln_variance);
    if (low <= value && value <= high) return value;
  }
  throw std::runtime_error(
      fmt::format("[sample]: expected values from {:g} to {:g}, none of {} draws was", low, high, kDraws));
}

Campaign ReadCampaign(const std::filesystem::path& path) { return ParseCampaign(ReadFileWhole(path), path); }

Campaign ParseCampaign(std::string_view text, const std::filesystem::path& path) {
  Table file = Table::Parse(text, path.string());
  Campaign campaign;
  campaign.text = text;
  campaign.folder = path.parent_path();
  campaign.name = file.String("name");
  constexpr double kLargestSeed = 9007199254740992;  // whole numbers of a double
  campaign.seed =
      file.Has("seed") ? static_cast<std::uint64_t>(AxisReader::ReadWhole(&file, "seed", 0, kLargestSeed)) : 0;
  for (const SweepAxis& axis : SweepAxes()) campaign.base.push_back(axis.fallback);
  campaign.said.assign(SweepAxes().size(), false);
  AxisReader axes(&campaign);
  if (std::optional<Table> base = file.OptionalTable("base")) axes.ReadBase(*base);
  if (std::optional<Table> grid = file.OptionalTable("grid")) axes.ReadGrid(*grid);
  if (std::optional<Table> sample = file.OptionalTable("sample")) axes.ReadSample(*sample);
  std::optional<Table> run = file.OptionalTable("run");
  if (!run && !file.Has("run")) file.Report("run", "a table run", "nothing");
  if (run) campaign.kind = ReadRunKind(&*run);
  if (campaign.kind) CheckUse(campaign, &file);
  CheckSize(campaign, &file);
  CheckSamples(campaign, &file);
  file.Finish();
  return campaign;
}

}  // namespace uiclink
