#include "vehicle/element_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "reports/wrap.h"
#include "vehicle/element_report_parts.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

ElementParts ReportBench(ElementBench bench, const ElementOptions& options) {
  switch (bench) {
    case ElementBench::kLeafHarmonic:
      return ReportLeafHarmonic(options);
    case ElementBench::kLeafDrop:
      return ReportLeafDrop(options);
    case ElementBench::kParabolic:
      return ReportParabolic(options);
    case ElementBench::kGuidance:
      return ReportGuidance(options);
    case ElementBench::kDryFriction:
      return ReportDryFriction(options);
  }
  throw std::logic_error("MakeElementReport: unknown bench");
}

std::string FormatText(const ElementParts& parts) {
  constexpr std::size_t kColumns = 100;
  std::string text = parts.title + "\n\n" + parts.table.Format(2) + parts.below + "\n";
  for (const std::string& remark : parts.remarks) text += Paragraph(remark, 0, kColumns);
  return text;
}

const std::string& NameOf(ElementBench bench) { return ElementBenches()[static_cast<std::size_t>(bench)].first; }

}  // namespace

const std::vector<std::pair<std::string, ElementBench>>& ElementBenches() {
  static const std::vector<std::pair<std::string, ElementBench>> benches{{"leaf-harmonic", ElementBench::kLeafHarmonic},
                                                                         {"leaf-drop", ElementBench::kLeafDrop},
                                                                         {"parabolic", ElementBench::kParabolic},
                                                                         {"guidance", ElementBench::kGuidance},
                                                                         {"dry-friction", ElementBench::kDryFriction}};
  return benches;
}

ElementBench FindElementBench(std::string_view name) {
  std::string known;
  for (const auto& [text, bench] : ElementBenches()) {
    if (text == name) return bench;
    known += (known.empty() ? "" : ", ") + text;
  }
  throw std::invalid_argument(fmt::format("element \"{}\", must be one of {}", name, known));
}

std::vector<double> Scaled(const std::vector<double>& values, double factor) {
  std::vector<double> scaled(values);
  for (double& value : scaled) value *= factor;
  return scaled;
}

ElementReport MakeElementReport(ElementBench bench, const ElementOptions& options, const WagonInputs& inputs) {
  Json json = BeginResult("element", inputs);
  json["inputs"] = {{"files", json["inputs"]["files"]}};  // the wagon's options are those of a run
  json["bench"] = NameOf(bench);
  json["wagon"] = options.wagon.name;
  ElementParts parts = ReportBench(bench, options);
  json["runs"] = parts.runs;
  return {.title = parts.title,
          .answer = parts.answer,
          .table = parts.table,
          .remarks = parts.remarks,
          .text = FormatText(parts),
          .json = FormatJson(json),
          .series = std::move(parts.series),
          .figures = std::move(parts.figures)};
}

}  // namespace uiclink
