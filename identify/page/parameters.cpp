// Values with bounds, correlations, profiles of the likelihood, and what the records do not determine.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/page/view.h"
#include "identify/report_diagnosis.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

void AddCorrelations(const DirectionView& view, Book* book) {
  if (view.parameters == nullptr || !view.parameters->covariance) return;
  const Covariance& covariance = *view.parameters->covariance;
  std::vector<HtmlPage::Cells> head{{{.text = ""}}}, rows;
  for (std::size_t i = 0; i < covariance.order.size(); ++i) {
    head[0].push_back({.text = covariance.order[i]});
    HtmlPage::Cells& row = rows.emplace_back();
    row.push_back({.text = covariance.order[i]});
    for (std::size_t j = 0; j < covariance.order.size(); ++j) {
      const double scale = std::sqrt(covariance.matrix[i][i] * covariance.matrix[j][j]);
      row.push_back({.text = i == j      ? "1"
                             : scale > 0 ? fmt::format("{:+.2f}", covariance.matrix[i][j] / scale)
                                         : "-",
                     .style = "number"});
    }
  }
  book->page().Table("Correlations of the parameters (of parameters.toml)", head, rows);
}

constexpr int kCurvePoints = 40;

/// The fitted value: where the root is zero.
double BestOf(const LikelihoodProfile& profile) {
  const auto best = std::ranges::min_element(profile.root, {}, [](double root) { return std::abs(root); });
  return profile.value[static_cast<std::size_t>(best - profile.root.begin())];
}

/// The parabola-like curve of one profile, from the polynomial through its signed roots, over the distance from the
/// fitted value in per cent.
void AddCurve(const LikelihoodProfile& profile, const std::string& name, FigureColour colour, bool with_marks,
              FigurePanel* panel) {
  const double best = BestOf(profile), width = profile.value.back() - profile.value.front();
  const auto percent = [&](double value) { return 100 * (value - best) / std::abs(best); };
  std::vector<double> x, y, at, rise;
  for (int i = 0; i <= kCurvePoints; ++i) {
    const double value = profile.value.front() + width * i / kCurvePoints, root = profile.Root(value);
    x.push_back(percent(value));
    y.push_back(root * root);
  }
  for (std::size_t i = 0; i < profile.value.size(); ++i) {
    at.push_back(percent(profile.value[i]));
    rise.push_back(profile.root[i] * profile.root[i]);
  }
  panel->series.push_back(MakeLine(name, x, y, colour));
  if (with_marks) panel->series.push_back(MakeMarks("", at, rise, colour, FigureMark::kDisc));
}

FigurePanel MakePanel(const DirectionView& view, const std::string& symbol) {
  FigurePanel panel{.title = symbol,
                    .x = {.label = symbol + " less its best value", .unit = "%"},
                    .y = {.label = "rise of chi-square", .low = 0.0, .high = 6.0}};
  std::vector<const LikelihoodProfile*> others, chosen;
  for (const LikelihoodProfile& profile : view.profiles) {
    if (profile.symbol != symbol || !profile.IsSound()) continue;
    const bool stands_out = profile.record < 0 || profile.record == static_cast<int>(view.typical);
    (stands_out ? chosen : others).push_back(&profile);
  }
  for (const LikelihoodProfile* profile : others)
    AddCurve(*profile, profile == others.front() ? "other records" : "", FigureColour::kSky, false, &panel);
  for (const LikelihoodProfile* profile : chosen)
    AddCurve(*profile, profile->record < 0 ? "all records" : view.Typical().label, kExtendedColour, true, &panel);
  panel.horizontal_guides = {{.value = kProfileRise, .text = "95 %"}};
  return panel;
}

/// One panel for each symbol, in the order in which they come.
std::vector<FigurePanel> MakePanels(const DirectionView& view) {
  std::vector<std::string> symbols;
  for (const LikelihoodProfile& profile : view.profiles)
    if (std::ranges::find(symbols, profile.symbol) == symbols.end()) symbols.push_back(profile.symbol);
  std::vector<FigurePanel> panels;
  for (const std::string& symbol : symbols)
    if (FigurePanel panel = MakePanel(view, symbol); !panel.series.empty()) panels.push_back(std::move(panel));
  return panels;
}

