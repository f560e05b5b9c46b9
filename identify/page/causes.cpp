// The named causes, their rivals, and what is left where none accounts for it.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "identify/page/view.h"
#include "identify/report_diagnosis.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

/// What is sure, and what is not: a name is the best in a catalogue, not a proof.
std::string DescribeConfidence(const Diagnosis& diagnosis) {
  const bool has_rivals =
      std::ranges::any_of(diagnosis.causes, [](const Cause& cause) { return !cause.rivals.empty(); });
  std::string text =
      "A named cause is the effect of the catalogue whose law fits what the plain model leaves, predicts readings that "
      "it "
      "was not fitted to, stays within physical bounds and puts right what it should. ";
  text += has_rivals
              ? "Where rivals are listed, the records do not decide between them: the name stands for all of them, "
                "and the values of the link hold under the named one alone."
              : "None of the other effects does as well here; one that the catalogue does not have cannot be "
                "excluded.";
  return text;
}

}  // namespace

void AddCauses(const DirectionView& view, Book* book) {
  if (view.diagnosis == nullptr) {
    book->page().Paragraph("No diagnosis was asked for (--no-diagnosis).", "quiet");
    return;
  }
  const Diagnosis& diagnosis = *view.diagnosis;
  const bool good = diagnosis.verdict == Verdict::kAdequate || diagnosis.verdict == Verdict::kExplained;
  book->page().Paragraph(FormatAnswer(diagnosis), good ? "" : "warning");
  for (const Cause& cause : diagnosis.causes) book->page().Paragraph(DescribeCause(diagnosis, cause));
  if (diagnosis.HasCauses()) {
    book->page().Paragraph(DescribeConfidence(diagnosis));
    book->Show(MakeEffectTable(diagnosis.extended.effects), "Parameters of the named causes");
  }
  for (const std::string& notice : diagnosis.notices) book->page().Paragraph("Note: " + notice + ".");
  if (!diagnosis.candidates.empty()) {
    book->Show(MakeCandidateTable(diagnosis), "Every effect of the catalogue, each by itself");
    book->page().Paragraph(DescribeCandidates(), "quiet");
  }
  if (const std::string impossible = DescribeImpossible(diagnosis); !impossible.empty())
    book->page().Paragraph(impossible, "quiet");
  book->Tell(DescribeUnseen(), "quiet");
}

// ---------------------------------------------------------------- the missing force

namespace {

constexpr double kSure = 2;  // errors from which a cell counts as not zero

/// Cells by sign and size: told apart by mark and colour.
FigurePanel MakeMap(const MissingForce& force) {
  double largest = 0;
  for (const MissingForce::Cell& cell : force.map)
    if (std::abs(cell.f) > kSure * cell.error) largest = std::max(largest, std::abs(cell.f));
  const double half = 0.5 * largest;
  struct Class {
    std::string name;
    FigureColour colour;
    FigureMark mark;
    std::vector<double> y, v;
  };
  std::array<Class, 5> classes{
      Class{fmt::format("above {:.1e}", half), FigureColour::kVermilion, FigureMark::kTriangle, {}, {}},
      Class{"above 0", FigureColour::kOrange, FigureMark::kCircle, {}, {}},
      Class{"not sure", FigureColour::kBlack, FigureMark::kDot, {}, {}},
      Class{"below 0", FigureColour::kSky, FigureMark::kSquare, {}, {}},
      Class{fmt::format("below {:.1e}", -half), FigureColour::kBlue, FigureMark::kDisc, {}, {}}};
  for (const MissingForce::Cell& cell : force.map) {
    const bool sure = std::abs(cell.f) > kSure * cell.error;
    Class& where = classes[!sure ? 2 : cell.f > half ? 0 : cell.f > 0 ? 1 : cell.f > -half ? 3 : 4];
    where.y.push_back(1e3 * cell.y);
    where.v.push_back(1e3 * cell.v);
  }
  FigurePanel panel{.title = "map of the missing force / M g",
                    .x = {.label = "displacement", .unit = "mm"},
                    .y = {.label = "velocity", .unit = "mm/s"}};
  for (Class& c : classes) panel.series.push_back(MakeMarks(c.name, std::move(c.y), std::move(c.v), c.colour, c.mark));
  return panel;
}

FigurePanel MakeCurve(const std::vector<MissingForce::Bin>& bins, FigureAxis x, double unit, FigureColour colour) {
  FigurePanel panel{.title = "over " + x.label, .x = std::move(x), .y = {.label = "force / M g"}};
  std::vector<double> at, f, low, high;
  for (const MissingForce::Bin& bin : bins) {
    at.push_back(unit * bin.at);
    f.push_back(bin.f);
    low.push_back(bin.f - 2 * bin.error);
    high.push_back(bin.f + 2 * bin.error);
  }
  panel.series.push_back(MakeBars("", at, low, high, colour));
  panel.series.push_back(MakeLine("", at, f, colour));
  panel.series.back().mark = FigureMark::kDisc;
  return panel;
}

}  // namespace

void AddMissingForce(const DirectionView& view, Book* book) {
  if (view.diagnosis == nullptr || !view.diagnosis->missing_force) {
    book->page().Paragraph(view.diagnosis == nullptr ? "No diagnosis was asked for (--no-diagnosis)."
                                                     : "No structure is left, so no force is missing.",
                           "quiet");
    return;
  }
  const MissingForce& force = *view.diagnosis->missing_force;
  book->page().Paragraph(DescribeMissingForce(*view.diagnosis), "warning");
  Figure figure{
      .title = view.Word() + ": the force that the model lacks",
      .panels = {MakeMap(force), MakeCurve(force.over_y, {.label = "displacement", .unit = "mm"}, 1e3, kExtendedColour),
                 MakeCurve(force.over_v, {.label = "velocity", .unit = "mm/s"}, 1e3, kExtendedColour),
                 MakeCurve(force.over_t, {.label = "time", .unit = "s"}, 1, kExtendedColour)},
      .columns = 2,
      .panel_height = 280};
  book->Draw(
      view.Word() + "_missing_force", figure,
      fmt::format("f = y''/g + k y - sum T, per unit of load, freed from what the link's own parameters can take up. "
                  "Map: mean in cells of displacement and velocity; 'not sure' is within two errors of zero. "
                  "Curves: the best function of one thing alone, with two errors; over displacement known up to a "
                  "straight line, over velocity and time up to a constant. A force at one displacement stands out "
                  "from {:.1e} of the load on.",
                  force.smallest_seen));
}

}  // namespace uiclink
