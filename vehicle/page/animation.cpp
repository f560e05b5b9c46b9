#include "vehicle/page/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "reports/embed.h"
#include "reports/escape.h"
#include "vehicle/guidance.h"
#include "vehicle/report_json.h"

UICLINK_EMBED(wagon_view_script, UICLINK_WAGON_VIEW_SCRIPT);

namespace uiclink {
namespace {

constexpr double kShown = 10;       // [s]
constexpr double kFramesPerS = 50;  // at most
constexpr double kLeastPerS = 10;   // fewer tell nothing of hunting at 1 to 5 Hz
constexpr std::size_t kLeastFrames = 20;
constexpr double kMetres = 1e-5, kRadians = 1e-6;  // steps of the numbers in the page

struct DrawnMotion {
  const char* name;
  std::size_t place;
  double step;
};
constexpr std::array<DrawnMotion, 9> kDrawn{{{"front_x", wheelset::kX, kMetres},
                                             {"front_y", wheelset::kY, kMetres},
                                             {"front_psi", wheelset::kPsi, kRadians},
                                             {"rear_x", kRearWheelset + wheelset::kX, kMetres},
                                             {"rear_y", kRearWheelset + wheelset::kY, kMetres},
                                             {"rear_psi", kRearWheelset + wheelset::kPsi, kRadians},
                                             {"body_y", kBody + body::kY, kMetres},
                                             {"body_psi", kBody + body::kPsi, kRadians},
                                             {"body_phi", kBody + body::kPhi, kRadians}}};

/// What is touched in a sample.
unsigned FindTouches(const Wagon& wagon, const StateVector<double>& x, double flange) {
  unsigned bits = 0;
  const auto mark = [&bits](std::size_t bit, bool touched) { bits |= (touched ? 1U : 0U) << bit; };
  for (std::size_t c = 0; c < kCorners; ++c) {
    if (wagon.options.guidance) {
      const CornerDeflection<double> d = CalcDeflection(wagon, x, c);
      const int across = TouchedSide(wagon.guidance.lateral, d.dy),
                along = TouchedSide(wagon.guidance.longitudinal, d.dx);
      mark(4 * c, across > 0);
      mark(4 * c + 1, across < 0);
      mark(4 * c + 2, along > 0);
      mark(4 * c + 3, along < 0);
    }
    const double y = x[AxleOf(c) * kRearWheelset + wheelset::kY];
    mark(4 * kCorners + c, flange > 0 && SideOf(c) * y > flange);
  }
  return bits;
}

Json CornersToJson(const Wagon& wagon) {
  Json corners = Json::array();
  for (std::size_t c = 0; c < kCorners; ++c)
    corners.push_back({{"axle", AxleOf(c) == 0 ? "front" : "rear"},
                       {"side", SideOf(c)},
                       {"X", wagon.corners[c].X},
                       {"Y", wagon.corners[c].Y}});
  return corners;
}

/// Distance of the rails' tops from the middle: where the wheels stand when the wheelset is centred [m].
double FindRail(const ContactTable& table) {
  return std::ranges::min_element(table.rows, {}, [](const ContactRow& row) { return std::abs(row.y); })->a_rail;
}

Json WagonToJson(const Wagon& wagon, const WagonInputs& inputs, double flange) {
  return {{"b", wagon.b},
          {"l", inputs.data.l},
          {"h", wagon.body.h},
          {"com", wagon.body.x},
          {"length", inputs.data.cargo.length},
          {"width", inputs.data.cargo.width},
          {"rail", FindRail(inputs.table)},
          {"flange", flange},
          {"guided", wagon.options.guidance},
          {"lateral", wagon.guidance.lateral.clearance},
          {"longitudinal", wagon.guidance.longitudinal.clearance},
          {"corners", CornersToJson(wagon)}};
}

/// Samples that are drawn, and how many of them make a frame.
struct Shown {
  std::span<const SimulationSample> samples;
  std::size_t stride = 1;
  double hz = 0;  ///< frames per second
};

std::optional<Shown> ChooseSamples(const SimulationResult& result) {
  const std::vector<SimulationSample>& samples = result.samples;
  if (samples.size() < kLeastFrames) return std::nullopt;
  const double hz = static_cast<double>(samples.size() - 1) / (samples.back().t - samples.front().t);
  if (!(hz >= kLeastPerS)) return std::nullopt;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(hz / kFramesPerS + 1e-6)));
  const auto wanted = std::min(samples.size(), static_cast<std::size_t>(kShown * hz) + 1);
  return Shown{std::span(samples).last(wanted), stride, hz / static_cast<double>(stride)};
}

}  // namespace

double FindFlangePlay(const ContactTable& table) {
  constexpr double kFlangeAngle = std::numbers::pi / 6;  // treads end below 12 degrees, flanges have 60 to 70
  for (const ContactRow& row : table.rows)
    if (row.y > 0 && row.delta > kFlangeAngle) return row.y;
  return 0;
}

std::string FormatAnimation(const SimulationResult& result, const Wagon& wagon, const WagonInputs& inputs) {
  const std::optional<Shown> shown = ChooseSamples(result);
  if (!shown) return {};
  const double flange = FindFlangePlay(inputs.table);
  Json json{{"wagon", WagonToJson(wagon, inputs, flange)}, {"hz", shown->hz}, {"begin", shown->samples.front().t}};
  for (const DrawnMotion& motion : kDrawn) {
    Json steps = Json::array();
    for (std::size_t i = 0; i < shown->samples.size(); i += shown->stride)
      steps.push_back(std::lround(shown->samples[i].x[motion.place] / motion.step));
    json["frames"][motion.name] = std::move(steps);
  }
  json["touches"] = Json::array();
  for (std::size_t i = 0; i < shown->samples.size(); i += shown->stride) {
    unsigned bits = 0;  // also of the samples up to the next frame: impacts are short
    for (std::size_t k = i; k < std::min(i + shown->stride, shown->samples.size()); ++k)
      bits |= FindTouches(wagon, shown->samples[k].x, flange);
    json["touches"].push_back(bits);
  }
  return json.dump();
}

void InsertAnimation(const SimulationResult& result, const Wagon& wagon, const WagonInputs& inputs,
                     const std::string& id, HtmlPage* page) {
  const std::string json = FormatAnimation(result, wagon, inputs);
  if (json.empty()) return;
  const std::string description =
      "The wagon from above: body (green), wheelsets (front blue, rear orange-red), springs and links at the axle "
      "boxes, "
      "the guides as a frame around each box, the flanges beside the rails. Displacements, and clearances with them, "
      "are "
      "drawn enlarged; everything else to scale. A guide or a flange that is touched turns thick and orange-red; small "
      "strokes below the curves mark contact with a guide.";
  page->Insert(fmt::format("<figure class=\"wagon-view\" id=\"{}\">\n<div class=\"stage\" role=\"group\" "
                           "aria-label=\"animation of the wagon from above\"></div>\n<figcaption>{}</figcaption>\n"
                           "<noscript><p class=\"warning\">This needs JavaScript.</p></noscript>\n"
                           "<script type=\"application/json\">{}</script>\n</figure>\n",
                           id, EscapeMarkup(description), json),
               UICLINK_EMBEDDED(wagon_view_script));
}

}  // namespace uiclink
