#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/embedded.h"
#include "reports/figure.h"
#include "reports/text_table.h"

namespace uiclink {

/// A page of HTML 5 that needs nothing beside itself and no network. All text is escaped. Pages of more than two
/// headings of level 2 have a table of contents. Those without charts have no script.
///
///   HtmlPage page("ring-downs of link 7");
///   page.Paragraph("k = 4.20 1/m ...", "lead");
///   page.Heading(2, "Records", "records");
///   page.Chart(figure, "record-1", "the record with its phases", {{.text = "CSV", .link = "figures/record-1.csv"}});
///   WriteFileWhole("report.html", page.Format());  // data/file.h
class HtmlPage {
 public:
  struct Cell {
    std::string text;
    std::string style = {};   ///< class; "", "number", or a word that the style sheet knows
    std::size_t columns = 1;  ///< that it spans
    std::string link = {};    ///< address; empty: none
  };
  using Cells = std::vector<Cell>;

  /// @param plotly  the script that draws the charts; empty: they become pictures.
  explicit HtmlPage(std::string title, std::string_view plotly = PlotlyBundle())
      : title_(std::move(title)), plotly_(plotly) {}

  /// @param level  2 or more; the page's title is the one of level 1.
  /// @param id     for links to it; those of level 2 have one anyway.
  void Heading(int level, const std::string& text, const std::string& id = {});
  /// @param style  "", "lead" (the answer, in larger letters), "quiet", "warning", or "met", "explained",
  /// "unexplained".
  void Paragraph(const std::string& text, const std::string& style = {});
  void Code(const std::string& text);
  void Link(const std::string& address, const std::string& text);
  /// @param head  one or more rows of column heads. The first cell of a row is its head.
  void Table(const std::string& caption, const std::vector<Cells>& head, const std::vector<Cells>& rows);
  /// A table that a terminal has, too. A head whose first line is empty belongs to the column before; rules are left
  /// out, and so are blanks that indent.
  void Table(const std::string& caption, const TextTable& table);
  /// An SVG picture inside the page, its own ids made unique.
  /// @param description  what it shows, for who cannot see it; also its caption.
  void Picture(const std::string& svg, const std::string& description);
  /// The figure to zoom, pan, read values from and switch series off in, as wide as the page has room; on paper a
  /// picture. Lines are thinned to what four-fold magnification shows, extremes kept (reports/thin_figure.h); the data
  /// in full are FormatFigureData's. Linked axes zoom together (FigureAxis::link). Built without Plotly it is the
  /// picture that gnuplot draws; where that is missing, too, the page says so in its place.
  /// @param id     of the element, unique in the page: letters, digits, '-' and '_', a letter first.
  /// @param files  links in the caption: the figure in other formats.
  /// @throws std::invalid_argument if the figure is none (RenderSvg), the id is none or was taken before.
  void Chart(const Figure& figure, const std::string& id, const std::string& description, const Cells& files = {});

  /// A chart that FormatChart (reports/chart.h) wrote before, thinned for four-fold magnification; built without
  /// Plotly, or where `chart` is empty, the picture of it. @throws std::invalid_argument for an id as Chart.
  void StoredChart(const std::string& chart, const std::string& svg, const std::string& id,
                   const std::string& description);
  /// Something that moves: markup of ours as it is, nothing is escaped, and the script that it needs, which stands once
  /// in the page and runs when all of it is there.
  void Insert(const std::string& markup, std::string_view script);

  /// The same calls give the same bytes.
  std::string Format() const;

 private:
  struct Entry {
    std::string id, text;
  };

  void TakeId(const std::string& id);
  void AppendChart(const std::string& chart, const std::string& id, const std::string& description, const Cells& files,
                   int height);
  void AppendPicture(const Figure& figure, const std::string& id, const std::string& description, const Cells& files);
  std::string FormatContents() const;
  std::string FormatScripts() const;

  std::string title_;
  std::string_view plotly_;
  std::string body_;
  std::vector<Entry> contents_;            ///< headings of level 2
  std::vector<std::string> chart_ids_;     ///< of all charts
  std::vector<std::string_view> scripts_;  ///< of what was inserted
  std::size_t pictures_ = 0;
};

}  // namespace uiclink
