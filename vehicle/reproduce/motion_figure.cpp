// Time histories as figures 10.8 to 10.20 have them.

#include <fmt/format.h>

#include "vehicle/reproduce/motion.h"
#include "vehicle/wagon_state.h"

namespace uiclink::reproduce {
namespace {

constexpr double kCloseUp = 5;  // [s]: a few periods of hunting

struct Curve {
  const char* name;
  std::size_t place;
  bool in_close_up = true;
};

struct Rows {
  const char* title;
  FigureAxis y;
  std::vector<Curve> curves;
};

const FigureAxis kMillimetres{.label = "displacement", .unit = "mm"}, kMilliradians{.label = "angle", .unit = "mrad"};

/// Figures 10.8 to 10.20 leave the body out of the close view.
const std::vector<Rows> kImpactRows{
    {"lateral",
     kMillimetres,
     {{"front wheelset", wheelset::kY},
      {"rear wheelset", kRearWheelset + wheelset::kY},
      {"body", kBody + body::kY, false}}},
    {"yaw", kMilliradians, {{"front wheelset", wheelset::kPsi}, {"rear wheelset", kRearWheelset + wheelset::kPsi}}}};

/// Figures 10.27 to 10.30 show the motions whose spectra they have.
const std::vector<Rows> kSpectrumRows{
    {"longitudinal", kMillimetres, {{"front wheelset", wheelset::kX}, {"rear wheelset", kRearWheelset + wheelset::kX}}},
    {"lateral",
     kMillimetres,
     {{"front wheelset", wheelset::kY},
      {"rear wheelset", kRearWheelset + wheelset::kY},
      {"body", kBody + body::kY, false}}},
    {"yaw", kMilliradians, {{"front wheelset", wheelset::kPsi}, {"rear wheelset", kRearWheelset + wheelset::kPsi}}},
    {"body, yaw and roll", kMilliradians, {{"yaw", kBody + body::kPsi}, {"roll", kBody + body::kPhi}}}};

FigurePanel MakePanel(const SimulationResult& run, const Rows& rows, double from, bool close_up) {
  FigurePanel panel{.title = close_up ? fmt::format("{}, last {:g} s", rows.title, kCloseUp) : rows.title,
                    .x = {.label = "time", .unit = "s"},
                    .y = rows.y};
  for (const Curve& curve : rows.curves) {
    if (close_up && !curve.in_close_up) continue;
    FigureSeries series{.name = close_up ? "" : curve.name};
    for (const SimulationSample& sample : run.samples) {
      if (sample.t < from) continue;
      series.x.push_back(sample.t);
      series.y.push_back(1e3 * sample.x[curve.place]);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

Figure MotionFigure(const SimulationResult& run, const std::string& title, bool spectra, double shown) {
  Figure figure{.title = title, .panels = {}, .columns = 2, .width = 1300, .panel_height = 230};
  if (run.samples.empty()) return figure;
  const double end = run.samples.back().t;
  for (const Rows& rows : spectra ? kSpectrumRows : kImpactRows) {
    figure.panels.push_back(MakePanel(run, rows, end - shown, false));
    figure.panels.back().x.link = title;
    figure.panels.push_back(MakePanel(run, rows, end - kCloseUp, true));
    figure.panels.back().x.link = title + ", close";
  }
  return figure;
}

}  // namespace uiclink::reproduce
