#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/hunting/running_spectrum_report.h"

namespace uiclink {
namespace {

/// Above it nothing hunts; tables 10.1 and 10.2 end at 6.1 Hz.
constexpr double kHighestShown = 10;  // [Hz]
constexpr double kCloseUp = 8;        // [s] of impacts: some periods of hunting

std::string Words(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

std::string Title(const SpectrumRun& run, const std::string& what) {
  const std::string speed = run.V > 0 ? fmt::format(" at {:g} m/s", run.V) : "";
  return fmt::format("{} of {}{}, {}, {}", what, run.inputs.data.name, speed, run.inputs.freight.name,
                     run.inputs.table.name);
}

FigurePanel SpectrumPanel(const RunningSpectrum& spectrum, std::size_t motion) {
  const SpectrumMotion& entry = kSpectrumTable[motion];
  const PowerSpectrum& power = spectrum.motions[motion].power;
  const double factor = 1e6;  // mm^2, mrad^2
  FigurePanel panel{
      .title = Words(entry.name),
      .x = {.label = "frequency", .unit = "Hz", .low = 0, .high = std::min(kHighestShown, spectrum.hz / 2)},
      .y = {.label = "power", .unit = entry.angle ? "mrad²/Hz" : "mm²/Hz", .log = true}};
  FigureSeries series;
  double largest = 0;
  for (std::size_t i = 1; i < power.density.size(); ++i) {
    const double f = static_cast<double>(i) * power.line_hz;
    if (f > *panel.x.high) break;
    series.x.push_back(f);
    series.y.push_back(factor * power.density[i]);
    largest = std::max(largest, series.y.back());
  }
  // What is below is the window's and the integrator's.
  if (largest > 0) panel.y.low = 1e-10 * largest;
  for (const SpectralLine& line : spectrum.motions[motion].lines) {
    const auto at = static_cast<std::size_t>(std::lround(line.frequency / power.line_hz));
    if (line.frequency < *panel.x.high && at < power.density.size())
      panel.notes.push_back({line.frequency, factor * power.density[at], fmt::format("{:.3f}", line.frequency)});
  }
  panel.series.push_back(std::move(series));
  return panel;
}

/// A history from a time on.
struct Shown {
  const GuidanceHistory& history;
  double from = 0;  ///< [s]
};

FigureSeries TimeSeries(const std::string& name, const Shown& shown, const std::vector<double>& values, double factor) {
  const GuidanceHistory& history = shown.history;
  FigureSeries series{.name = name};
  for (std::size_t i = 0; i < history.t.size(); ++i) {
    if (history.t[i] < shown.from) continue;
    series.x.push_back(history.t[i]);
    series.y.push_back(factor * values[i]);
  }
  return series;
}

FigurePanel LongitudinalForces(const Shown& shown, std::size_t axle, const std::string& name) {
  const GuidanceHistory& history = shown.history;
  return {.title = name + ", longitudinal guide forces",
          .x = {"time", "s"},
          .y = {"force", "kN"},
          .series = {TimeSeries("left box", shown, history.longitudinal[2 * axle].force, 1e-3),
                     TimeSeries("right box", shown, history.longitudinal[2 * axle + 1].force, 1e-3)}};
}

FigurePanel LateralForce(const Shown& shown, std::size_t axle, const std::string& name) {
  return {.title = name + ", lateral guide force",
          .x = {"time", "s"},
          .y = {"force", "kN"},
          .series = {TimeSeries("", shown, shown.history.lateral[axle].force, 1e-3)}};
}

FigurePanel ClearancePanel(const std::string& title, double clearance, std::vector<FigureSeries> series) {
  return {.title = title,
          .x = {"time", "s"},
          .y = {"axle box against body", "mm"},
          .series = std::move(series),
          .horizontal_guides = {{1e3 * clearance, "guide"}, {-1e3 * clearance, "guide"}}};
}

FigureColour ColourOf(const std::string& where) {
  if (where == "lateral") return FigureColour::kBlue;
  if (where == "longitudinal") return FigureColour::kGreen;
  return where == "vertical" ? FigureColour::kOrange : FigureColour::kVermilion;
}

std::string NameOf(const LossSum& sum) {
  if (sum.where == "vertical") return "vertical springs, " + Words(sum.what);
  return sum.where == "wheel" ? Words(sum.what) : sum.where + " links, " + Words(sum.what);
}

/// One bar a row, from zero to the right, named at its end.
FigurePanel BarPanel(const std::string& title, const FigureAxis& measure) {
  FigurePanel panel{.title = title, .x = measure, .y = {.reversed = true, .numbers = false, .low = 0.3}};
  return panel;
}

void AddBar(double value, double row, FigureColour colour, double width, FigurePanel* panel) {
  panel->series.push_back({.name = "", .x = {0, value}, .y = {row, row}, .colour = colour, .width = width});
  panel->y.high = row + 0.7;
}

/// Bars of one kind over all corners, and corner by corner with a gap before the next kind.
void AddBars(const LossSum& sum, double share, double cycles, FigurePanel* all, FigurePanel* corners) {
  const FigureColour colour = ColourOf(sum.where);
  const double row = all->y.high ? *all->y.high + 0.3 : 1;
  AddBar(sum.Sum() / cycles, row, colour, 14, all);
  all->notes.push_back(
      {std::max(sum.Sum() / cycles, 0.0), row + 0.2, fmt::format("{}: {:.1f} %", NameOf(sum), 100 * share)});
  const double first = corners->y.high ? *corners->y.high + 1.3 : 1;
  for (std::size_t i = 0; i < kCorners; ++i)
    AddBar(sum.lost[i] / cycles, first + static_cast<double>(i), colour, 5, corners);
  const double longest = std::max(*std::ranges::max_element(sum.lost), 0.0) / cycles;
  corners->notes.push_back({longest, first + 2.2, NameOf(sum)});
}

/// Room for the names at the ends of the bars.
void LeaveRoom(double share, FigurePanel* panel) {
  double low = 0, high = 0;
  for (const FigureSeries& bar : panel->series) {
    low = std::min(low, bar.x.back());
    high = std::max(high, bar.x.back());
  }
  panel->x.low = low < 0 ? 1.1 * low : 0;
  panel->x.high = high > 0 ? high * (1 + share) : 1;
}

}  // namespace

Figure SpectrumFigure(const SpectrumRun& run) {
  Figure figure{.title = Title(run, "spectra"), .columns = 2, .width = 1300, .panel_height = 320};
  for (std::size_t motion = 0; motion < kSpectrumMotions; ++motion) {
    const std::string name = kSpectrumTable[motion].name;
    if (name.starts_with("front_") || name == "body_roll") figure.panels.push_back(SpectrumPanel(run.spectrum, motion));
  }
  return figure;
}

Figure ImpactFigure(const SpectrumRun& run) { return GuidanceFigure(Title(run, "impacts"), run.guidance, kCloseUp); }

Figure GuidanceFigure(const std::string& title, const GuidanceHistory& history, double duration) {
  const Shown shown{history, history.t.empty() ? 0 : history.t.back() - duration};
  Figure figure{.title = title, .columns = 2, .width = 1300, .panel_height = 250};
  const std::array<std::string, kAxles> names{"front wheelset", "rear wheelset"};
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    figure.panels.push_back(LongitudinalForces(shown, axle, names[axle]));
    figure.panels.push_back(LateralForce(shown, axle, names[axle]));
  }
  std::vector<FigureSeries> boxes;
  for (std::size_t i = 0; i < kCorners; ++i)
    boxes.push_back(TimeSeries(Words(kCornerNames[i]), shown, history.longitudinal[i].displacement, 1e3));
  figure.panels.push_back(ClearancePanel("longitudinal clearance", history.longitudinal_clearance, std::move(boxes)));
  figure.panels.push_back(ClearancePanel("lateral clearance", history.lateral_clearance,
                                         {TimeSeries("front", shown, history.lateral[0].displacement, 1e3),
                                          TimeSeries("rear", shown, history.lateral[1].displacement, 1e3)}));
  return figure;
}

Figure LossFigure(const SpectrumRun& run) {
  const std::vector<LossSum> sums = SumLosses(run.loss_parts);
  const double lost = run.losses.Lost();
  const double cycles = run.cycles > 0 ? run.cycles : 1;
  const FigureAxis axis{.label = run.cycles > 0 ? "energy per cycle" : "energy", .unit = "J"};
  Figure figure{.title = Title(run, "losses"), .columns = 2, .width = 1400};
  FigurePanel all = BarPanel("all corners", axis),
              corners = BarPanel("front left, front right, rear left, rear right, from the top", axis);
  for (const LossSum& sum : sums) AddBars(sum, lost != 0 ? sum.Sum() / lost : 0, cycles, &all, &corners);
  LeaveRoom(0.9, &all);
  LeaveRoom(0.9, &corners);
  figure.panel_height = std::max(300, 110 + 45 * static_cast<int>(sums.size()));
  figure.panels = {std::move(all), std::move(corners)};
  return figure;
}

}  // namespace uiclink
