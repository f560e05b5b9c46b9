#include "vehicle/page/sweep_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "data/checksum.h"
#include "vehicle/sweep/sqlite.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostCurves = 7, kMostColumns = 4, kMostResults = 6;

/// What came out of the runs that are done, by run and result.
struct Results {
  std::vector<ResultColumn> columns;
  std::map<std::size_t, std::vector<double>> rows;  ///< NaN: none
};

Results ReadResults(const SweepPlan& plan, const std::filesystem::path& store) {
  Results results{.columns = plan.campaign().kind->columns(), .rows = {}};
  Sqlite database(store, Sqlite::Mode::kReadOnly);
  std::string names;
  for (const ResultColumn& column : results.columns) names += ", \"" + column.name + "\"";
  SqliteStatement query(&database, "SELECT run" + names + " FROM runs WHERE status = 'done' ORDER BY run");
  while (query.Step()) {
    std::vector<double>& row = results.rows[static_cast<std::size_t>(query.Integer(0))];
    for (int i = 1; i < query.size(); ++i)
      row.push_back(query.IsNull(i)      ? kNone
                    : query.IsInteger(i) ? static_cast<double>(query.Integer(i))
                                         : query.Number(i));
  }
  return results;
}

std::size_t CountDistinct(const Results& results, std::size_t column) {
  std::vector<double> values;
  for (const auto& [run, row] : results.rows)
    if (std::isfinite(row[column])) values.push_back(row[column]);
  std::ranges::sort(values);
  return values.size() - std::ranges::unique(values).size();
}

/// Those that a reader asks for first, and that vary.
std::vector<std::size_t> ChooseResults(const Results& results) {
  std::vector<std::size_t> chosen;
  const auto take = [&](std::size_t i) {
    if (chosen.size() < kMostResults && std::ranges::find(chosen, i) == chosen.end() && CountDistinct(results, i) > 1)
      chosen.push_back(i);
  };
  for (const char* word : {"amplitude_front_lateral", "amplitude_rear_lateral", "amplitude_body_lateral",
                           "frequency_front_lateral", "peak", "minimum_wheel_load"})
    for (std::size_t i = 0; i < results.columns.size(); ++i)
      if (results.columns[i].name.find(word) != std::string::npos) take(i);
  for (std::size_t i = 0; i < results.columns.size(); ++i) take(i);
  return chosen;
}

// ---------------------------------------------------------------- axes

/// How the grid is laid out in figures: indices into Campaign::grid.
struct Layout {
  std::optional<std::size_t> across, curves;
  std::vector<std::size_t> panels;
};

Layout ChooseLayout(const Campaign& campaign) {
  Layout layout;
  const auto count = [&](std::size_t g) { return campaign.grid[g].values.size(); };
  for (std::size_t g = 0; g < campaign.grid.size(); ++g) {
    const bool number = SweepAxes()[campaign.grid[g].axis].IsNumber() && count(g) > 1;
    if (number && (!layout.across || count(g) > count(*layout.across))) layout.across = g;
  }
  for (std::size_t g = 0; g < campaign.grid.size(); ++g) {
    if (g == layout.across || count(g) < 2 || count(g) > kMostCurves) continue;
    if (!layout.curves || count(g) > count(*layout.curves)) layout.curves = g;
  }
  for (std::size_t g = 0; g < campaign.grid.size(); ++g)
    if (g != layout.across && g != layout.curves && count(g) > 1) layout.panels.push_back(g);
  return layout;
}

/// "speed_mm" is "speed" in "mm".
FigureAxis AxisOf(const std::string& name) {
  static const std::vector<std::pair<std::string, std::string>> units{
      {"_mm", "mm"},     {"_mrad", "mrad"}, {"_hz", "Hz"},       {"_N", "N"},  {"_m_per_s", "m/s"},
      {"_per_s", "1/s"}, {"_percent", "%"}, {"_N_per_m", "N/m"}, {"_kN", "kN"}};
  if (name == "speed") return {.label = "speed", .unit = "m/s"};
  for (const auto& [ending, unit] : units)
    if (name.ends_with(ending) && (ending != "_per_s" || !name.ends_with("_m_per_s")))
      return {.label = SpellOut(name.substr(0, name.size() - ending.size())), .unit = unit};
  return {.label = SpellOut(name)};
}

