// Modes as a table and as drawings.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "vehicle/stability_report.h"
#include "vehicle/wagon_state.h"

namespace uiclink {
namespace {

constexpr std::size_t kMostModes = 8;
constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

struct Part {
  const char* head;
  std::size_t place;
  const char* name;
};
constexpr std::array<Part, 10> kShownParts{{{"front\nlateral", wheelset::kY, "front lateral"},
                                            {"front\nyaw", wheelset::kPsi, "front yaw"},
                                            {"front\nlongitudinal", wheelset::kX, "longitudinal"},
                                            {"rear\nlateral", kRearWheelset + wheelset::kY, "rear lateral"},
                                            {"rear\nlongitudinal", kRearWheelset + wheelset::kX, "longitudinal"},
                                            {"rear\nyaw", kRearWheelset + wheelset::kPsi, "rear yaw"},
                                            {"body\nlateral", kBody + body::kY, "body lateral"},
                                            {"body\nroll", kBody + body::kPhi, "body roll"},
                                            {"body\nyaw", kBody + body::kPsi, "body yaw"},
                                            {"body\nvertical", kBody + body::kZ, "body vertical"}}};

/// "0.84 at -92°"; "-" where it has no part worth the name.
std::string FormatPart(const std::complex<double>& value, double largest) {
  constexpr double kLeast = 5e-3;
  const double amplitude = std::abs(value) / largest;
  if (amplitude < kLeast) return "-";
  const long degrees = std::lround(std::arg(value) * 180 / std::numbers::pi);
  return fmt::format("{:.2f} at {}°", amplitude, degrees);
}

double LargestPart(const LinearMode& mode) {
  double largest = 0;
  for (const Part& part : kShownParts) largest = std::max(largest, std::abs(mode.shape[part.place]));
  return largest > 0 ? largest : 1;
}

std::string NameOf(const LinearMode& mode) {
  return std::ranges::max_element(kShownParts, {}, [&](const Part& part) { return std::abs(mode.shape[part.place]); })
      ->name;
}

/// A wagon from above, displaced as a mode is at a phase, every displacement times `factor`.
class Drawing {
 public:
  Drawing(const WagonInputs& inputs, const LinearMode& mode, double factor, double phase)
      : inputs_(inputs), mode_(mode), turn_(std::polar(factor, phase)) {}

  /// Outlines, one after the other with gaps between them.
  FigureSeries Body() const {
    const double length = inputs_.data.cargo.length / 2, width = inputs_.data.cargo.width / 2;
    FigureSeries series;
    for (const auto& [x, y] :
         {std::pair{length, width}, {-length, width}, {-length, -width}, {length, -width}, {length, width}})
      Add(At(kBody + body::kPsi, kBody + body::kY, x, y, inputs_.body.h * Now(kBody + body::kPhi)), &series);
    return series;
  }
  FigureSeries Wheelset(std::size_t axle) const {
    constexpr double kRail = 0.75, kWheel = 0.46;  // half the distance of the rails, radius of a wheel [m]
    const std::size_t begin = axle * kRearWheelset;
    const double along = Now(begin + wheelset::kX) + (axle == 0 ? 1 : -1) * inputs_.data.l;
    FigureSeries series;
    const auto stroke = [&](double x1, double y1, double x2, double y2) {
      for (const auto& [x, y] : {std::pair{x1, y1}, {x2, y2}}) {
        const auto [px, py] = At(begin + wheelset::kPsi, begin + wheelset::kY, x, y, 0);
        Add({px + along, py}, &series);
      }
      Add({kGap, kGap}, &series);
    };
    stroke(0, -inputs_.data.b, 0, inputs_.data.b);
    for (const double y : {-kRail, kRail}) stroke(-kWheel, y, kWheel, y);
    return series;
  }
  /// Of all points, across.
  double LargestMove() const {
    return std::abs(mode_.shape[kBody + body::kY]) + inputs_.body.h * std::abs(mode_.shape[kBody + body::kPhi]) +
           inputs_.data.l * std::abs(mode_.shape[kBody + body::kPsi]) + std::abs(mode_.shape[wheelset::kY]) +
           std::abs(mode_.shape[kRearWheelset + wheelset::kY]) + std::abs(mode_.shape[wheelset::kPsi]) +
           std::abs(mode_.shape[kRearWheelset + wheelset::kPsi]) + std::abs(mode_.shape[wheelset::kX]) +
           std::abs(mode_.shape[kRearWheelset + wheelset::kX]);
  }

