// Which records there were, what was used of them, and why not.

#include <fmt/format.h>

#include "identify/page/view.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

std::string JoinNotices(const Record& record) {
  std::string text;
  for (const std::string& notice : record.notices) text += (text.empty() ? "" : "; ") + notice;
  return text;
}

HtmlPage::Cells DescribeRecord(const Identification& id, const RecordResult& r) {
  HtmlPage::Cells cells{{.text = FileName(r.record.file)}, {.text = Name(id.direction)}};
  if (!r.used) {
    cells.push_back({.text = "left out", .style = "unexplained"});
    cells.push_back({.text = r.reason});
  } else {
    const FitData data = r.Data();
    cells.push_back(
        {.text = r.phases.clipped ? "used in part" : "used", .style = r.phases.clipped ? "explained" : "met"});
    std::string what =
        fmt::format("{:.2f} to {:.2f} s", r.record.t[data.first], r.record.t[data.first + data.size - 1]);
    if (const std::string cut = DescribeCut(r.phases); !cut.empty()) what += "; " + cut;
    if (const std::string notices = JoinNotices(r.record); !notices.empty()) what += "; " + notices;
    cells.push_back({.text = what});
  }
  cells.push_back({.text = fmt::format("{}", r.record.t.size()), .style = "number"});
  cells.push_back({.text = fmt::format("{:g}", r.record.sampling_hz), .style = "number"});
  cells.push_back({.text = r.used ? fmt::format("{:.4f}", 1e3 * r.noise.sigma) : "", .style = "number"});
  cells.push_back(
      {.text = r.used && r.noise.quantum > 0 ? fmt::format("{:.4f}", 1e3 * r.noise.quantum) : "", .style = "number"});
  return cells;
}

}  // namespace

void AddRecordList(const RunResult& run, Book* book) {
  book->page().Heading(2, "Records", "records");
  const std::vector<HtmlPage::Cells> head{{{.text = "record"},
                                           {.text = "direction"},
                                           {.text = "use"},
                                           {.text = "fitted, or why not"},
                                           {.text = "samples"},
                                           {.text = "rate [Hz]"},
                                           {.text = "noise [mm]"},
                                           {.text = "step [mm]"}}};
  std::vector<HtmlPage::Cells> rows;
  for (const Identification& id : run.directions)
    for (const RecordResult& r : id.records) rows.push_back(DescribeRecord(id, r));
  for (const Rejected& rejected : run.rejected)
    rows.push_back({{.text = FileName(rejected.file)},
                    {.text = ""},
                    {.text = "not read", .style = "unexplained"},
                    {.text = rejected.message, .columns = 5}});
  book->page().Table("What there was, and what was used of it", head, rows);
  book->page().Paragraph(
      "Fitted: the free decay from its first extremum on. Noise: standard deviation of one reading about the motion, "
      "from the readings alone. Step: lattice of the "
      "converter or of the print, where there is one.",
      "quiet");
}

}  // namespace uiclink
