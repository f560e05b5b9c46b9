#include "vehicle/reproduce/pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "reports/html_page.h"

namespace uiclink::reproduce {
namespace {

using Cells = HtmlPage::Cells;

std::string FileOf(const std::string& section) { return section + ".html"; }

const char* StyleOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMet:
      return "met";
    case Verdict::kExplained:
    case Verdict::kOtherGeometry:
      return "explained";
    case Verdict::kUnexplained:
      return "unexplained";
    default:
      return "number";
  }
}

/// Why ours differs, once for all geometries that have the same reason.
class Reasons {
 public:
  void Add(const std::string& geometry, const Comparison& comparison) {
    if (comparison.verdict == Verdict::kMet || comparison.verdict == Verdict::kNotCompared) return;
    std::string text = comparison.verdict == Verdict::kUnexplained ? "Unexplained. " : "";
    text += comparison.why;
    const auto same = std::ranges::find(said_, text, &std::pair<std::string, std::string>::second);
    if (same != said_.end()) {
      same->first += ", " + geometry;
    } else if (!text.empty()) {
      said_.emplace_back(geometry, text);
    }
  }
  std::string Format() const {
    std::string all;
    for (const auto& [geometries, text] : said_)
      all += fmt::format("{}{}: {}", all.empty() ? "" : " ", geometries, text);
    return all;
  }

 private:
  std::vector<std::pair<std::string, std::string>> said_;
};

std::vector<Cells> TableHead(const Reproduction& reproduction) {
  Cells first{{"figure"}, {"theirs"}, {"where"}}, second{{""}, {""}, {""}};
  for (const std::string& geometry : reproduction.geometries) {
    first.push_back({geometry, "", 2});
    second.push_back({"ours"});
    second.push_back({"difference"});
  }
  first.push_back({"why"});
  second.push_back({""});
  return {first, second};
}

/// The result that a statement is about; with `than`, its value over that of another item on the same geometry.
std::optional<ItemResult> FindFor(const Statement& statement, const std::string& geometry,
                                  const Reproduction& reproduction) {
  const ItemResult* const result = reproduction.Find(geometry, statement.item);
  if (result == nullptr || statement.than.empty()) return result != nullptr ? std::optional(*result) : std::nullopt;
  const ItemResult* const other = reproduction.Find(geometry, statement.than);
  const std::string& key = statement.row.value;
  if (other == nullptr || !result->values.contains(key) || !other->values.contains(key)) return std::nullopt;
  const double* const value = std::get_if<double>(&result->values.at(key));
  const double* const base = std::get_if<double>(&other->values.at(key));
  ItemResult ratio;
  ratio.values[key] = value != nullptr && base != nullptr ? Value(*value / *base) : Value();
  return ratio;
}

/// @param find  the result on a geometry.
template <typename Find>
Cells TableRow(const Row& row, const Reproduction& reproduction, Find find) {
  Cells cells{{row.what}, {row.theirs}, {row.place}};
  Reasons reasons;
  for (const std::string& geometry : reproduction.geometries) {
    const Comparison comparison = Compare(row, geometry, find(geometry));
    cells.push_back({comparison.ours, "number"});
    std::string difference = comparison.difference;
    if (comparison.verdict != Verdict::kNotCompared)
      difference += (difference.empty() ? "" : ", ") + std::string(VerdictName(comparison.verdict));
    cells.push_back({difference.empty() ? "-" : difference, StyleOf(comparison.verdict)});
    reasons.Add(geometry, comparison);
  }
  cells.push_back({reasons.Format()});
  return cells;
}