 private:
  double Now(std::size_t place) const { return (turn_ * mode_.shape[place]).real(); }
  std::pair<double, double> At(std::size_t psi, std::size_t across, double x, double y, double more) const {
    return {x - Now(psi) * y, y + Now(psi) * x + Now(across) + more};
  }
  static void Add(const std::pair<double, double>& point, FigureSeries* series) {
    series->x.push_back(point.first);
    series->y.push_back(point.second);
  }

  const WagonInputs& inputs_;
  const LinearMode& mode_;
  std::complex<double> turn_;
};

FigurePanel MakePanel(const WagonInputs& inputs, const LinearMode& mode, bool legend) {
  constexpr double kDrawn = 1.2, kRail = 0.75;  // sum of the displacements as drawn [m]
  const double factor = kDrawn / std::max(Drawing(inputs, mode, 1, 0).LargestMove(), 1e-12);
  FigurePanel panel{
      .title = fmt::format("{}, {:.3f} Hz, damping {:.3f}", NameOf(mode), mode.frequency_hz(), mode.damping_ratio()),
      .x = {.label = "ahead", .unit = "m"},
      .y = {.label = "to the left", .unit = "m"},
      .horizontal_guides = {{-kRail, ""}, {kRail, ""}},
      .equal_scales = true};
  for (const bool later : {false, true}) {
    const Drawing drawing(inputs, mode, factor, later ? std::numbers::pi / 2 : 0);
    const auto add = [&](FigureSeries series, FigureColour colour, const char* name) {
      if (legend) series.name = name;
      series.colour = colour;
      series.line = later ? FigureLine::kDashed : FigureLine::kSolid;
      panel.series.push_back(std::move(series));
    };
    add(drawing.Body(), FigureColour::kGreen, later ? "a quarter of a period later" : "body");
    add(drawing.Wheelset(0), FigureColour::kBlue, later ? "" : "front wheelset");
    add(drawing.Wheelset(1), FigureColour::kVermilion, later ? "" : "rear wheelset");
  }
  return panel;
}

}  // namespace

std::vector<LinearMode> ChooseShownModes(const std::vector<LinearMode>& modes) {
  // Both wheelsets have the same longitudinal mode, each by itself; of two such modes any mixture is one, too.
  constexpr double kSame = 1e-6;
  std::vector<LinearMode> shown;
  for (const LinearMode& mode : modes) {
    const bool again = std::ranges::any_of(shown, [&](const LinearMode& other) {
      return std::abs(mode.lambda - other.lambda) < kSame * std::abs(mode.lambda);
    });
    if (mode.lambda.imag() > 0 && IsSlowRoot(mode.lambda) && !again) shown.push_back(mode);
  }
  std::ranges::stable_sort(shown, {}, &LinearMode::damping_ratio);
  if (shown.size() > kMostModes) shown.resize(kMostModes);
  return shown;
}

TextTable MakeModeTable(const std::vector<LinearMode>& modes) {
  TextTable table;
  table.AddColumn("mode", TextTable::Align::kLeft);
  table.AddColumn("frequency\n[Hz]");
  table.AddColumn("damping\n[-]");
  for (const Part& part : kShownParts) table.AddColumn(part.head);
  for (const LinearMode& mode : modes) {
    std::vector<std::string> row{NameOf(mode), fmt::format("{:.4f}", mode.frequency_hz()),
                                 fmt::format("{:+.4f}", mode.damping_ratio())};
    const double largest = LargestPart(mode);
    for (const Part& part : kShownParts) row.push_back(FormatPart(mode.shape[part.place], largest));
    table.AddRow(std::move(row));
  }
  return table;
}

Figure ModeFigure(const StabilityRun& run, const std::vector<LinearMode>& modes, double V) {
  Figure figure{.title = fmt::format("modes at {:.4g} m/s: {}, {}", V, run.inputs.data.name, run.inputs.freight.name),
                .columns = 2,
                .width = 1300,
                .panel_height = 270};
  for (const LinearMode& mode : modes) figure.panels.push_back(MakePanel(run.inputs, mode, figure.panels.empty()));
  return figure;
}

}  // namespace uiclink
