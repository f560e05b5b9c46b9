// What identified links do on the wagon, told to an engineer at a terminal and to programs.

#include "identify/report_wagon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "data/checksum.h"
#include "data/parameter_set_file.h"
#include "identify/link_coordinates.h"
#include "reports/text_table.h"
#include "reports/wrap.h"

namespace uiclink {
namespace {

constexpr std::size_t kColumns = 110;  // of the terminal
constexpr std::size_t kIndent = 2;
using Align = TextTable::Align;

std::string Tell(const std::string& text) { return Paragraph(text, kIndent, kColumns); }

/// Half of the 95 % interval over the standard deviation, on the logarithmic scale on which the fit makes both.
double CalcCoverage(const Estimate& estimate) {
  if (!(estimate.std > 0 && estimate.value > 0 && estimate.low > 0)) return 0;
  return 0.5 * std::log(estimate.high / estimate.low) * estimate.value / estimate.std;
}

/// Why a direction's values are not to be trusted as they stand; empty when they are.
std::string FindDoubt(const Identification& id, const Diagnosis* diagnosis) {
  if (diagnosis != nullptr && diagnosis->verdict == Verdict::kUnexplained)
    return fmt::format("{}: the model leaves structure in the residuals, and nothing in the catalogue accounts for it",
                       Name(id.direction));
  if (diagnosis != nullptr && diagnosis->verdict == Verdict::kPartlyExplained)
    return fmt::format("{}: structure is left in the residuals beside the named causes", Name(id.direction));
  return id.warnings.empty() ? "" : fmt::format("{}: {}", Name(id.direction), id.warnings.front());
}

}  // namespace

ValidationSet MakeValidationSet(const RunResult& run, bool with_causes, const std::string& file) {
  ValidationSet made{.role = with_causes ? "identified" : "identified_plain",
                     .file = file,
                     .sha256 = {},
                     .set = with_causes ? MakeParameterSet(run) : MakePlainParameterSet(run)};
  made.sha256 = CalcSha256(FormatParameterSet(made.set));
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    if (id.CountUsed() == 0) continue;
    const Diagnosis* diagnosis = run.diagnoses.empty() ? nullptr : &run.diagnoses[d];
    const bool extended = with_causes && diagnosis != nullptr && diagnosis->HasCauses();
    const std::vector<Estimate>& quantities = extended ? diagnosis->extended.quantities : id.quantities;
    // These two make the stiffness that counts; never less than a fit that knows its errors.
    double& coverage = made.coverage[static_cast<std::size_t>(id.direction)];
    for (const int q : {0, SumOfStiffness(id.sliders)})
      coverage = std::max(coverage, CalcCoverage(quantities[static_cast<std::size_t>(q)]));
    const std::string doubt = FindDoubt(id, diagnosis);
    if (!doubt.empty()) made.doubt += (made.doubt.empty() ? "" : "; ") + doubt;
  }
  return made;
}

// ---------------------------------------------------------------- for the terminal

