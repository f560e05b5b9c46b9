#include "identify/page/report_page.h"

#include <algorithm>

#include "data/file.h"
#include "identify/page/view.h"
#include "model/parallel.h"
#include "reports/pictures.h"
#include "reports/thin_figure.h"

namespace uiclink {
namespace {

/// A part of the page that each direction has.
struct Section {
  const char* id;
  const char* title;
  void (*add)(const DirectionView&, Book*);
};

constexpr Section kSections[] = {
    {"phases", "Phases and frequencies", &AddPhases},
    {"stiffness", "Stiffness and friction by record", &AddStiffness},
    {"models", "Measured against modelled", &AddModels},
    {"energy", "Envelope, backbone and loss", &AddEnergy},
    {"loops", "Hysteresis", &AddLoops},
    {"residuals", "What the residuals depend on", &AddResiduals},
    {"causes", "Causes", &AddCauses},
    {"missing-force", "The missing force", &AddMissingForce},
    {"parameters", "Parameters", &AddParameters},
    {"identifiability", "What the records determine", &AddIdentifiability},
};

std::string MakeTitle(std::span<const DirectionView> views) {
  std::string words;
  for (const DirectionView& view : views) words += (words.empty() ? "" : " and ") + view.Word();
  return "Identification of a UIC link, " + words;
}

}  // namespace

ReportPage ComposeReportPage(const ReportInput& input) {
  const RunResult& run = *input.run;
  const std::vector<DirectionView> views = MakeViews(run, input.sets, input.residuals, input.threads);
  Book book(MakeTitle(views), views.size() > 1, input.no_pictures.empty());
  AddAnswer(run, views, &book);
  AddRecordList(run, &book);
  for (const Section& section : kSections) {
    book.page().Heading(2, section.title, section.id);
    for (const DirectionView& view : views) {
      book.Part(view.Word());
      section.add(view, &book);
    }
  }
  AddWagon(run, &book);
  AddProvenance(run, input.sets, *input.provenance, &book);
  if (!input.no_pictures.empty())
    book.page().Paragraph("No SVG and PNG files beside this page: " + input.no_pictures, "warning");
  return book.Finish();
}

namespace {

/// All figures as pictures, shared out among as many processes of gnuplot as there are processors.
/// @throws FigureError
std::vector<Pictures> DrawAll(const std::vector<PageFigure>& figures, int threads) {
  const std::size_t batches = std::min(figures.size(), static_cast<std::size_t>(CountThreads(threads)));
  std::vector<Pictures> drawn(figures.size());
  std::vector<std::string> failures(batches);
  ParallelFor(batches, threads, [&](std::size_t batch) {
    try {
      std::vector<Figure> own;  // every so many-th: neighbours are of a size
      for (std::size_t i = batch; i < figures.size(); i += batches) {
        own.push_back(figures[i].figure);
        ThinToPixels(&own.back());  // gnuplot's time goes with the number of points
      }
      std::vector<Pictures> pictures = RenderPictures(own);
      for (std::size_t i = 0; i < pictures.size(); ++i) drawn[batch + i * batches] = std::move(pictures[i]);
    } catch (const std::exception& error) {
      failures[batch] = error.what();
    }
  });
  for (const std::string& failure : failures)
    if (!failure.empty()) throw FigureError(failure);
  return drawn;
}

void WriteOrRemove(const std::filesystem::path& file, const std::string& content) {
  if (!content.empty()) return WriteFileWhole(file, content);
  std::error_code none;
  std::filesystem::remove(file, none);
}

}  // namespace

std::string WriteReportPage(const ReportInput& input, const std::filesystem::path& out) {
  ReportPage page = ComposeReportPage(input);
  std::vector<Pictures> drawn(page.figures.size());
  std::string missing;
  try {
    drawn = DrawAll(page.figures, input.threads);
  } catch (const FigureError& error) {
    missing = error.what();
    ReportInput without = input;
    without.no_pictures = missing;
    page = ComposeReportPage(without);
  }
  const std::filesystem::path folder = out / "figures";
  for (std::size_t i = 0; i < page.figures.size(); ++i) {
    const std::string& name = page.figures[i].name;
    WriteFileWhole(folder / (name + ".csv"), FormatFigureData(page.figures[i].figure));
    WriteOrRemove(folder / (name + ".svg"), drawn[i].svg);
    WriteOrRemove(folder / (name + ".png"), drawn[i].png);
  }
  WriteFileWhole(out / "report.html", page.html);
  return missing;
}

}  // namespace uiclink