const std::string& NameOf(const Campaign& campaign, std::size_t grid) {
  return SweepAxes()[campaign.grid[grid].axis].name;
}

/// "cargo empty, set set2": the values of a run on these axes of the grid.
std::string DescribePlace(const SweepPlan& plan, const std::vector<std::size_t>& axes, std::size_t run) {
  std::string text;
  const std::vector<std::optional<AxisValue>> values = plan.Values(run);
  for (const std::size_t g : axes) {
    const std::optional<AxisValue>& value = values[plan.campaign().grid[g].axis];
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", SpellOut(NameOf(plan.campaign(), g)),
                        value ? FormatValue(*value) : "-");
  }
  return text;
}

// ---------------------------------------------------------------- figures

double Quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), sorted.size() - 1);
  const std::size_t next = std::min(i + 1, sorted.size() - 1);
  return sorted[i] + (at - static_cast<double>(i)) * (sorted[next] - sorted[i]);
}

/// Values of one curve: by x, all that fell there.
using Curve = std::map<double, std::vector<double>>;
/// panel -> curve -> values, by their names, in the order in which runs come.
struct Gathered {
  std::vector<std::string> panels, curves;
  std::map<std::pair<std::string, std::string>, Curve> values;
};

Gathered Gather(const SweepPlan& plan, const Results& results, const Layout& layout, std::size_t column) {
  Gathered gathered;
  const auto remember = [](const std::string& name, std::vector<std::string>* names) {
    if (std::ranges::find(*names, name) == names->end()) names->push_back(name);
  };
  for (const auto& [run, row] : results.rows) {
    const std::string panel = DescribePlace(plan, layout.panels, run);
    const std::string curve = layout.curves ? DescribePlace(plan, {*layout.curves}, run) : "";
    remember(panel, &gathered.panels);
    remember(curve, &gathered.curves);
    if (!std::isfinite(row[column])) continue;
    double x = 0;
    if (layout.across) x = std::get<double>(*plan.Values(run)[plan.campaign().grid[*layout.across].axis]);
    gathered.values[{panel, curve}][x].push_back(row[column]);
  }
  for (auto& [place, curve] : gathered.values)
    for (auto& [x, values] : curve) std::ranges::sort(values);
  return gathered;
}

FigureColour ColourOf(std::size_t i) { return static_cast<FigureColour>(i % 7); }

/// The median, and with samples the range of 95 %, over x.
void AddCurve(const Curve& curve, const std::string& name, FigureColour colour, FigurePanel* panel) {
  constexpr std::size_t kSpread = 5;  // fewer values have no range
  FigureSeries median{.name = name, .mark = FigureMark::kDisc, .colour = colour};
  FigureSeries low{.line = FigureLine::kDashed, .colour = colour, .width = 1}, high = low;
  for (const auto& [x, values] : curve) {
    median.x.push_back(x);
    median.y.push_back(Quantile(values, 0.5));
    if (values.size() < kSpread) continue;
    for (auto& [series, share] : {std::pair{&low, 0.025}, {&high, 0.975}}) {
      series->x.push_back(x);
      series->y.push_back(Quantile(values, share));
    }
  }
  panel->series.push_back(std::move(median));
  if (!low.x.empty()) panel->series.insert(panel->series.end(), {low, high});
}

/// Without an axis to draw over: shares of runs below a value.
void AddShares(const Curve& curve, const std::string& name, FigureColour colour, FigurePanel* panel) {
  FigureSeries series{.name = name, .colour = colour};
  for (const auto& [x, values] : curve) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      series.x.push_back(values[i]);
      series.y.push_back(100 * (static_cast<double>(i) + 0.5) / static_cast<double>(values.size()));
    }
  }
  panel->series.push_back(std::move(series));
}

