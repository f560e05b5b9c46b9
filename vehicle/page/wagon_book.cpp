#include "vehicle/page/wagon_book.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "vehicle/hunting/bounds_report.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

/// A value of the inputs as a reader wants it.
std::string ValueWords(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  return value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

std::vector<HtmlPage::Cells> ListFiles(const std::vector<InputFile>& files) {
  std::vector<HtmlPage::Cells> rows;
  for (const InputFile& file : files) {
    std::string role = SpellOut(file.role) + ": " + file.name;
    if (!file.used_for.empty() && file.used_for.size() < 2 * kCorners)
      role += fmt::format(" (for {})", fmt::join(file.used_for, ", "));
    rows.push_back({{.text = file.path}, {.text = role}, {.text = file.sha256, .style = "hash"}});
  }
  return rows;
}

}  // namespace

void WagonBook::Notices(const std::vector<std::string>& notices) {
  for (const std::string& notice : notices) page_.Paragraph("Note: " + notice, "warning");
}

void WagonBook::Draw(const std::string& name, const Figure& figure, const std::string& description) {
  if (figure.panels.empty()) return;
  HtmlPage::Cells links;
  for (const char* ending : {"svg", "csv"}) {
    const std::string file = name + "." + ending;
    if (std::ranges::find(origin_.files, file) != origin_.files.end()) links.push_back({.text = ending, .link = file});
  }
  page_.Chart(figure, name, description, links);
}

void WagonBook::Bounds(const std::string& title, const PageBounds& bounds) {
  if (bounds.scatter == nullptr || bounds.all->empty() || bounds.all->front().values.empty()) return;
  page_.Heading(2, "How certain it is", "bounds-of-results");
  page_.Paragraph(DescribeDraws(*bounds.scatter));
  page_.Table("95 % bounds, from the links' uncertainty alone", MakeBoundsTable(*bounds.all));
  Draw("bounds", BoundsFigure(title, *bounds.all),
       "Left: the draws by rank, with their 95 % bounds. Right: what their scatter comes from.");
}

std::string WagonBook::Finish(const WagonInputs& inputs) {
  std::vector<HtmlPage::Cells> rows;
  const Json options = InputsToJson(inputs)["options"];
  for (const auto& [key, value] : options.items())
    rows.push_back({{.text = SpellOut(key)}, {.text = ValueWords(value)}});
  if (const BodyInertia& body = inputs.body; body.m > 0)
    rows.push_back(
        {{.text = "body with freight"},
         {.text = fmt::format("{:.0f} kg; roll inertia {:.0f}, yaw inertia {:.0f} kg m²; centre of mass "
                              "{:.3f} m above the underframe, {:.3f} m ahead and {:.3f} m left of the middle",
                              body.m, body.I_x, body.I_z, body.h, body.x, body.y)}});
  return Finish(std::move(rows), inputs.files);
}

std::string WagonBook::Finish(const std::vector<InputFile>& files) {
  return Finish(std::vector<HtmlPage::Cells>{}, files);
}

std::string WagonBook::Finish(std::vector<HtmlPage::Cells> options, const std::vector<InputFile>& files) {
  page_.Heading(2, "To repeat it", "repeat");
  page_.Code(origin_.command);
  std::vector<HtmlPage::Cells> rows{{{.text = "program"}, {.text = "uiclink wagon " UICLINK_VERSION}},
                                    {{.text = "page written"}, {.text = origin_.written}}};
  rows.insert(rows.end(), options.begin(), options.end());
  page_.Table("The run", {}, rows);
  if (!files.empty())
    page_.Table("What went in", {{{.text = "file"}, {.text = "what it is"}, {.text = "SHA-256"}}}, ListFiles(files));
  if (!origin_.files.empty()) {
    rows.clear();
    for (const std::string& file : origin_.files) rows.push_back({{.text = file, .link = file}});
    page_.Table("Files beside this page", {}, rows);
  }
  return page_.Format();
}

std::string FormatSpeedTwice(double V) {
  constexpr double kKmhPerMs = 3.6;
  return fmt::format("{:.4g} m/s ({:.1f} km/h)", V, kKmhPerMs * V);
}

std::string DescribeLoadedWagon(const WagonInputs& inputs) {
  return inputs.loaded ? fmt::format("the wagon with cargo \"{}\"", inputs.freight.name) : "the empty wagon";
}

std::string DescribeWagonOnRails(const WagonInputs& inputs) {
  return fmt::format("{}, cargo {}, contact {}", inputs.data.name, inputs.freight.name, inputs.table.name);
}

std::string SpellOut(std::string key) {
  std::ranges::replace(key, '_', ' ');
  return key;
}

std::string JoinSentences(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences)
    if (!sentence.empty()) text += (text.empty() ? "" : " ") + sentence;
  return text;
}

void LinkTimeAxes(Figure* figure) {
  const auto begin = [](const FigurePanel& panel) {
    return panel.series.empty() || panel.series[0].x.empty() ? 0 : panel.series[0].x[0];
  };
  double first = 0;
  bool any = false;
  for (const FigurePanel& panel : figure->panels) {
    if (panel.x.unit != "s" || panel.series.empty()) continue;
    first = any ? std::min(first, begin(panel)) : begin(panel);
    any = true;
  }
  for (FigurePanel& panel : figure->panels)
    if (panel.x.unit == "s") panel.x.link = begin(panel) > first ? "close-time" : "time";
}

}  // namespace uiclink
