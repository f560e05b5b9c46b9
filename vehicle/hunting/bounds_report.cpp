#include "vehicle/hunting/bounds_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "reports/text_table.h"

namespace uiclink {
namespace {

constexpr double kLeastShare = 5e-4;  // smaller ones are not worth a place on a terminal

const char* Name(Sampling sampling) {
  switch (sampling) {
    case Sampling::kRandom:
      return "random";
    case Sampling::kAntithetic:
      return "antithetic";
    case Sampling::kLatinHypercube:
      return "latin-hypercube";
  }
  return "?";
}

bool IsConstant(const ScalarBounds& bounds) { return !(bounds.std.value > 0); }

/// Digits that the bounds are worth: two of the standard deviation.
std::string Number(double value, double std) {
  const int digits = std > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 9) : 4;
  return fmt::format("{:.{}f}", value, digits);
}

std::string NominalText(const ScalarBounds& bounds) {
  return bounds.nominal ? Number(*bounds.nominal, bounds.std.value) : "-";
}

/// Groups by rows, scalars by columns would be wide: a line for each scalar instead, largest share first.
std::string ShareLine(const ScalarBounds& bounds) {
  if (!bounds.exists() || IsConstant(bounds)) return {};
  if (!bounds.shares_reason.empty()) return fmt::format("  {}: no shares, {}\n", bounds.name, bounds.shares_reason);
  std::vector<VarianceShare> groups = bounds.shares.groups;
  std::ranges::stable_sort(groups, std::ranges::greater(), &VarianceShare::share);
  std::string text;
  for (const VarianceShare& group : groups)
    if (std::abs(group.share) >= kLeastShare)
      text += fmt::format("{}{} {:.1f} %", text.empty() ? "" : ", ", group.name, 100 * group.share);
  if (std::abs(bounds.shares.not_linear) >= kLeastShare)
    text += fmt::format("{}not linear {:.1f} %", text.empty() ? "" : ", ", 100 * bounds.shares.not_linear);
  return fmt::format("  {}: {}\n", bounds.name, text);
}

/// Reasons of failed draws, each once with its number.
std::string DescribeFailures(const std::vector<ScalarBounds>& all) {
  std::map<std::string, std::size_t> counts;
  for (const ScalarBounds& bounds : all)
    for (const std::string& reason : bounds.reasons)
      if (!reason.empty()) ++counts[fmt::format("{}: {}", bounds.name, reason)];
  std::string text;
  for (const auto& [reason, count] : counts) text += fmt::format("  {} of the draws failed: {}\n", count, reason);
  return text;
}

Json SharesToJson(const std::vector<VarianceShare>& shares, double not_linear) {
  Json json = Json::object();
  for (const VarianceShare& share : shares) json[share.name] = NumberOrNull(share.share);
  json["not linear"] = NumberOrNull(not_linear);
  return json;
}

Json FailuresToJson(const ScalarBounds& bounds) {
  Json json = Json::array();
  for (std::size_t i = 0; i < bounds.reasons.size(); ++i)
    if (!bounds.reasons[i].empty()) json.push_back({{"draw", i + 1}, {"reason", bounds.reasons[i]}});
  return json;
}

std::string AxisUnit(const ScalarBounds& bounds) { return bounds.unit == "-" ? "" : bounds.unit; }

/// Draws by rank, with the normal distribution of first order beside them where it is known.
FigurePanel DistributionPanel(const ScalarBounds& bounds) {
  FigurePanel panel{.title = bounds.name,
                    .x = {.label = bounds.name, .unit = AxisUnit(bounds)},
                    .y = {.label = "share of draws below", .low = 0, .high = 1}};
  std::vector<double> sorted;
  for (const double value : bounds.values)
    if (std::isfinite(value)) sorted.push_back(value);
  std::ranges::sort(sorted);
  FigureSeries draws{.name = "draws", .mark = FigureMark::kDot};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    draws.x.push_back(sorted[i]);
    draws.y.push_back((static_cast<double>(i) + 0.5) / static_cast<double>(sorted.size()));
  }
  panel.series.push_back(std::move(draws));
  if (bounds.linear_high && bounds.nominal && *bounds.linear_high > *bounds.nominal) {
    const double std = (*bounds.linear_high - *bounds.nominal) / 1.96;
    FigureSeries linear{.name = "first order", .line = FigureLine::kDashed};
    for (double z = -3; z <= 3.001; z += 0.1) {
      linear.x.push_back(*bounds.nominal + z * std);
      linear.y.push_back(0.5 * std::erfc(-z / std::sqrt(2.0)));
    }
    panel.series.push_back(std::move(linear));
  }
  panel.vertical_guides = {{bounds.low.value, "2.5 %"}, {bounds.high.value, "97.5 %"}};
  return panel;
}