void AddPanels(const SweepPlan& plan, const Results& results, const Layout& layout, std::size_t column,
               Figure* figure) {
  const Gathered gathered = Gather(plan, results, layout, column);
  const FigureAxis result = AxisOf(results.columns[column].name);
  const std::size_t count = std::min(gathered.panels.size(), kMostColumns);
  figure->columns = std::max<std::size_t>(count, 1);
  for (std::size_t p = 0; p < count; ++p) {
    const std::string& place = gathered.panels[p];
    FigurePanel panel{.title = place.empty() ? result.label : place};
    panel.x = layout.across ? AxisOf(NameOf(plan.campaign(), *layout.across)) : result;
    panel.y = layout.across ? result : FigureAxis{.label = "runs below", .unit = "%"};
    for (std::size_t c = 0; c < gathered.curves.size(); ++c) {
      const auto found = gathered.values.find({place, gathered.curves[c]});
      if (found == gathered.values.end()) continue;
      (layout.across ? AddCurve : AddShares)(found->second, figure->panels.empty() ? gathered.curves[c] : "",
                                             ColourOf(c), &panel);
    }
    figure->panels.push_back(std::move(panel));
  }
}

Figure MapFigure(const SweepPlan& plan, const Results& results) {
  const Layout layout = ChooseLayout(plan.campaign());
  Figure figure{.title = plan.campaign().name, .width = 1200, .panel_height = 260};
  for (const std::size_t column : ChooseResults(results)) AddPanels(plan, results, layout, column, &figure);
  if (figure.columns == 1 && figure.panels.size() > 1) figure.columns = 2;
  return figure;
}

// ---------------------------------------------------------------- text, tables

TextTable MakeResultTable(const Results& results) {
  TextTable table;
  table.AddColumn("result", TextTable::Align::kLeft);
  table.AddColumn("unit", TextTable::Align::kLeft);
  for (const char* head : {"runs", "least", "2.5 %", "median", "97.5 %", "largest"}) table.AddColumn(head);
  for (std::size_t i = 0; i < results.columns.size(); ++i) {
    std::vector<double> values;
    for (const auto& [run, row] : results.rows)
      if (std::isfinite(row[i])) values.push_back(row[i]);
    if (values.empty()) continue;
    std::ranges::sort(values);
    const FigureAxis axis = AxisOf(results.columns[i].name);
    std::vector<std::string> cells{axis.label, axis.unit, std::to_string(values.size())};
    for (const double share : {0.0, 0.025, 0.5, 0.975, 1.0})
      cells.push_back(fmt::format("{:.5g}", Quantile(values, share)));
    table.AddRow(std::move(cells));
  }
  return table;
}

TextTable MakeAxisTable(const Campaign& campaign) {
  constexpr std::size_t kShown = 12;
  TextTable table;
  table.AddColumn("what varies", TextTable::Align::kLeft);
  table.AddColumn("values", TextTable::Align::kLeft);
  for (const Campaign::Grid& grid : campaign.grid) {
    std::string values;
    for (std::size_t i = 0; i < std::min(kShown, grid.values.size()); ++i)
      values += (i > 0 ? ", " : "") + FormatValue(grid.values[i]);
    if (grid.values.size() > kShown) values += fmt::format(", ... {}", FormatValue(grid.values.back()));
    table.AddRow({SpellOut(SweepAxes()[grid.axis].name), values});
  }
  for (const Campaign::Sampled& sampled : campaign.sampled)
    table.AddRow({SpellOut(SweepAxes()[sampled.axis].name), "drawn"});
  if (campaign.samples > 0) table.AddRow({"samples", std::to_string(campaign.samples)});
  return table;
}

