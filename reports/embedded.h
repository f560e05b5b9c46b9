#pragma once

#include <string_view>

namespace uiclink {

/// plotly.js, the bundle of cartesian charts (MIT licence), as one script; empty if this program was built without it.
std::string_view PlotlyBundle();
/// Its licence, to be kept with every copy.
std::string_view PlotlyLicense();
/// page/chart.js: makes charts of what FormatChart (reports/chart.h) writes.
std::string_view ChartScript();
/// page/style.css: how every page looks.
std::string_view PageStyle();

}  // namespace uiclink
