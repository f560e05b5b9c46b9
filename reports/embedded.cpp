#include "reports/embedded.h"

#include "reports/embed.h"

UICLINK_EMBED(plotly_bundle, UICLINK_PLOTLY_BUNDLE);
UICLINK_EMBED(plotly_license, UICLINK_PLOTLY_LICENSE);
UICLINK_EMBED(chart_script, UICLINK_CHART_SCRIPT);
UICLINK_EMBED(page_style, UICLINK_PAGE_STYLE);

namespace uiclink {

std::string_view PlotlyBundle() { return UICLINK_EMBEDDED(plotly_bundle); }
std::string_view PlotlyLicense() { return UICLINK_EMBEDDED(plotly_license); }
std::string_view ChartScript() { return UICLINK_EMBEDDED(chart_script); }
std::string_view PageStyle() { return UICLINK_EMBEDDED(page_style); }

}  // namespace uiclink
