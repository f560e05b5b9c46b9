// The page of `wagon simulate`.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/hunting/guidance_history.h"
#include "vehicle/hunting/hunting_bounds.h"
#include "vehicle/page/animation.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

double AmplitudeOf(const SimulationResult& result, TrackedMotion motion) {
  return result.motions[static_cast<std::size_t>(motion)].amplitude;
}

std::span<const SimulationSample> WindowOf(const SimulationRun& run) {
  const std::vector<SimulationSample>& samples = run.result.samples;
  if (samples.empty()) return {};
  const auto first = std::ranges::lower_bound(samples, samples.back().t - run.window, {}, &SimulationSample::t);
  return {first, samples.end()};
}

double HalfWidth(std::span<const SimulationSample> samples, std::size_t place) {
  const auto [low, high] = std::ranges::minmax(samples, {}, [place](const SimulationSample& s) { return s.x[place]; });
  return (high.x[place] - low.x[place]) / 2;
}

// ---------------------------------------------------------------- the answer

/// "hunts", "hunts, and its motion is still growing", ...: by the two halves of the window.
std::string DescribeState(const SimulationRun& run) {
  constexpr double kSteady = 0.1;  // halves that differ by less are the same
  const double front = AmplitudeOf(run.result, TrackedMotion::kFrontLateral),
               rear = AmplitudeOf(run.result, TrackedMotion::kRearLateral);
  const bool rear_leads = rear > front;
  if (std::max(front, rear) < kHuntingLeast) return "runs quietly: no wheelset moves sideways by more than 0.05 mm";
  const std::span<const SimulationSample> window = WindowOf(run);
  constexpr std::size_t kEnough = 100;
  if (window.size() < kEnough) return "moves from side to side";
  const std::size_t place = rear_leads ? kRearWheelset + wheelset::kY : static_cast<std::size_t>(wheelset::kY);
  const double first = HalfWidth(window.first(window.size() / 2), place),
               second = HalfWidth(window.last(window.size() / 2), place);
  if (second < (1 - kSteady) * first) return "swings from side to side, less and less";
  return second > (1 + kSteady) * first ? "hunts, more and more" : "hunts";
}

std::string DescribeMotion(const SimulationRun& run) {
  const SimulationResult& result = run.result;
  const MotionFigures& front = result.motions[static_cast<std::size_t>(TrackedMotion::kFrontLateral)];
  const double rear = AmplitudeOf(result, TrackedMotion::kRearLateral),
               body = AmplitudeOf(result, TrackedMotion::kBodyLateral);
  const double last = std::min(run.window, result.simulated);
  const std::string start =
      fmt::format("At {} {} {}", FormatSpeedTwice(result.V), DescribeLoadedWagon(run.inputs), DescribeState(run));
  if (std::max({front.amplitude, rear, body}) < kHuntingLeast)
    return start + fmt::format(" in the last {:.4g} s.", last);
  const std::string often =
      front.frequencies.empty() ? "" : fmt::format(", {:.2f} times a second", front.frequencies.front());
  return fmt::format(
      "{}. In the last {:.4g} s the front wheelset goes {:.2f} mm to either side, the rear one {:.2f} mm and the body "
      "{:.2f} mm{}.",
      start, last, 1e3 * front.amplitude, 1e3 * rear, 1e3 * body, often);
}

std::string DescribeGuidance(const SimulationRun& run) {
  if (!run.inputs.choice.options.guidance) return "The guides of the axle boxes were taken away.";
  const SimulationResult& result = run.result;
  int count = 0;
  double peak = 0, used = 0;
  for (const auto& uses : {result.lateral, result.longitudinal}) {
    for (const GuidanceUse& use : uses) {
      count += use.impacts.count;
      peak = std::max(peak, use.impacts.peak_N);
    }
  }
  for (const GuidanceUse& use : result.lateral) used = std::max(used, use.clearance_used);
  if (count > 0)
    return fmt::format("The axle boxes struck their guides {} time{}, with up to {:.2f} kN.", count,
                       count == 1 ? "" : "s", 1e-3 * peak);
  return fmt::format("No axle box touched its guides: of the {:.0f} mm to the side it used at most {:.1f} mm.",
                     1e3 * run.inputs.data.guidance.lateral.clearance, 1e3 * used);
}

std::string DescribeWheels(const SimulationRun& run, const Wagon& wagon) {
  const SimulationResult& result = run.result;
  const std::size_t corner = result.minimum_wheel_corner;
  const double at_rest = wagon.corners[corner].load + wagon.wheelset.m * wagon.g / 2;
  return fmt::format("The least load of a wheel was {:.1f} kN ({}), {:.0f} % of what it carries at rest{}.",
                     1e-3 * result.minimum_wheel_load, SpellOut(kCornerNames[corner]),
                     100 * result.minimum_wheel_load / at_rest,
                     result.derailed     ? "; the wagon derailed"
                     : result.wheel_lift ? "; a wheel left its rail"
                                         : "");
}

std::string DescribeEnd(const SimulationResult& result) {
  return result.end == SimulationEnd::kDuration ? "" : "The run ended early: " + result.end_reason + ".";
}

// ---------------------------------------------------------------- figures

FigurePanel PhasePanel(std::span<const SimulationSample> window, const std::string& title, std::size_t x, std::size_t y,
                       const FigureAxis& x_axis, const FigureAxis& y_axis, FigureColour colour) {
  FigurePanel panel{.title = title, .x = x_axis, .y = y_axis, .series = {{.colour = colour, .width = 1}}};
  for (const SimulationSample& sample : window) {
    panel.series[0].x.push_back(1e3 * sample.x[x]);
    panel.series[0].y.push_back(1e3 * sample.x[y]);
  }
  return panel;
}

