#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "vehicle/element_report.h"

namespace uiclink {

/// What one bench adds to the report; element_report.cpp puts it together.
struct ElementParts {
  std::string title;                         ///< "Impacts of a free wheelset in its guides (chapter 6)"
  std::string answer;                        ///< what came out, in a sentence or two that needs no other
  TextTable table;                           ///< a row for each run
  std::string below;                         ///< a line right below it; mostly empty
  std::vector<std::string> remarks;          ///< paragraphs
  std::vector<nlohmann::ordered_json> runs;  ///< an object each
  std::vector<ElementSeries> series;
  std::vector<std::pair<std::string, Figure>> figures;
};

ElementParts ReportLeafHarmonic(const ElementOptions& options);
ElementParts ReportLeafDrop(const ElementOptions& options);
ElementParts ReportParabolic(const ElementOptions& options);
ElementParts ReportGuidance(const ElementOptions& options);
ElementParts ReportDryFriction(const ElementOptions& options);

/// The values times a factor: for axes and columns in mm, kN.
std::vector<double> Scaled(const std::vector<double>& values, double factor);

}  // namespace uiclink