std::string DescribeCounts(const SweepPlan& plan, const StoreCounts& counts) {
  std::string text =
      fmt::format("{} of the {} runs of \"{}\" are done", counts[RunStatus::kDone], plan.size(), plan.campaign().name);
  for (const RunStatus status : {RunStatus::kWheelLift, RunStatus::kDerailed, RunStatus::kFailed})
    if (counts[status] > 0)
      text += fmt::format(", {} {}", counts[status], status == RunStatus::kWheelLift ? "lifted a wheel" : Name(status));
  return text + ".";
}

std::optional<std::size_t> FindColumn(const Results& results, const std::string& name) {
  for (std::size_t i = 0; i < results.columns.size(); ++i)
    if (results.columns[i].name == name) return i;
  return std::nullopt;
}

/// How many runs move, and from which speed on.
std::string DescribeHunting(const SweepPlan& plan, const Results& results, std::size_t column) {
  constexpr double kMoves = 0.5;  // [mm]; smaller motions may be the rest of a start that dies out
  const std::optional<std::size_t> speed = FindAxis("speed");
  std::size_t hunting = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& [run, row] : results.rows) {
    if (!(row[column] > kMoves)) continue;
    ++hunting;
    if (const auto value = plan.Values(run)[*speed]) lowest = std::min(lowest, std::get<double>(*value));
  }
  if (hunting == 0)
    return fmt::format("In none of them the front wheelset moves by more than {:g} mm to either side.", kMoves);
  return fmt::format(
      "In {} of them the front wheelset moves by more than {:g} mm to either side; the lowest speed of "
      "these is {}.",
      hunting, kMoves, FormatSpeedTwice(lowest));
}

std::string DescribeResults(const SweepPlan& plan, const Results& results) {
  if (const auto column = FindColumn(results, "amplitude_front_lateral_mm"))
    return DescribeHunting(plan, results, *column);
  std::vector<double> values;
  for (const auto& [run, row] : results.rows)
    if (!row.empty() && std::isfinite(row[0])) values.push_back(row[0]);
  if (values.empty()) return "";
  std::ranges::sort(values);
  const FigureAxis axis = AxisOf(results.columns[0].name);
  return fmt::format(
      "Over the {} runs that have one, the {} is between {:.4g} and {:.4g}{}; half of them are above {:.4g}.",
      values.size(), axis.label, values.front(), values.back(), axis.unit.empty() ? "" : " " + axis.unit,
      Quantile(values, 0.5));
}

}  // namespace

std::string ComposeSweepPage(const SweepPlan& plan, const std::filesystem::path& file,
                             const std::filesystem::path& store, const PageOrigin& origin) {
  const Results results = ReadResults(plan, store);
  const StoreCounts counts = SweepStore::Count(store);
  WagonBook book("Sweep: " + plan.campaign().name, origin);
  book.Answer(JoinSentences({DescribeCounts(plan, counts), DescribeResults(plan, results)}));
  book.Notices(plan.notices());
  book.page().Table("The campaign, kind " + plan.campaign().kind->name(), MakeAxisTable(plan.campaign()));
  book.page().Heading(2, "Results", "results");
  book.Draw("maps", MapFigure(plan, results),
            plan.campaign().samples > 0 ? "Medians of the samples; dashed: the range of 95 % of them."
                                        : "One mark for each run.");
  book.page().Table("All results over all runs that are done", MakeResultTable(results));
  if (!counts.reasons.empty()) {
    TextTable table;
    table.AddColumn("why runs failed", TextTable::Align::kLeft);
    table.AddColumn("runs");
    for (const auto& [reason, runs] : counts.reasons) table.AddRow({reason, std::to_string(runs)});
    book.page().Table("Failures", table);
  }
  std::vector<InputFile> files{{.role = "campaign",
                                .name = plan.campaign().name,
                                .path = file.string(),
                                .sha256 = CalcSha256(plan.campaign().text)}};
  files.insert(files.end(), plan.files().begin(), plan.files().end());
  return book.Finish(files);
}

}  // namespace uiclink