Figure PhaseFigure(const SimulationRun& run) {
  const std::span<const SimulationSample> window = WindowOf(run);
  const FigureAxis place{.label = "lateral", .unit = "mm"}, rate{.label = "rate", .unit = "mm/s"},
      angle{.label = "roll", .unit = "mrad"}, turning{.label = "rate", .unit = "mrad/s"};
  const std::size_t rear = kRearWheelset + wheelset::kY;
  Figure figure{.title = fmt::format("phase portraits, last {:g} s", std::min(run.window, run.result.simulated)),
                .columns = 3,
                .width = 1300,
                .panel_height = 320};
  figure.panels = {
      PhasePanel(window, "front wheelset", wheelset::kY, wheelset::kYRate, place, rate, FigureColour::kBlue),
      PhasePanel(window, "rear wheelset", rear, kRearWheelset + wheelset::kYRate, place, rate,
                 FigureColour::kVermilion),
      PhasePanel(window, "body", kBody + body::kY, kBody + body::kYRate, place, rate, FigureColour::kGreen),
      PhasePanel(window, "body, roll", kBody + body::kPhi, kBody + body::kPhiRate, angle, turning,
                 FigureColour::kGreen),
      PhasePanel(window, "rear over front wheelset", wheelset::kY, rear, {.label = "front, lateral", .unit = "mm"},
                 {.label = "rear, lateral", .unit = "mm"}, FigureColour::kPurple),
      PhasePanel(window, "front wheelset, yaw over lateral", wheelset::kY, wheelset::kPsi, place,
                 {.label = "yaw", .unit = "mrad"}, FigureColour::kBlue)};
  return figure;
}

/// Spectra need some lines to have a peak, and samples fast enough for hunting.
bool HasSpectra(std::span<const SimulationSample> window, double hz) {
  constexpr std::size_t kLeastSamples = 64;
  constexpr double kLeastHz = 20;
  return window.size() >= kLeastSamples && hz >= kLeastHz;
}

void AddSpectra(const SimulationRun& run, WagonBook* book) {
  const std::span<const SimulationSample> window = WindowOf(run);
  if (window.size() < 2) return;
  const double hz = static_cast<double>(window.size() - 1) / (window.back().t - window.front().t);
  if (!HasSpectra(window, hz)) return;
  SpectrumRun spectrum{.inputs = run.inputs, .V = run.result.V, .source = run.start};
  spectrum.spectrum = CalcRunningSpectrum(window, hz);
  if (spectrum.spectrum.at_rest) return;
  book->page().Heading(2, "Spectra", "spectra");
  book->Draw("spectrum", SpectrumFigure(spectrum),
             fmt::format("Power against frequency in the last {:.4g} s; numbers are the frequencies of peaks [Hz]. "
                         "wagon spectrum gives finer ones, with phase locking and losses.",
                         static_cast<double>(window.size()) / hz));
  book->page().Table("Lines of all motions", MakeLineTable(spectrum.spectrum));
}

void AddMotions(const SimulationRun& run, WagonBook* book) {
  book->page().Heading(2, "Motions", "motions");
  if (!run.result.samples.empty()) {
    Figure histories = HistoryFigure(run);
    LinkTimeAxes(&histories);
    const std::string name = run.start_s > 0 ? fmt::format("histories_from_{:g}s", run.start_s) : "histories";
    book->Draw(run.start_s > 0 ? name : "histories", histories,
               "Motions and wheel loads. All time axes of the page zoom together.");
  }
  book->page().Table(
      fmt::format("The last {:.4g} s of {:.4g} s", std::min(run.window, run.result.simulated), run.result.simulated),
      MakeMotionTable(run.result));
}

void AddGuidance(const SimulationRun& run, const Wagon& wagon, WagonBook* book) {
  book->page().Heading(2, "Clearances and impacts", "guidance");
  if (!run.result.samples.empty()) {
    Figure figure = GuidanceFigure("axle boxes against their guides", CalcGuidanceHistory(wagon, run.result.samples),
                                   run.result.simulated);
    LinkTimeAxes(&figure);
    book->Draw(
        "guidance", figure,
        "Forces of the guides on the wheelsets, and how far the axle boxes are from the body; grey lines are the "
        "guides. The curves are sampled: peaks of short impacts are in the table, which has every step.");
  }
  book->page().Table("Over the whole run", MakeGuidanceTable(run));
}

}  // namespace

std::string ComposeSimulationPage(const SimulationRun& run, const Wagon& wagon, const PageBounds& bounds,
                                  const PageOrigin& origin) {
  WagonBook book(fmt::format("Wagon at {:g} m/s: {}", run.result.V, DescribeWagonOnRails(run.inputs)), origin);
  book.Answer(
      JoinSentences({DescribeEnd(run.result), DescribeMotion(run), DescribeGuidance(run), DescribeWheels(run, wagon)}));
  book.page().Paragraph(fmt::format("{:.4g} s were simulated; start: {}.", run.result.simulated, run.start), "quiet");
  book.Notices(run.inputs.notices);
  if (!FormatAnimation(run.result, wagon, run.inputs).empty()) {
    book.page().Heading(2, "From above", "from-above");
    InsertAnimation(run.result, wagon, run.inputs, "animation", &book.page());
  }
  AddMotions(run, &book);
  AddGuidance(run, wagon, &book);
  AddSpectra(run, &book);
  if (WindowOf(run).size() > 1) {
    book.page().Heading(2, "Phase portraits", "phases");
    book.Draw("phases", PhaseFigure(run),
              "Velocities over displacements: a closed curve is a motion that repeats itself.");
  }
  book.Bounds(fmt::format("{:g} m/s, {}", run.result.V, run.inputs.freight.name), bounds);
  return book.Finish(run.inputs);
}

}  // namespace uiclink
