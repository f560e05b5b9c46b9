#pragma once

#include <string>
#include <vector>

#include "reports/figure.h"
#include "reports/html_page.h"
#include "reports/text_table.h"
#include "vehicle/hunting/propagation.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Where a page comes from.
struct PageOrigin {
  std::string command;             ///< as it was typed, quoted for a shell
  std::string written;             ///< when: "2026-11-22 13:40 UTC"
  std::vector<std::string> files;  ///< names of those that were written beside the page
};

/// 95 % bounds of some results; none where there is no scatter. A view.
struct PageBounds {
  const SetScatter* scatter = nullptr;
  const std::vector<ScalarBounds>* all = nullptr;
};

/// The page of a command in the making: the answer, figures and tables, and what it takes to repeat the run.
class WagonBook {
 public:
  /// @param origin  must outlive the book.
  WagonBook(const std::string& title, const PageOrigin& origin) : page_(title), origin_(origin) {}

  HtmlPage& page() { return page_; }
  /// What a reader has to know who knows nothing of it, in one paragraph.
  void Answer(const std::string& text) { page_.Paragraph(text, "lead"); }
  void Notices(const std::vector<std::string>& notices);
  /// A chart with links to name.svg and name.csv where they are beside the page; nothing for a figure without panels.
  void Draw(const std::string& name, const Figure& figure, const std::string& description);
  void Bounds(const std::string& title, const PageBounds& bounds);
  /// Ends with the section "To repeat it": command, version, options, files with their checksums.
  std::string Finish(const WagonInputs& inputs);
  /// The same where there is no one wagon: files alone.
  std::string Finish(const std::vector<InputFile>& files);

 private:
  std::string Finish(std::vector<HtmlPage::Cells> options, const std::vector<InputFile>& files);

  HtmlPage page_;
  const PageOrigin& origin_;
};

// Parts of sentences.

std::string FormatSpeedTwice(double V);                       ///< "18.40 m/s (66.2 km/h)"
std::string DescribeLoadedWagon(const WagonInputs& inputs);   ///< "the empty wagon", "the wagon loaded with water"
std::string DescribeWagonOnRails(const WagonInputs& inputs);  ///< "Hbbills 311, cargo empty, contact nominal-1435"
std::string JoinSentences(const std::vector<std::string>& sentences);  ///< empty ones are left out

std::string SpellOut(std::string key);  ///< "front_left" -> "front left"

/// Time axes that zoom together: those of whole runs, and those of close views.
void LinkTimeAxes(Figure* figure);

}  // namespace uiclink