namespace {

std::string Mm(double metres) { return fmt::format("{:.2f}", 1e3 * metres); }

std::string NameOf(const ValidationRow& row) {
  return row.set.role == "identified_plain" ? "plain model" : row.set.set.name;
}

std::string Label(const ValidationRow& row) { return NameOf(row) + (row.set.doubt.empty() ? "" : " *"); }

void AddCriticalSpeed(const std::optional<CriticalSpeed>& speed, std::vector<std::string>* cells) {
  if (!speed) {
    cells->insert(cells->end(), {"failed", "", "", ""});
  } else if (!speed->value) {
    const std::string none = speed->unstable_from_start ? "none stable" : fmt::format("> {:g}", speed->searched_to);
    cells->insert(cells->end(), {none, "", "", ""});
  } else {
    const auto format = [](const std::optional<double>& v) { return v ? fmt::format("{:.3f}", *v) : "-"; };
    cells->insert(cells->end(), {format(speed->value), format(speed->low), format(speed->high),
                                 fmt::format("{:.2f}", speed->frequency_hz)});
  }
}

void AddHunting(const std::optional<HuntingRun>& run, std::vector<std::string>* cells) {
  if (!run) {
    cells->emplace_back("failed");
    return;
  }
  if (!run->end_reason.empty()) {  // what it did until then is told below
    cells->emplace_back(run->derailed ? "derailed" : run->wheel_lift ? "wheel lift" : "ended");
    return;
  }
  cells->insert(cells->end(), {Mm(run->wheelset_amplitude[0]), Mm(run->wheelset_amplitude[1]), Mm(run->body_amplitude),
                               run->frequency_hz ? fmt::format("{:.2f}", *run->frequency_hz) : "-",
                               fmt::format("{} + {}", run->impacts[0], run->impacts[1]),
                               fmt::format("{:.1f}", 1e-3 * run->peak_impact),
                               fmt::format("{:.1f}", 1e-3 * run->minimum_wheel_load)});
}

std::string FormatTable(const Validation& validation) {
  TextTable table;
  table.AddColumn("set", Align::kLeft);
  table.AddColumn("critical\n[m/s]");
  table.AddColumn("95 %\nlow");
  table.AddColumn("bounds\nhigh");
  table.AddColumn("\n[Hz]");
  table.AddColumn("hunting\nfront [mm]");
  table.AddColumn("\nrear");
  table.AddColumn("\nbody");
  table.AddColumn("\n[Hz]");
  table.AddColumn("impacts\nfront + rear");
  table.AddColumn("peak\n[kN]");
  table.AddColumn("wheel load\nleast [kN]");
  for (const ValidationRow& row : validation.rows) {
    std::vector<std::string> cells{Label(row)};
    AddCriticalSpeed(row.critical_speed, &cells);
    AddHunting(row.hunting, &cells);
    table.AddRow(std::move(cells));
  }
  return table.Format(kIndent);
}

std::string DescribeBounds(const Validation& validation) {
  const bool any = std::ranges::any_of(validation.rows, [](const ValidationRow& row) {
    return row.critical_speed && row.critical_speed->high.has_value();
  });
  return any ? " Its bounds hold the uncertainty of the identified parameters, to first order; wagon, wheels and rails "
               "are taken as exact."
             : "";
}

bool HasPlain(const Validation& validation) {
  return std::ranges::any_of(validation.rows,
                             [](const ValidationRow& row) { return row.set.role == "identified_plain"; });
}

/// What rows and columns mean.
std::string FormatExplanation(const Validation& validation) {
  std::string text;
  if (HasPlain(validation)) text += Tell("Plain model: the link that was identified without the named causes.");
  text +=
      Tell(fmt::format("Critical: linear critical speed, above which straight running is unstable, and the frequency "
                       "there.{}",
                       DescribeBounds(validation)));
  return text +
         Tell(fmt::format("Hunting: at {:g} m/s, both wheelsets put {:g} mm beside the running equilibrium; amplitudes "
                          "(half of peak to peak), impacts on the lateral guidance and the least wheel load are of the "
                          "last {:g} of {:g} s.",
                          validation.options.speed, 1e3 * kHuntingStart, kHuntingWindow, kHuntingDuration));
}

/// Sets with the same notice share a line.
std::string FormatNotices(const Validation& validation) {
  std::vector<std::pair<std::string, std::string>> lines;  // notice, names
  for (const ValidationRow& row : validation.rows) {
    for (const std::string& notice : row.notices) {
      const auto line = std::ranges::find(lines, notice, &std::pair<std::string, std::string>::first);
      if (line == lines.end()) {
        lines.emplace_back(notice, NameOf(row));
      } else {
        line->second += ", " + NameOf(row);
      }
    }
  }
  std::string text;
  for (const auto& [notice, names] : lines) text += Tell(fmt::format("{}: {}.", names, notice));
  return text;
}

/// What has to be said about one set.
std::string FormatRemarks(const ValidationRow& row) {
  std::string text;
  const std::string name = NameOf(row);
  if (!row.set.doubt.empty())
    text += Tell(fmt::format("* {}: not to be trusted as it stands. {}.", name, row.set.doubt));
  if (row.hunting && row.hunting->longitudinal_impacts > 0)
    text += Tell(fmt::format("{}: {} impacts on the longitudinal guidance.", name, row.hunting->longitudinal_impacts));
  if (row.hunting && !row.hunting->end_reason.empty())
    text += Tell(fmt::format("{}: the hunting run ended after {:.2f} s: {}.", name, row.hunting->simulated,
                             row.hunting->end_reason));
  for (const std::string& failure : row.failures) text += Tell(fmt::format("{}: failed: {}.", name, failure));
  return text;
}

}  // namespace

std::string FormatWagon(const Validation& validation) {
  if (!validation.failure.empty())
    return Tell(fmt::format("On the wagon: nothing could be done. {}", validation.failure)) + "\n";
  std::string text =
      fmt::format("On the wagon ({}, {}, geometry {})\n\n", validation.wagon, validation.cargo, validation.geometry);
  text += FormatTable(validation) + "\n" + FormatExplanation(validation);
  for (const ValidationRow& row : validation.rows) text += FormatRemarks(row);
  text += FormatNotices(validation);
  for (const std::string& notice : validation.notices) text += Tell("Note: " + notice + ".");
  return text + fmt::format("\n  {:.2f} s\n\n", validation.wall_s);
}

