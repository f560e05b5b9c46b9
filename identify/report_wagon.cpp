// What identified links do on the wagon, told to an engineer at a terminal and to programs.

#include "identify/report_wagon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/checksum.h"
#include "data/parameter_set_file.h"
#include "identify/extended_covariance.h"
#include "identify/link_coordinates.h"
#include "identify/report_tables.h"
#include "reports/text_table.h"
#include "reports/wrap.h"

namespace uiclink {
namespace {

constexpr std::size_t kColumns = 110;  // of the terminal
constexpr std::size_t kIndent = 2;
using Align = TextTable::Align;

std::string Tell(const std::string& text) { return Paragraph(text, kIndent, kColumns); }

/// Why a direction's values are not to be trusted as they stand; empty when they are.
std::string FindDoubt(const Identification& id, const Diagnosis* diagnosis) {
  if (diagnosis != nullptr && diagnosis->verdict == Verdict::kUnexplained)
    return fmt::format("{}: the model leaves structure in the residuals, and nothing in the catalogue accounts for it",
                       Name(id.direction));
  if (diagnosis != nullptr && diagnosis->verdict == Verdict::kPartlyExplained)
    return fmt::format("{}: structure is left in the residuals beside the named causes", Name(id.direction));
  return id.warnings.empty() ? "" : fmt::format("{}: {}", Name(id.direction), id.warnings.front());
}

/// Of the plain model.
std::optional<RecordValues> CalcRecordValues(const Identification& id) {
  if (id.shared || id.CountUsed() < 2) return std::nullopt;
  RecordValues values{.order = ParameterSymbols(id.sliders), .by_record = {}, .common = {}};
  const std::vector<std::size_t> used = id.UsedIndices();
  const auto size = static_cast<Eigen::Index>(values.order.size());
  values.by_record.resize(static_cast<Eigen::Index>(used.size()), size);
  for (std::size_t r = 0; r < used.size(); ++r)
    for (Eigen::Index q = 0; q < size; ++q)
      values.by_record(static_cast<Eigen::Index>(r), q) = CalcQuantity(id.records[used[r]].link, static_cast<int>(q));
  values.common = Eigen::MatrixXd::Zero(size, size);
  return values;
}

std::optional<RecordValues> CalcRecordValues(const Identification& id, const ExtendedResult& extended) {
  if (extended.sharing == Sharing::kLink || id.CountUsed() < 2) return std::nullopt;
  std::vector<FitData> data;
  for (const std::size_t i : id.UsedIndices()) data.push_back(id.records[i].Data());
  const ExtendedCovariance joint = CalcExtendedCovariance(data, extended);
  if (joint.by_record.size() == 0) return std::nullopt;
  return RecordValues{.order = joint.order, .by_record = joint.by_record, .common = joint.common};
}

}  // namespace

ValidationSet MakeValidationSet(const RunResult& run, bool with_causes, const std::string& file) {
  ValidationSet made{.role = with_causes ? "identified" : "identified_plain",
                     .label = with_causes ? "" : "plain model",
                     .file = file,
                     .sha256 = {},
                     .set = with_causes ? MakeParameterSet(run) : MakePlainParameterSet(run)};
  made.sha256 = CalcSha256(FormatParameterSet(made.set));
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    if (id.CountUsed() == 0) continue;
    const Diagnosis* diagnosis = run.diagnoses.empty() ? nullptr : &run.diagnoses[d];
    const bool extended = with_causes && diagnosis != nullptr && diagnosis->HasCauses();
    made.by_record[static_cast<std::size_t>(id.direction)] =
        extended ? CalcRecordValues(id, diagnosis->extended) : CalcRecordValues(id);
    const std::string doubt = FindDoubt(id, diagnosis);
    if (!doubt.empty()) made.doubt += (made.doubt.empty() ? "" : "; ") + doubt;
  }
  return made;
}

// ---------------------------------------------------------------- for the terminal

