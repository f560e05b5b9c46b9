// The identified link on the wagon, and everything that it takes to repeat the run.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/page/view.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

std::string NameOf(const ValidationRow& row) { return row.set.label.empty() ? row.set.set.name : row.set.label; }

void DrawSpeeds(const Validation& validation, Book* book) {
  FigurePanel panel{.title = "linear critical speed",
                    .x = {.label = "speed", .unit = "m/s"},
                    .y = {.numbers = false, .low = 0.3, .high = static_cast<double>(validation.rows.size()) + 0.7}};
  std::vector<double> speed, place, low, high;
  FigureSeries bounds = MakeLine("95 %, from the link's uncertainty", {}, {}, kExtendedColour, FigureLine::kSolid, 2.5);
  for (std::size_t i = 0; i < validation.rows.size(); ++i) {
    const ValidationRow& row = validation.rows[i];
    if (!row.critical_speed || !row.critical_speed->value) continue;
    const double at = static_cast<double>(validation.rows.size() - i), v = *row.critical_speed->value;
    speed.push_back(v);
    place.push_back(at);
    panel.notes.push_back({.x = row.critical_speed->high.value_or(v), .y = at, .text = NameOf(row)});
    if (!row.critical_speed->low || !row.critical_speed->high) continue;
    bounds.x.insert(bounds.x.end(), {*row.critical_speed->low, *row.critical_speed->high, std::nan("")});
    bounds.y.insert(bounds.y.end(), {at, at, std::nan("")});
  }
  if (speed.empty()) return;
  const auto [least, most] = std::ranges::minmax(speed);
  panel.x.low = std::min(0.9 * least, least - 0.5);
  panel.x.high = most + std::max(1.0, 0.35 * (most - *panel.x.low));  // room for the names
  if (!bounds.x.empty()) panel.series.push_back(std::move(bounds));
  panel.series.push_back(MakeMarks("linear critical speed", speed, place, kMeasuredColour, FigureMark::kDisc));
  Figure figure{.title = "on the wagon", .panels = {panel}, .panel_height = 220};
  book->Draw("wagon_speed", figure, "Linear critical speed of the wagon on each set of parameters.");
}

/// Paragraphs; those that begin with a dash are rows under the one before.
void TellWithLists(const std::vector<std::string>& words, Book* book) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::vector<HtmlPage::Cells> rows;
    for (std::size_t j = i + 1; j < words.size() && words[j].starts_with("- "); ++j)
      rows.push_back({{.text = words[j].substr(2)}});
    if (rows.empty()) {
      book->page().Paragraph(words[i]);
    } else {
      book->page().Table(words[i], {}, rows);
    }
    i += rows.size();
  }
}

void AddPairs(const std::string& caption, const std::vector<std::pair<std::string, std::string>>& pairs, Book* book) {
  std::vector<HtmlPage::Cells> rows;
  for (const auto& [name, value] : pairs) rows.push_back({{.text = name}, {.text = value}});
  book->page().Table(caption, {}, rows);
}

void AddOptions(const Provenance& provenance, Book* book) {
  std::vector<std::pair<std::string, std::string>> given;
  std::string others;
  for (const auto& [name, value] : provenance.options) {
    if (value.empty()) {
      others += (others.empty() ? "" : ", ") + name;
    } else {
      given.emplace_back(name, value);
    }
  }
  if (!others.empty()) given.emplace_back("not given", others);
  AddPairs("Options, defaults included", given, book);
  book->page().Paragraph(
      "Whatever else is drawn at random (errors of read-outs, draws on the wagon) has seeds that do not change: the "
      "same "
      "files and options give the same values, on any number of threads.",
      "quiet");
}

}  // namespace

void AddWagon(const RunResult& run, Book* book) {
  book->page().Heading(2, "On the wagon", "wagon");
  if (!run.wagon) {
    book->page().Paragraph("No run on the wagon was asked for (--no-wagon).", "quiet");
    return;
  }
  const Validation& validation = *run.wagon;
  if (!validation.failure.empty() || validation.rows.empty()) {
    book->page().Paragraph("Nothing could be done: " + validation.failure, "warning");
    return;
  }
  DrawSpeeds(validation, book);
  book->Show(MakeWagonTable(validation),
             fmt::format("{}, {}, geometry {}", validation.wagon, validation.cargo, validation.geometry));
  TellWithLists(DescribeWagon(validation), book);
}

void AddProvenance(const RunResult& run, std::span<const ValidationSet> sets, const Provenance& provenance,
                   Book* book) {
  book->page().Heading(2, "To repeat it", "repeat");
  book->page().Code(provenance.command);
  AddPairs("The run", {{"program", "uiclink identify " UICLINK_VERSION}, {"report written", provenance.written}}, book);
  AddOptions(provenance, book);
  const std::vector<HtmlPage::Cells> head{{{.text = "file"}, {.text = "what it is"}, {.text = "SHA-256"}}};
  std::vector<HtmlPage::Cells> rows;
  for (const Provenance::Input& input : provenance.inputs)
    rows.push_back({{.text = input.file},
                    {.text = "record"},
                    {.text = input.sha256.empty() ? "could not be read" : input.sha256}});
  if (run.wagon)
    for (const ValidationFile& file : run.wagon->files)
      rows.push_back({{.text = file.file}, {.text = file.role + ": " + file.name}, {.text = file.sha256}});
  book->page().Table("What went in", head, rows);
  rows.clear();
  for (const ValidationSet& set : sets)
    rows.push_back({{.text = set.file}, {.text = "parameter set: " + set.set.name}, {.text = set.sha256}});
  if (!rows.empty()) book->page().Table("What came out for the wagon", head, rows);
  book->page().Paragraph(
      "Beside this page: result.json (every number), residuals.csv (every fitted sample), figures/ "
      "(SVG, PNG and CSV of every figure).",
      "quiet");
}

}  // namespace uiclink
