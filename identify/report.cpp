#include "identify/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "identify/report_diagnosis.h"
#include "identify/report_tables.h"
#include "model/closed_form.h"
#include "reports/text_table.h"
#include "reports/wrap.h"

namespace uiclink {

std::string FileName(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

namespace {

std::string Millimetres(double metres, int decimals) { return fmt::format("{:.{}f}", 1e3 * metres, decimals); }

std::string UnitOf(const std::string& quantity) { return quantity.find("T0") != std::string::npos ? "-" : "1/m"; }

/// Quantities worth a line: with one slider the sums are k1 and T01 themselves.
std::vector<int> ListedQuantities(int sliders) {
  std::vector<int> listed;
  for (int q = 0; q < (sliders == 1 ? 3 : CountQuantities(sliders)); ++q) listed.push_back(q);
  return listed;
}

}  // namespace

TextTable MakeRecordTable(const Identification& id) {
  const bool one = id.sliders == 1;
  TextTable table;
  table.AddColumn("record", TextTable::Align::kLeft);
  table.AddColumn("release\n[s]");
  table.AddColumn("extremum\n[mm]");
  table.AddColumn("noise\n[mm]");
  table.AddColumn("published\nk");
  table.AddColumn(one ? "method\nk1" : "method\nsum ki");
  table.AddColumn("fit\nk");
  table.AddColumn(one ? "\nk1" : "\nsum ki");
  table.AddColumn(one ? "\nT01" : "\nsum T0i");
  table.AddColumn("zero\n[mm]");
  table.AddColumn("rms\n[mm]");
  table.AddColumn("rms/\nnoise");
  for (const RecordResult& r : id.records) {
    if (!r.used) continue;
    const int stiffness = SumOfStiffness(r.link.size()), friction = SumOfFriction(r.link.size());
    table.AddRow({FileName(r.record.file), fmt::format("{:.2f}", r.phases.release_s),
                  Millimetres(r.phases.extrema[0].y - r.start[2], 2), Millimetres(r.noise.sigma, 4),
                  r.sine ? fmt::format("{:.3f}", r.sine->k) : "-", r.sine ? fmt::format("{:.3f}", r.sine->sum_ki) : "-",
                  fmt::format("{:.4f}", r.link.k), fmt::format("{:.4f}", CalcQuantity(r.link, stiffness)),
                  fmt::format("{:.5f}", CalcQuantity(r.link, friction)), Millimetres(r.start[2], 3),
                  Millimetres(r.rms, 4), fmt::format("{:.2f}", r.rms / r.noise.sigma)});
  }
  return table;
}

namespace {

std::string FormatPopulation(const Population& population, double unit = 1) {
  if (!(population.spread > 0)) return fmt::format("{:.4g}", population.mean / unit);  // one record has no spread
  return fmt::format("{} ± {}", Round(population.mean / unit, population.spread / unit),
                     Round(population.spread / unit, population.spread / unit));
}

std::string Bound(double value, double std, bool open, const char* mark) {
  return (open ? std::string(mark) : "") + Round(value, std);
}

}  // namespace

TextTable MakeParameterTable(const Identification& id) {
  const int n = id.sliders;
  TextTable table;
  table.AddColumn("parameter", TextTable::Align::kLeft);
  table.AddColumn("unit", TextTable::Align::kLeft);
  table.AddColumn("published method\nmean ± spread");
  table.AddColumn("centre free\nmean ± spread");
  table.AddColumn(id.shared ? "fit\nall records" : "fit\nmean");
  table.AddColumn("std");
  table.AddColumn("95 % bounds\nlow");
  table.AddColumn("\nhigh");
  if (!id.shared) table.AddColumn("spread of\nrecords");
  for (const int q : ListedQuantities(n)) {
    const Estimate& e = id.quantities[static_cast<std::size_t>(q)];
    std::string published, corrected;
    if (id.sine.records > 0) {
      const bool stiffness = q == SumOfStiffness(n) || (n == 1 && q == 1);
      const bool friction = q == SumOfFriction(n) || (n == 1 && q == 2);
      if (q == 0) published = FormatPopulation(id.sine.k), corrected = FormatPopulation(id.sine.k_corrected);
      if (stiffness)
        published = FormatPopulation(id.sine.sum_ki), corrected = FormatPopulation(id.sine.sum_ki_corrected);
      if (friction) published = FormatPopulation(id.sine.T0), corrected = FormatPopulation(id.sine.T0_corrected);
    }
    const std::string name = QuantityName(n, q);
    table.AddRow({name, UnitOf(name), published, corrected, Round(e.value, e.std), Round(e.std, e.std),
                  Bound(e.low, e.std, e.low_open, "< "), Bound(e.high, e.std, e.high_open, "> "),
                  id.shared ? "" : Round(e.spread, e.std)});
  }
  return table;
}

namespace {

/// The published k by the number of the extremum that it was read from.
struct BiasBin {
  double extremum = 0, published = 0, expected = 0;  // sums over the arcs
  int arcs = 0;
};

std::vector<BiasBin> BinBias(const Identification& id) {
  std::vector<BiasBin> bins;
  for (const RecordResult& r : id.records) {
    if (!r.used || !r.sine) continue;
    for (std::size_t i = 0; i < r.sine->arcs.size(); ++i) {
      const SlidingArc& arc = r.sine->arcs[i];
      if (bins.size() <= i) bins.resize(i + 1);
      bins[i].extremum += arc.extremum;
      bins[i].published += arc.k_published;
      bins[i].expected += CalcExpectedBias(id, *r.sine, arc);
      ++bins[i].arcs;
    }
  }
  return bins;
}

}  // namespace

std::string DescribeBias(const Identification& id) {
  const std::vector<BiasBin> bins = BinBias(id);
  if (bins.empty()) return "";
  const double shift = CalcQuantity(id.link, SumOfFriction(id.sliders)) / id.link.k;
  return fmt::format(
      "Bias of the published method: from the largest extremum it reads k = {:.2f}, {:.0f} % above the fit. It fits a "
      "sine about zero, but while the joints slide the centre of the motion sits at -+T0/k = {:.1f} mm; the closed "
      "form expects {:+.0f} %. Its k depends on the extremum that it is read from, which a stiffness cannot:",
      id.sine.k.mean, 100 * (id.sine.k.mean / id.link.k - 1), 1e3 * shift, 100 * bins[0].expected / bins[0].arcs);
}

TextTable MakeBiasTable(const Identification& id) {
  const std::vector<BiasBin> bins = BinBias(id);
  TextTable table;
  table.AddColumn("extremum", TextTable::Align::kLeft);
  table.AddColumn("records");
  table.AddColumn("amplitude\n[mm]");
  table.AddColumn("published k\n[1/m]");
  table.AddColumn("expected k\n[1/m]");
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const BiasBin& bin = bins[i];
    table.AddRow({fmt::format("no. {}", i + 1), fmt::format("{}", bin.arcs), Millimetres(bin.extremum / bin.arcs, 1),
                  fmt::format("{:.2f}", bin.published / bin.arcs),
                  fmt::format("{:.2f}", id.link.k * (1 + bin.expected / bin.arcs))});
  }
  return table;
}

TextTable MakeChoiceTable(const Identification& id) {
  TextTable table;
  table.AddColumn("sliders");
  table.AddColumn("penalised likelihood\n(less is better)");
  table.AddColumn("rms on held-out records\n[mm]");
  table.AddColumn("", TextTable::Align::kLeft);
  for (const SliderChoice& choice : id.choices)
    table.AddRow({fmt::format("{}", choice.sliders), fmt::format("{:.0f}", choice.penalised),
                  Millimetres(choice.held_out_rms, 4), choice.chosen ? "chosen" : ""});
  return table;
}

std::string DescribeSharing(const Identification& id) {
  if (id.CountUsed() < 2) return "One record: nothing can be said about scatter between records.";
  if (id.shared)
    return fmt::format("The records share one link (test of equal k, sum ki, sum T0i: p = {:.2g}); one joint fit.",
                       id.sharing.p_value);
  return fmt::format(
      "The records do not share one link ({}): each has its own values, the table gives mean and spread; std and "
      "bounds belong to the mean.",
      id.sharing.p_value < 1e-6 ? "p < 1e-6" : fmt::format("p = {:.1g}", id.sharing.p_value));
}

namespace {

/// k and the sums, as far as their bounds are closed.
std::string ListDetermined(const Identification& id) {
  std::string names;
  for (const int q : {0, SumOfStiffness(id.sliders), SumOfFriction(id.sliders)}) {
    const Estimate& e = id.quantities[static_cast<std::size_t>(q)];
    if (e.low_open || e.high_open || e.std > 0.5 * e.value) continue;
    const int listed = id.sliders > 1 || q == 0 ? q : q - 2;  // with one slider the sums are k1 and T01
    names += (names.empty() ? "" : ", ") + QuantityName(id.sliders, listed);
  }
  return names;
}

}  // namespace

std::vector<std::string> DescribeTrust(const Identification& id) {
  int starts = 0, agreeing = 0;
  for (const RecordResult& r : id.records) starts += r.starts, agreeing += r.starts_agreeing;
  std::vector<std::string> words;
  if (starts > 0) words.push_back(fmt::format("{} of {} scattered starts end at the same minimum.", agreeing, starts));
  words.push_back(fmt::format("rms {:.4f} mm, noise {:.4f} mm, rms/noise {:.2f}: ", 1e3 * id.rms, 1e3 * id.noise,
                              id.rms / id.noise) +
                  (id.rms < 1.05 * id.noise
                       ? "the model explains the records down to their noise."
                       : "the model leaves structure in the residuals. What it lacks may shift every value; the bounds "
                         "hold what parts of the records give, but not its cause."));
  if (!id.unidentifiable.empty()) {
    std::string text = "Not determined by these records: ";
    for (std::size_t i = 0; i < id.unidentifiable.size(); ++i) text += (i == 0 ? "" : "; ") + id.unidentifiable[i];
    words.push_back(text + ".");
    const std::string determined = ListDetermined(id);
    if (!determined.empty()) words.push_back("Determined, to the stated bounds: " + determined + ".");
  }
  for (const std::string& warning : id.warnings) words.push_back("warning: " + warning);
  return words;
}

namespace {

constexpr std::size_t kColumns = 110;  // of the terminal
constexpr std::size_t kIndent = 2;

std::string FormatLeftOut(const RunResult& run) {
  std::string text;
  int left_out = 0;
  for (const Rejected& rejected : run.rejected) text += "  " + rejected.message + "\n", ++left_out;
  for (const Identification& id : run.directions)
    for (const RecordResult& r : id.records)
      if (!r.used) text += "  " + r.record.file + ": " + r.reason + "\n", ++left_out;
  return left_out == 0 ? "" : fmt::format("Left out ({}):\n{}\n", left_out, text);
}

}  // namespace

double CalcExpectedBias(const Identification& identification, const SineFit& sine, const SlidingArc& arc) {
  const double shift = CalcQuantity(identification.link, SumOfFriction(identification.sliders)) / identification.link.k;
  return CalcPublishedBias(arc.extremum, sine.cutoff, shift) - 1;
}

std::string FormatReport(const RunResult& run) {
  std::string text = FormatLeftOut(run);
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    if (id.CountUsed() == 0) continue;
    const auto& used = *std::find_if(id.records.begin(), id.records.end(), [](const auto& r) { return r.used; });
    text +=
        fmt::format("{}: {} record{}, {} slider{}, M = {:g} kg, g = {:g} m/s^2\n\n", Name(id.direction), id.CountUsed(),
                    id.CountUsed() == 1 ? "" : "s", id.sliders, id.sliders == 1 ? "" : "s", used.record.mass_kg, id.g);
    text += MakeRecordTable(id).Format(2) + "\n" + MakeParameterTable(id).Format(2) + "\n";
    if (!id.choices.empty()) text += MakeChoiceTable(id).Format(2) + "\n";
    text += Paragraph(DescribeSharing(id), kIndent, kColumns);
    for (const std::string& words : DescribeTrust(id)) text += Paragraph(words, kIndent, kColumns);
    text += "\n";
    if (const std::string bias = DescribeBias(id); !bias.empty())
      text += Paragraph(bias, kIndent, kColumns) + MakeBiasTable(id).Format(2);
    text += "\n";
    text += fmt::format("  {} model evaluations, {:.2f} s\n\n", id.evaluations, id.wall_s);
    if (!run.diagnoses.empty()) text += FormatDiagnosis(id, run.diagnoses[d]);
  }
  return text;
}

}  // namespace uiclink