std::vector<std::string> FormatWagonFailures(const Validation& validation) {
  std::vector<std::string> lines;
  if (!validation.failure.empty())
    lines.push_back(fmt::format("on the wagon: nothing could be done: {}", validation.failure));
  for (const ValidationRow& row : validation.rows)
    for (const std::string& failure : row.failures)
      lines.push_back(fmt::format("on the wagon: {} ({}): {}", row.set.set.name, row.set.file, failure));
  return lines;
}

// ---------------------------------------------------------------- for programs

namespace {

Json ValueOrNull(const std::optional<double>& value) { return value ? OrNull(*value) : Json(nullptr); }

Json SpeedToJson(const std::optional<CriticalSpeed>& speed) {
  if (!speed) return {{"value", nullptr}, {"low", nullptr}, {"high", nullptr}};
  Json json = {
      {"value", ValueOrNull(speed->value)}, {"low", ValueOrNull(speed->low)}, {"high", ValueOrNull(speed->high)}};
  json["frequency_hz"] = speed->value ? Json(speed->frequency_hz) : Json(nullptr);
  json["searched_to"] = speed->searched_to;
  if (speed->unstable_from_start) json["unstable_from_start"] = true;
  for (const SpeedSensitivity& s : speed->sensitivities)
    json["sensitivities"][Name(s.direction)][s.symbol] = OrNull(s.derivative);
  return json;
}

Json HuntingToJson(const HuntingRun& run) {
  return {{"amplitude_mm",
           {{"front_lateral", 1e3 * run.wheelset_amplitude[0]},
            {"rear_lateral", 1e3 * run.wheelset_amplitude[1]},
            {"body_lateral", 1e3 * run.body_amplitude}}},
          {"frequency_hz", ValueOrNull(run.frequency_hz)},
          {"impacts",
           {{"front_lateral", run.impacts[0]},
            {"rear_lateral", run.impacts[1]},
            {"longitudinal", run.longitudinal_impacts},
            {"peak_N", run.peak_impact}}},
          {"minimum_wheel_load_N", OrNull(run.minimum_wheel_load)},
          {"wheel_lift", run.wheel_lift},
          {"derailed", run.derailed},
          {"simulated_s", run.simulated},
          {"end_reason", run.end_reason.empty() ? Json(nullptr) : Json(run.end_reason)}};
}

Json RowToJson(const ValidationRow& row) {
  Json json = {{"role", row.set.role},
               {"name", row.set.set.name},
               {"set", row.set.file},
               {"sha256", row.set.sha256},
               {"trustworthy", row.set.doubt.empty()},
               {"linear_critical_speed", SpeedToJson(row.critical_speed)},
               {"hunting", row.hunting ? HuntingToJson(*row.hunting) : Json(nullptr)},
               {"notices", row.notices},
               {"failures", row.failures}};
  if (!row.set.doubt.empty()) json["doubt"] = row.set.doubt;
  return json;
}

Json InputsToJson(const Validation& validation) {
  Json files = Json::array();
  for (const ValidationFile& file : validation.files)
    files.push_back({{"role", file.role}, {"name", file.name}, {"file", file.file}, {"sha256", file.sha256}});
  return {{"files", files}};
}

}  // namespace

Json WagonToJson(const Validation& validation) {
  const ValidationRow* const first = validation.rows.empty() ? nullptr : &validation.rows.front();
  Json json = {{"set", first != nullptr ? Json(first->set.file) : Json(nullptr)},
               {"cargo", validation.options.cargo},
               {"geometry", validation.options.geometry},
               {"linear_critical_speed", SpeedToJson(first != nullptr ? first->critical_speed : std::nullopt)},
               {"trustworthy", first != nullptr && first->set.doubt.empty() && validation.Complete()},
               {"hunting_run",
                {{"speed", validation.options.speed},
                 {"start_mm", {{"front_lateral", 1e3 * kHuntingStart}, {"rear_lateral", 1e3 * kHuntingStart}}},
                 {"duration_s", kHuntingDuration},
                 {"window_s", kHuntingWindow}}},
               {"failure", validation.failure.empty() ? Json(nullptr) : Json(validation.failure)}};
  json["sets"] = Json::array();
  for (const ValidationRow& row : validation.rows) json["sets"].push_back(RowToJson(row));
  json["inputs"] = InputsToJson(validation);
  json["notices"] = validation.notices;
  json["wall_s"] = validation.wall_s;
  return json;
}

}  // namespace uiclink
