#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/page/report_page.h"
#include "identify/profiles.h"
#include "reports/html_page.h"
#include "reports/text_table.h"

namespace uiclink {

/// A used record as the page draws it: readings of the fitted samples, the sensor's zero included.
struct RecordView {
  const RecordResult* result = nullptr;
  std::string label;                                      ///< "lateral_01"
  std::vector<double> t;                                  ///< [s]
  std::vector<double> measured, plain, extended;          ///< [mm]
  std::vector<double> plain_residual, extended_residual;  ///< measured less modelled [mm]
  double plain_rms = 0, extended_rms = 0;                 ///< in noise levels
};

/// One direction as the page tells it.
struct DirectionView {
  const Identification* id = nullptr;
  const Diagnosis* diagnosis = nullptr;             ///< null where none was asked for
  const DirectionParameters* parameters = nullptr;  ///< as in the file that the wagon reads
  double load = 0;                                  ///< M g [N]
  std::vector<RecordView> records;
  std::size_t typical = 0;  ///< the record whose final rms is the middle one: it stands for all in large figures
  ExtendedResult plain;     ///< where there is no diagnosis to have one
  std::vector<LikelihoodProfile> profiles;

  bool HasCauses() const { return diagnosis != nullptr && diagnosis->HasCauses(); }
  const RecordView& Typical() const { return records[typical]; }
  /// The final model: with the named causes where there are any.
  const ExtendedResult& Final() const { return diagnosis != nullptr ? diagnosis->extended : plain; }
  /// Values of the final model, as the JSON has them.
  const std::vector<Estimate>& Quantities() const {
    return HasCauses() ? diagnosis->extended.quantities : id->quantities;
  }
  int Sliders() const { return id->sliders; }
  std::string Word() const { return Name(id->direction); }
  /// Link of used record r in the final model.
  Oscillator<double> FinalLink(std::size_t r) const;
};

/// The used directions.
std::vector<DirectionView> MakeViews(const RunResult& run, std::span<const ValidationSet> sets,
                                     std::span<const ReadingResiduals> residuals, int threads);

/// The page in the making: text, and figures that are drawn into it and kept.
class Book {
 public:
  Book(std::string title, bool several, bool pictures)
      : page_(std::move(title)), several_(several), pictures_(pictures) {}

  HtmlPage& page() { return page_; }
  /// There is more than one direction, so that each part says whose it is.
  bool several() const { return several_; }
  /// A section's heading, and where there are several directions a smaller one for each.
  void Part(const std::string& text) {
    if (several_) page_.Heading(3, text);
  }
  void Draw(const std::string& name, Figure figure, const std::string& description);
  /// A table that the terminal has, too. Heads that begin with an empty line belong to the column before.
  void Show(const TextTable& table, const std::string& caption);
  void Tell(std::span<const std::string> paragraphs, const std::string& style = {});

  ReportPage Finish();

 private:
  HtmlPage page_;
  bool several_, pictures_;
  std::vector<PageFigure> figures_;
};

// Parts of figures.

/// Points joined by a line, or marks alone.
FigureSeries MakeLine(std::string name, std::vector<double> x, std::vector<double> y, FigureColour colour,
                      FigureLine line = FigureLine::kSolid, double width = 1.4);
FigureSeries MakeMarks(std::string name, std::vector<double> x, std::vector<double> y, FigureColour colour,
                       FigureMark mark);
/// Upright lines from low to high at each x.
FigureSeries MakeBars(std::string name, const std::vector<double>& x, const std::vector<double>& low,
                      const std::vector<double>& high, FigureColour colour);

/// What stands for the same thing in every figure.
inline constexpr FigureColour kMeasuredColour = FigureColour::kBlack;
inline constexpr FigureColour kPlainColour = FigureColour::kVermilion;
inline constexpr FigureColour kExtendedColour = FigureColour::kBlue;

// The sections, in the order of the page (report_page.cpp).

void AddAnswer(const RunResult& run, std::span<const DirectionView> views, Book* book);
void AddRecordList(const RunResult& run, Book* book);
void AddPhases(const DirectionView& view, Book* book);
void AddStiffness(const DirectionView& view, Book* book);
void AddModels(const DirectionView& view, Book* book);
void AddEnergy(const DirectionView& view, Book* book);
void AddLoops(const DirectionView& view, Book* book);
void AddResiduals(const DirectionView& view, Book* book);
void AddCauses(const DirectionView& view, Book* book);
void AddMissingForce(const DirectionView& view, Book* book);
void AddParameters(const DirectionView& view, Book* book);
void AddIdentifiability(const DirectionView& view, Book* book);
void AddWagon(const RunResult& run, Book* book);
void AddProvenance(const RunResult& run, std::span<const ValidationSet> sets, const Provenance& provenance, Book* book);

}  // namespace uiclink