/// Which profiles cannot be drawn.
std::string DescribeUnsound(const DirectionView& view) {
  std::string list;
  for (const LikelihoodProfile& profile : view.profiles)
    if (!profile.IsSound())
      list += (list.empty() ? "" : ", ") + profile.symbol +
              (profile.record < 0 ? "" : " of " + view.records[static_cast<std::size_t>(profile.record)].label);
  return list.empty()
             ? ""
             : "No profile of " + list +
                   ": refits on the way end in different minima, which nearly equal sliders have; the bounds of "
                   "the table hold for these, too.";
}

void DrawProfiles(const DirectionView& view, Book* book) {
  Figure figure{
      .title = view.Word() + ": profile likelihoods", .panels = MakePanels(view), .columns = 2, .panel_height = 220};
  if (const std::string unsound = DescribeUnsound(view); !unsound.empty()) book->page().Paragraph(unsound, "quiet");
  if (figure.panels.empty()) return;
  const bool by_record = std::ranges::any_of(view.profiles, [](const LikelihoodProfile& p) { return p.record >= 0; });
  book->Draw(
      view.Word() + "_profiles", figure,
      fmt::format("Rise of the least sum of squares, in variance factors, when one unknown of the {} model is held "
                  "and all others are fitted again; below 3.84 lies the 95 % interval. Discs: refits; lines: "
                  "through their signed roots.{}",
                  view.HasCauses() ? "extended" : "plain",
                  by_record ? " The records have links of their own: each has its curve, with the effects' "
                              "parameters at their common values. The bounds of the table hold for the mean "
                              "over links and are wider than one record's."
                            : ""));
}

/// Where profile and stated bounds part.
std::string CompareWithBounds(const DirectionView& view) {
  std::string text;
  for (const LikelihoodProfile& profile : view.profiles) {
    if (profile.record >= 0) continue;
    const std::optional<double> low = profile.Find(-std::sqrt(kProfileRise)),
                                high = profile.Find(std::sqrt(kProfileRise));
    if (!low || !high) continue;
    const double std = (*high - *low) / 4;
    text += fmt::format("{}{} {} to {}", text.empty() ? "" : ", ", profile.symbol, Round(*low, std), Round(*high, std));
  }
  return text.empty() ? "" : "95 % from the profiles: " + text + ".";
}

}  // namespace

void AddParameters(const DirectionView& view, Book* book) {
  if (view.HasCauses()) {
    book->Show(MakeLinkTable(*view.id, *view.diagnosis), "The extended model beside the plain one");
    if (const std::string change = DescribeSharingChange(*view.id, view.Final()); !change.empty())
      book->page().Paragraph(change);
  }
  book->Show(MakeParameterTable(*view.id), "The plain model beside the frequency method");
  if (const TextTable choices = MakeChoiceTable(*view.id); !choices.rows().empty())
    book->Show(choices, "How many sliders");
  AddCorrelations(view, book);
  DrawProfiles(view, book);
  if (const std::string bounds = CompareWithBounds(view); !bounds.empty()) book->page().Paragraph(bounds);
}

namespace {

constexpr double kDetermined = 0.1;  // relative standard deviation up to which a value counts as determined,
constexpr double kHardly = 0.5;      // and from which on as not determined

/// Which values of the extended model the records determine, by themselves.
std::string DescribeDetermined(const DirectionView& view) {
  std::string well, badly;
  for (int q = 0; q < CountQuantities(view.Sliders()); ++q) {
    if (view.Sliders() == 1 && q > 2) break;  // the sums are k1 and T01 themselves
    const Estimate& e = view.Quantities()[static_cast<std::size_t>(q)];
    std::string* const list = e.std <= kDetermined * e.value ? &well : e.std >= kHardly * e.value ? &badly : nullptr;
    if (list != nullptr) *list += (list->empty() ? "" : ", ") + QuantityName(view.Sliders(), q);
  }
  std::string text =
      "The extended model leaves " + FormatRatio(view.Final().structure.RmsOverNoise()) + " noise levels.";
  if (!well.empty()) text += " With it these records determine, to a tenth and better: " + well + ".";
  if (!badly.empty())
    text += " Not determined by themselves (standard deviation above half the value): " + badly +
            "; a model that uses them should take their covariance along (parameters.toml).";
  return text;
}

}  // namespace

void AddIdentifiability(const DirectionView& view, Book* book) {
  if (view.HasCauses()) {
    book->page().Paragraph(DescribeDetermined(view));
    book->page().Paragraph("Of the plain model:");
  }
  book->page().Paragraph(DescribeSharing(*view.id));
  for (const std::string& words : DescribeTrust(*view.id))
    book->page().Paragraph(words, words.starts_with("warning") ? "warning" : "");
}

}  // namespace uiclink