/// A bar for each group, from below.
FigurePanel SharesPanel(const ScalarBounds& bounds) {
  FigurePanel panel{.title = "where its variance comes from",
                    .x = {.label = "share of variance", .unit = "%", .high = 180},
                    .y = {.low = 0}};
  std::vector<VarianceShare> bars = bounds.shares.groups;
  std::ranges::stable_sort(bars, std::ranges::greater(), &VarianceShare::share);
  bars.push_back({"not linear", bounds.shares.not_linear});
  panel.y.high = static_cast<double>(bars.size()) + 1;
  double place = static_cast<double>(bars.size());
  for (const VarianceShare& bar : bars) {
    const double percent = std::abs(bar.share) < kLeastShare ? 0 : 100 * bar.share;  // no "-0.0"
    panel.series.push_back({.x = {0, percent}, .y = {place, place}, .colour = FigureColour::kBlue, .width = 9});
    panel.notes.push_back({std::max(percent, 0.0) + 2, place, fmt::format("{} {:.1f} %", bar.name, percent)});
    place -= 1;
  }
  return panel;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace

TextTable MakeBoundsTable(const std::vector<ScalarBounds>& all) {
  TextTable table;
  table.AddColumn("", TextTable::Align::kLeft);
  table.AddColumn("unit", TextTable::Align::kLeft);
  table.AddColumn("value");
  table.AddColumn("mean of\ndraws");
  table.AddColumn("standard\ndeviation");
  table.AddColumn("95 %\nlow");
  table.AddColumn("bounds\nhigh");
  table.AddColumn("error of\nlow");
  table.AddColumn("\nhigh");
  table.AddColumn("draws\nfailed");
  for (const ScalarBounds& b : all) {
    if (!b.exists()) {
      table.AddRow({b.name, b.unit, NominalText(b), "-", "-", "-", "-", "-", "-", std::to_string(b.failed)});
      continue;
    }
    const auto number = [&](double value) { return Number(value, b.std.value); };
    table.AddRow({b.name, b.unit, NominalText(b), number(b.mean.value), number(b.std.value), number(b.low.value),
                  number(b.high.value), number(b.low.error), number(b.high.error), std::to_string(b.failed)});
  }
  return table;
}

std::string DescribeDraws(const SetScatter& scatter) {
  const ScatterOptions& options = scatter.options();
  std::string text = fmt::format("{} draws (seed {}, {}) of {} parameters", scatter.size(), options.seed,
                                 Name(options.sampling), scatter.parameters().size());
  if (options.corner.from_set) {
    text += ", with corner scatter as the sets' spread has it";
  } else if (options.corner.Any()) {
    text += fmt::format(", with corner scatter of {:g} % in k, {:g} % in k_i, {:g} % in T0", 100 * options.corner.k,
                        100 * options.corner.slider_k, 100 * options.corner.slider_T0);
  }
  if (scatter.redrawn() > 0)
    text += fmt::format("; {} points outside of physical bounds were drawn anew", scatter.redrawn());
  return text + ". Wagon, wheels and rails are taken as exact.\n";
}

std::string FormatBounds(const SetScatter& scatter, const std::vector<ScalarBounds>& all) {
  if (all.empty() || all.front().values.empty()) return {};
  std::string text =
      "95 % bounds and what they come from\n" + DescribeDraws(scatter) + "\n" + MakeBoundsTable(all).Format();
  std::string shares;
  for (const ScalarBounds& bounds : all) shares += ShareLine(bounds);
  if (!shares.empty()) text += "\nShares of variance\n" + shares;
  return text + DescribeFailures(all);
}

std::string FormatSpeedBounds(const SetScatter& scatter, const SpeedBounds& bounds) {
  const ScalarBounds& speed = bounds.speed;
  std::string text = FormatBounds(scatter, {speed});
  if (!speed.linear_low) return text;
  const double std = (*speed.linear_high - *speed.linear_low) / (2 * 1.96);
  text += fmt::format("  first order: {} to {} m/s\n", Number(*speed.linear_low, std), Number(*speed.linear_high, std));
  for (const auto& [direction, share] : {std::pair{"lateral", bounds.by_lateral_stiffness},
                                         std::pair{"longitudinal", bounds.by_longitudinal_stiffness}}) {
    if (share > 0) text += fmt::format("  {} k + sum k_i, as one number, explains {:.2f} %\n", direction, 100 * share);
  }
  return text;
}

Json BoundsToJson(const ScalarBounds& bounds) {
  Json json = {{"value", bounds.nominal ? NumberOrNull(*bounds.nominal) : Json(nullptr)}, {"unit", bounds.unit}};
  if (!bounds.nominal) json["reason"] = bounds.nominal_reason;
  const auto sampled = [&](const char* key, const Sampled& s) {
    json[key] = bounds.exists() ? NumberOrNull(s.value) : Json(nullptr);
    json[std::string(key) + "_error"] = bounds.exists() ? NumberOrNull(s.error) : Json(nullptr);
  };
  sampled("low", bounds.low);
  sampled("high", bounds.high);
  sampled("mean", bounds.mean);
  sampled("std", bounds.std);
  if (bounds.linear_low) json["first_order"] = {{"low", *bounds.linear_low}, {"high", *bounds.linear_high}};
  json["draws"] = bounds.values.size();
  json["failed"] = bounds.failed;
  json["failures"] = FailuresToJson(bounds);
  const bool known = bounds.exists() && !IsConstant(bounds) && bounds.shares_reason.empty();
  json["shares"] = known ? SharesToJson(bounds.shares.groups, bounds.shares.not_linear) : Json(nullptr);
  json["shares_by_parameter"] =
      known ? SharesToJson(bounds.shares.parameters, bounds.shares.not_linear) : Json(nullptr);
  return json;
}

Json SpeedBoundsToJson(const SpeedBounds& bounds) {
  Json json = BoundsToJson(bounds.speed);
  json["explained_by_stiffness_sum"] = {{"lateral", bounds.by_lateral_stiffness},
                                        {"longitudinal", bounds.by_longitudinal_stiffness}};
  json["wall_s"] = bounds.wall_s;
  return json;
}

Json ScatterToJson(const SetScatter& scatter) {
  const ScatterOptions& options = scatter.options();
  Json json = {{"draws", options.draws},
               {"seed", options.seed},
               {"sampling", Name(options.sampling)},
               {"coverage", {{"lateral", scatter.coverage()[0]}, {"longitudinal", scatter.coverage()[1]}}},
               {"corner_scatter", options.corner.from_set ? Json("set")
                                                          : Json{{"k", options.corner.k},
                                                                 {"k_i", options.corner.slider_k},
                                                                 {"T0", options.corner.slider_T0}}},
               {"drawn_anew", scatter.redrawn()}};
  json["parameters"] = Json::array();
  for (std::size_t i = 0; i < scatter.parameters().size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    json["parameters"].push_back({{"name", scatter.parameters()[i].name},
                                  {"value", scatter.centre()[at]},
                                  {"std", std::sqrt(scatter.covariance()(at, at))}});
  }
  return json;
}

Figure BoundsFigure(const std::string& title, const std::vector<ScalarBounds>& all) {
  Figure figure{.title = title, .columns = 2, .width = 1200, .panel_height = 300};
  for (const ScalarBounds& bounds : all) {
    if (!bounds.exists() || IsConstant(bounds)) continue;
    figure.panels.push_back(DistributionPanel(bounds));
    figure.panels.push_back(SharesPanel(bounds));
  }
  return figure;
}

std::string FormatDraws(const SetScatter& scatter, const std::vector<ScalarBounds>& all) {
  std::string text = "draw";
  for (const UncertainParameter& parameter : scatter.parameters()) text += ',' + CsvField(parameter.name);
  for (const ScalarBounds& bounds : all)
    text += ',' + CsvField(bounds.unit == "-" ? bounds.name : fmt::format("{} [{}]", bounds.name, bounds.unit));
  text += ",reason\n";
  for (std::size_t i = 0; i < scatter.size() && !scatter.empty(); ++i) {
    text += std::to_string(i + 1);
    for (Eigen::Index j = 0; j < scatter.values().cols(); ++j)
      text += fmt::format(",{}", scatter.values()(static_cast<Eigen::Index>(i), j));
    std::string reason;
    for (const ScalarBounds& bounds : all) {
      text += std::isfinite(bounds.values[i]) ? fmt::format(",{}", bounds.values[i]) : ",";
      if (reason.empty()) reason = bounds.reasons[i];
    }
    text += ',' + CsvField(reason) + '\n';
  }
  return text;
}

}  // namespace uiclink
