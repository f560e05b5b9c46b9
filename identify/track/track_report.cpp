#include "identify/track/track_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "identify/upper_median.h"

namespace uiclink::track {
namespace {

using Json = nlohmann::ordered_json;

std::string FormatBox(const Box& box) { return fmt::format("{},{},{},{}", box.x, box.y, box.width, box.height); }

Json ToJson(const Box& box) { return {box.x, box.y, box.width, box.height}; }

/// Against the picture's horizontal, counter-clockwise [degrees].
double AxisDegrees(const TrackResult& result) {
  return std::atan2(-result.axis.y, result.axis.x) * 180 / std::numbers::pi;
}

double Rate(const TrackResult& result) { return result.times.step > 0 ? 1 / result.times.step : 0; }

Json CameraToJson(const TrackResult& result) {
  const CameraMotion& camera = result.camera;
  Json used = Json::array(), unsteady = Json::array();
  for (const Box& box : camera.used) used.push_back(ToJson(box));
  for (const Box& box : camera.unsteady) unsteady.push_back(ToJson(box));
  return {{"model", Name(camera.model)},
          {"shift_rms_pixel", camera.shift_rms},
          {"turn_rms_rad", camera.turn_rms},
          {"disagreement_pixel", camera.disagreement},
          {"used", used},
          {"unsteady", unsteady}};
}

Json LeftOutToJson(const TrackResult& result) {
  Json left_out = Json::array();
  for (const LeftOutPicture& left : result.left_out)
    left_out.push_back({{"picture", left.picture + 1}, {"reason", Reason(left.why)}});
  return left_out;
}

Json GapsToJson(const TrackResult& result) {
  Json gaps = Json::array();
  for (const Gap& gap : result.times.gaps)
    gaps.push_back({{"after_picture", gap.before + 1}, {"missing", gap.pictures ? Json(*gap.pictures) : Json()}});
  return gaps;
}

}  // namespace

std::string FormatTrack(const TrackResult& result) {
  const auto [low, high] = std::minmax_element(result.y.begin(), result.y.end());
  const double uncertainty = UpperMedian(result.uncertainty);
  std::string text = fmt::format("{}: {} samples of {} pictures ({} x {}), {:.4g} to {:.4g} s, {}{:.6g} a second\n",
                                 result.file, result.t.size(), result.pictures, result.width, result.height,
                                 result.t.front(), result.t.back(), result.times.even ? "" : "about ", Rate(result));
  text += fmt::format("  patch         {}{}, correlation {:.3f}\n", FormatBox(result.roi),
                      result.tag_id ? fmt::format(" (tag {})", *result.tag_id) : "", result.median_score);
  text += fmt::format("  axis          {:.2f} degrees against the horizontal; across it {:.2g} % of the motion\n",
                      AxisDegrees(result), 100 * result.cross_share);
  text += fmt::format("  scale         {:.6g} mm/pixel{}\n", result.mm_per_pixel,
                      result.scale_error > 0 ? fmt::format(" +- {:.2g} % (tag)", 100 * result.scale_error) : "");
  text += fmt::format("  displacement  {:.4g} to {:.4g} mm, standard deviation {:.2g} mm ({:.2g} pixel)\n", 1e3 * *low,
                      1e3 * *high, 1e3 * uncertainty, result.FramePixels(uncertainty));
  text += fmt::format("  camera        {}", Name(result.camera.model));
  if (result.camera.model != CameraModel::kUnknown)
    text += fmt::format(": {:.2g} pixel and {:.2g} mrad rms, by {} background patches", result.camera.shift_rms,
                        1e3 * result.camera.turn_rms, result.camera.used.size());
  text += result.shutter
              ? fmt::format(
                    "\n  shutter       open for about {:.0f} % of the time, which takes {:.2g} % of the amplitude\n",
                    100 * *result.shutter, 100 * result.shutter_loss)
              : fmt::format("\n  shutter       takes at most {:.2g} % of the amplitude\n", 100 * result.shutter_loss);
  for (const std::string& notice : result.notices) text += fmt::format("  note          {}\n", notice);
  for (const std::string& warning : result.warnings) text += fmt::format("  warning       {}\n", warning);
  return text;
}

std::string FormatTrackJson(const TrackResult& result) {
  std::vector<std::size_t> pictures = result.picture;
  for (std::size_t& picture : pictures) ++picture;  // counted from 1, as in messages
  std::vector<double> y_mm, uncertainty_mm;
  for (std::size_t i = 0; i < result.y.size(); ++i)
    y_mm.push_back(1e3 * result.y[i]), uncertainty_mm.push_back(1e3 * result.uncertainty[i]);
  const Json json{{"schema", "track/1"},
                  {"file", result.file},
                  {"pictures", result.pictures},
                  {"width", result.width},
                  {"height", result.height},
                  {"samples", result.t.size()},
                  {"rate_hz", Rate(result)},
                  {"even", result.times.even},
                  {"roi", ToJson(result.roi)},
                  {"tag_id", result.tag_id ? Json(*result.tag_id) : Json()},
                  {"mm_per_pixel", result.mm_per_pixel},
                  {"scale_relative_error", result.scale_error},
                  {"axis", {result.axis.x, result.axis.y}},
                  {"cross_share", result.cross_share},
                  {"median_score", result.median_score},
                  {"median_uncertainty_mm", UpperMedian(uncertainty_mm)},
                  {"shutter_open_share", result.shutter ? Json(*result.shutter) : Json()},
                  {"shutter_loss", result.shutter_loss},
                  {"camera", CameraToJson(result)},
                  {"missing", result.missing},
                  {"gaps", GapsToJson(result)},
                  {"left_out", LeftOutToJson(result)},
                  {"notices", result.notices},
                  {"warnings", result.warnings},
                  {"t_s", result.t},
                  {"displacement_mm", y_mm},
                  {"uncertainty_mm", uncertainty_mm},
                  {"picture", pictures}};
  return json.dump(2) + '\n';
}

std::string FormatTrackComments(const TrackResult& result) {
  std::string text;
  for (const Gap& gap : result.times.gaps)
    text += fmt::format("# {} missing after picture {} ({})\n",
                        gap.pictures ? fmt::format("{} picture{}", *gap.pictures, *gap.pictures == 1 ? "" : "s")
                                     : "unknown number of pictures",
                        gap.before + 1,
                        result.times.t[gap.before] ? fmt::format("{:.6g} s", *result.times.t[gap.before]) : "no time");
  for (const LeftOutPicture& left : result.left_out)
    text += fmt::format("# picture {} left out, {}\n", left.picture + 1, Reason(left.why));
  return text;
}

}  // namespace uiclink::track