std::string JoinWords(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

/// An element's id: letters, digits and '-', a letter first.
std::string MakeChartId(std::string item, std::size_t geometry, std::size_t picture) {
  for (char& c : item)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '-';
  return fmt::format("chart-{}-{}-{}", item, geometry + 1, picture + 1);
}

/// What was run on each geometry, once where it is the same.
void AppendTask(const Item& item, const Reproduction& reproduction, HtmlPage* page) {
  std::vector<std::string> said;
  for (const std::string& geometry : reproduction.geometries) {
    Task task = TaskOn(item, geometry);
    if (reproduction.quick) task = Quicken(task);
    const std::string text = Describe(task);
    if (std::ranges::find(said, text) != said.end()) continue;
    page->Paragraph(said.empty() ? "Run: " + text + "." : fmt::format("Run on {}: {}.", geometry, text), "quiet");
    said.push_back(text);
  }
  const std::string command = CommandOf(item, reproduction.geometries.front());
  if (!command.empty() && !reproduction.quick) page->Code(command);
}

void AppendItem(const Item& item, const Reproduction& reproduction, HtmlPage* page) {
  page->Heading(2, item.title, item.id);
  if (!item.covers.empty()) page->Paragraph("Regenerates " + JoinWords(item.covers) + ".");
  AppendTask(item, reproduction, page);
  std::vector<Cells> rows;
  const auto find = [&](const std::string& geometry) { return reproduction.Find(geometry, item.id); };
  for (const Row& row : item.rows) rows.push_back(TableRow(row, reproduction, find));
  page->Table("Ours beside theirs", TableHead(reproduction), rows);
  if (!item.note.empty()) page->Paragraph(item.note);
  for (std::size_t number = 0; number < reproduction.geometries.size(); ++number) {
    const std::string& geometry = reproduction.geometries[number];
    const ItemResult* const result = reproduction.Find(geometry, item.id);
    if (result == nullptr) continue;
    for (const std::string& notice : result->notices) page->Paragraph(geometry + ": " + notice, "warning");
    for (std::size_t i = 0; i < result->pictures.size(); ++i) {
      const Picture& picture = result->pictures[i];
      page->StoredChart(picture.chart, picture.svg, MakeChartId(item.id, number, i), geometry + ": " + picture.title);
    }
  }
}

void AppendState(const Reproduction& reproduction, HtmlPage* page) {
  if (reproduction.quick)
    page->Paragraph("Quick: runs are cut short, to look at the pages. None of these figures is a result.", "warning");
  if (reproduction.interrupted) page->Paragraph("Interrupted: some items have not been computed yet.", "warning");
}

void AppendGeometries(const Reproduction& reproduction, HtmlPage* page) {
  std::vector<Cells> rows;
  for (const std::string& geometry : reproduction.geometries)
    rows.push_back({{geometry}, {reproduction.geometry_words.at(geometry)}});
  page->Table("Wheels on rails", {{{"geometry"}, {"what it is"}}}, rows);
}

void AppendCounts(const Reproduction& reproduction, HtmlPage* page) {
  Cells head{{"geometry"}};
  for (int v = 0; v < static_cast<int>(kVerdicts); ++v)
    head.push_back({static_cast<Verdict>(v) == Verdict::kNotCompared ? "nothing published"
                                                                     : VerdictName(static_cast<Verdict>(v))});
  std::vector<Cells> rows;
  for (const std::string& geometry : reproduction.geometries) {
    Cells cells{{geometry}};
    for (const std::size_t count : CountVerdicts(reproduction, geometry))
      cells.push_back({std::to_string(count), "number"});
    rows.push_back(cells);
  }
  page->Table("Figures of the chapter", {head}, rows);
}

/// Everything without a reason, with a link to its table.
void AppendUnexplained(const Reproduction& reproduction, HtmlPage* page) {
  std::vector<Cells> rows;
  for (const Item* item : reproduction.items) {
    for (const Row& row : item->rows) {
      for (const std::string& geometry : reproduction.geometries) {
        const Comparison comparison = Compare(row, geometry, reproduction.Find(geometry, item->id));
        if (comparison.verdict != Verdict::kUnexplained) continue;
        rows.push_back({{item->title, "", 1, fmt::format("{}#{}", FileOf(item->section), item->id)},
                        {row.what},
                        {row.theirs},
                        {geometry},
                        {comparison.ours},
                        {comparison.difference},
                        {comparison.why}});
      }
    }
  }
  page->Heading(2, "Unexplained differences");
  if (rows.empty()) {
    page->Paragraph("None.");
  } else {
    page->Table("Without a reason that we know",
                {{{"item"}, {"figure"}, {"theirs"}, {"geometry"}, {"ours"}, {"difference"}, {"what was tried"}}}, rows);
  }
}

std::string FormatSummary(const Reproduction& reproduction, const Section& section) {
  HtmlPage page("Chapter 10.5: " + section.title);
  AppendState(reproduction, &page);
  page.Link("index.html", "All sections");
  std::vector<Cells> rows;
  for (const Statement& statement : Statements()) {
    std::optional<ItemResult> result;
    rows.push_back(TableRow(statement.row, reproduction, [&](const std::string& geometry) {
      result = FindFor(statement, geometry, reproduction);
      return result ? &*result : nullptr;
    }));
  }
  page.Table("What the summary says", TableHead(reproduction), rows);
  AppendCounts(reproduction, &page);
  AppendUnexplained(reproduction, &page);
  return page.Format();
}

std::string FormatSection(const Reproduction& reproduction, const Section& section) {
  HtmlPage page(fmt::format("Chapter {}: {}", section.number, section.title));
  AppendState(reproduction, &page);
  page.Link("index.html", "All sections");
  if (!section.text.empty()) page.Paragraph(section.text);
  if (section.number == "10.1") AppendGeometries(reproduction, &page);
  for (const Item* item : reproduction.items)
    if (item->section == section.number) AppendItem(*item, reproduction, &page);
  return page.Format();
}

std::string FormatIndex(const Reproduction& reproduction, const std::vector<Section>& sections) {
  HtmlPage page("Chapter 10, ours beside theirs");
  AppendState(reproduction, &page);
  page.Paragraph(
      "Every table and figure of chapter 10 of the thesis on the Hbbills 311 wagon, computed again. Theirs are numbers "
      "read from its text, with the place; its curves exist as pictures only and are not reprinted. A difference is "
      "met "
      "(within what their digits allow), explained, or listed as unexplained.");
  std::vector<Cells> rows;
  for (const Section& section : sections) {
    std::size_t items = 0;
    for (const Item* item : reproduction.items) items += item->section == section.number ? 1 : 0;
    rows.push_back({{section.number, "", 1, FileOf(section.number)},
                    {section.title},
                    {items > 0 ? std::to_string(items) : "-", "number"}});
  }
  page.Table("Sections", {{{"section"}, {"title"}, {"items"}}}, rows);
  AppendGeometries(reproduction, &page);
  AppendCounts(reproduction, &page);
  return page.Format();
}

}  // namespace

std::map<std::string, std::string> FormatPages(const Reproduction& reproduction) {
  std::map<std::string, std::string> pages;
  std::vector<Section> shown;
  for (const Section& section : Sections()) {
    const bool summary = section.number == "10.5";
    if (!summary &&
        std::ranges::none_of(reproduction.items, [&](const Item* item) { return item->section == section.number; }))
      continue;
    pages[FileOf(section.number)] =
        summary ? FormatSummary(reproduction, section) : FormatSection(reproduction, section);
    shown.push_back(section);
  }
  pages["index.html"] = FormatIndex(reproduction, shown);
  return pages;
}

}  // namespace uiclink::reproduce