namespace {

std::string Mm(double metres) { return fmt::format("{:.2f}", 1e3 * metres); }

std::string NameOf(const ValidationRow& row) { return row.set.label.empty() ? row.set.set.name : row.set.label; }

std::string Label(const ValidationRow& row) { return NameOf(row) + (row.set.doubt.empty() ? "" : " *"); }

/// @param with_type  there is a column for it.
void AddCriticalSpeed(const std::optional<CriticalSpeed>& speed, bool with_type, std::vector<std::string>* cells) {
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
  if (!with_type) return;
  const bool known = speed && !speed->type.empty();
  cells->push_back(known ? speed->type.substr(0, speed->type.find("critical")) : speed && speed->value ? "-" : "");
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

}  // namespace

TextTable MakeWagonTable(const Validation& validation) {
  TextTable table;
  table.AddColumn("set", Align::kLeft);
  table.AddColumn("critical\n[m/s]");
  table.AddColumn("95 %\nlow");
  table.AddColumn("bounds\nhigh");
  table.AddColumn("\n[Hz]");
  if (validation.options.side_by_side) table.AddColumn("\ntype", Align::kLeft);
  table.AddColumn("hunting\nfront [mm]");
  table.AddColumn("\nrear");
  table.AddColumn("\nbody");
  table.AddColumn("\n[Hz]");
  table.AddColumn("impacts\nfront + rear");
  table.AddColumn("peak\n[kN]");
  table.AddColumn("wheel load\nleast [kN]");
  for (const ValidationRow& row : validation.rows) {
    std::vector<std::string> cells{Label(row)};
    AddCriticalSpeed(row.critical_speed, validation.options.side_by_side, &cells);
    AddHunting(row.hunting, &cells);
    table.AddRow(std::move(cells));
  }
  return table;
}

namespace {

using Words = std::vector<std::string>;  // a paragraph each

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
void DescribeRows(const Validation& validation, Words* words) {
  if (HasPlain(validation)) words->emplace_back("Plain model: the link that was identified without the named causes.");
  words->push_back(
      fmt::format("Critical: linear critical speed, above which straight running is unstable, and the frequency "
                  "there.{}{}",
                  DescribeBounds(validation),
                  validation.options.side_by_side
                      ? " Type: hunting sets in gently (super, supercritical) or with a jump (sub); of the cycle of "
                        "0.1 mm that is born there."
                      : ""));
  words->push_back(
      fmt::format("Hunting: at {:g} m/s, both wheelsets put {:g} mm beside the running equilibrium; amplitudes "
                  "(half of peak to peak), impacts on the lateral guidance and the least wheel load are of the "
                  "last {:g} of {:g} s.",
                  validation.options.speed, 1e3 * kHuntingStart, kHuntingWindow, kHuntingDuration));
}

/// Sets with the same notice share a paragraph.
void DescribeNotices(const Validation& validation, Words* words) {
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
  for (const auto& [notice, names] : lines) words->push_back(fmt::format("{}: {}.", names, notice));
}

/// What has to be said about one set.
void DescribeRemarks(const ValidationRow& row, Words* words) {
  const std::string name = NameOf(row);
  if (!row.set.doubt.empty())
    words->push_back(fmt::format("* {}: not to be trusted as it stands. {}.", name, row.set.doubt));
  if (row.hunting && row.hunting->longitudinal_impacts > 0)
    words->push_back(
        fmt::format("{}: {} impacts on the longitudinal guidance.", name, row.hunting->longitudinal_impacts));
  if (row.hunting && !row.hunting->end_reason.empty())
    words->push_back(fmt::format("{}: the hunting run ended after {:.2f} s: {}.", name, row.hunting->simulated,
                                 row.hunting->end_reason));
  if (row.critical_speed && !row.critical_speed->type_reason.empty())
    words->push_back(
        fmt::format("{}: no type of the critical speed was found ({}).", name, row.critical_speed->type_reason));
  for (const std::string& failure : row.failures) words->push_back(fmt::format("{}: failed: {}.", name, failure));
}

/// Plain against extended, a paragraph each.
void DescribeCauseCost(const Validation& validation, Words* words) {
  if (validation.cause_cost.empty()) return;
  words->emplace_back("What it costs not to name the missing cause, plain less extended model (95 %):");
  for (const CauseCost& cost : validation.cause_cost) {
    const std::string what =
        fmt::format("- {}: {:+.4f} +- {:.4f} {}", cost.name, cost.difference(), cost.half(), cost.unit);
    words->push_back(cost.paired_half
                         ? fmt::format("{}, from the two models' difference record by record (as if errors were "
                                       "independent: +- {:.4f})",
                                       what, cost.independent())
                         : fmt::format("{} at most, as if errors were independent (wholly correlated, as the "
                                       "same records make them nearly: +- {:.4f})",
                                       what, cost.narrowest_half()));
  }
}

/// Each set against the first.
std::string FormatDifferences(const Validation& validation) {
  if (!validation.options.side_by_side) return {};
  const std::vector<SpeedDifference> differences = CalcSpeedDifferences(validation.rows);
  if (differences.empty()) return {};
  TextTable table;
  table.AddColumn(fmt::format("critical speed less that of {}", NameOf(validation.rows.front())), Align::kLeft);
  table.AddColumn("difference\n[m/s]");
  table.AddColumn("95 %: +-\nindependent");
  table.AddColumn("\ncorrelated");
  const auto half = [](const std::optional<double>& value) { return value ? fmt::format("{:.4f}", *value) : "-"; };
  for (const SpeedDifference& d : differences)
    table.AddRow({NameOf(validation.rows[d.row]), fmt::format("{:+.4f}", d.difference), half(d.half),
                  half(d.half_if_correlated)});
  return "\n" + table.Format(kIndent) +
         Tell(
             "Independent: the errors of the two sets have nothing to do with each other, which holds for different "
             "records. Correlated: wholly so, the least that it can be, which comes near for plain and extended model "
             "of the same records; the files do not hold the records that it would take to know, identify has them "
             "and tells. A set without covariance counts as exact.");
}

/// "identified: front lateral amplitude 0.62 +- 0.01 mm, ..."
void DescribeHuntingBounds(const Validation& validation, const ValidationRow& row, Words* words) {
  if (!validation.options.side_by_side || row.hunting_bounds.empty()) return;
  std::string text;
  for (const HuntingBound& bound : row.hunting_bounds) {
    if (bound.value == 0 && bound.half == 0) continue;  // no impacts in any draw
    text += fmt::format("{}{} {:.3f} +- {:.3f}{}", text.empty() ? "" : ", ", bound.name, bound.value, bound.half,
                        bound.unit == "-" ? "" : " " + bound.unit);
  }
  words->push_back(fmt::format("{}: hunting, 95 % of {} draws that run on from it for {:g} s: {}.", NameOf(row),
                               validation.options.hunting_draws, 2 * kHuntingWindow, text));
}

/// Where the bounds of the critical speed come from.
void DescribeShares(const ValidationRow& row, Words* words) {
  if (!row.critical_speed || row.critical_speed->shares.empty()) return;
  std::string text;
  for (const SpeedShare& share : row.critical_speed->shares)
    if (std::abs(share.share) >= 5e-4)
      text += fmt::format("{}{} {:.1f} %", text.empty() ? "" : ", ", share.group, 100 * share.share);
  words->push_back(fmt::format("{}: variance of the critical speed: {}.", NameOf(row), text));
}

}  // namespace

std::vector<std::string> DescribeWagon(const Validation& validation) {
  Words words;
  DescribeRows(validation, &words);
  for (const ValidationRow& row : validation.rows) {
    DescribeShares(row, &words);
    DescribeHuntingBounds(validation, row, &words);
    DescribeRemarks(row, &words);
  }
  DescribeCauseCost(validation, &words);
  DescribeNotices(validation, &words);
  for (const std::string& notice : validation.notices) words.push_back("Note: " + notice + ".");
  return words;
}

std::string FormatWagon(const Validation& validation) {
  if (!validation.failure.empty())
    return Tell(fmt::format("On the wagon: nothing could be done. {}", validation.failure)) + "\n";
  std::string text =
      fmt::format("On the wagon ({}, {}, geometry {})\n\n", validation.wagon, validation.cargo, validation.geometry);
  text += MakeWagonTable(validation).Format(kIndent) + FormatDifferences(validation) + "\n";
  for (const std::string& words : DescribeWagon(validation)) text += Tell(words);
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

}  // namespace uiclink
