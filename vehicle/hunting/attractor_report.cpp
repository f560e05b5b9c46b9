#include "vehicle/hunting/attractor_report.h"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "reports/text_table.h"
#include "vehicle/hunting/hunting_json.h"

namespace uiclink {
namespace {

constexpr auto kFront = static_cast<std::size_t>(TrackedMotion::kFrontLateral);
constexpr auto kRear = static_cast<std::size_t>(TrackedMotion::kRearLateral);
constexpr auto kBodyMotion = static_cast<std::size_t>(TrackedMotion::kBodyLateral);

const char* EndName(RunEnd end) {
  switch (end) {
    case RunEnd::kSettled:
      return "settled";
    case RunEnd::kUnsettled:
      return "unsettled";
    case RunEnd::kDerailed:
      return "derailed";
    case RunEnd::kFailed:
      return "failed";
  }
  return "?";
}

std::string FormatExponent(const Attractor& attractor) {
  if (attractor.lyapunov)
    return fmt::format("{:.4f} +- {:.4f}", attractor.lyapunov->exponent, attractor.lyapunov->error);
  return attractor.lyapunov_failure.empty() ? "-" : "failed";
}

Json AttractorToJson(const Attractor& attractor) {
  const RunOutcome& run = attractor.typical;
  return {{"share", attractor.share},
          {"share_low", attractor.low},
          {"share_high", attractor.high},
          {"starts", attractor.runs},
          {"end", EndName(run.end)},
          {"motion", MotionToJson(run.motion)},
          {"frequency_hz", run.frequency},
          {"amplitude_mm", AmplitudesToJson(run.half_width)},
          {"impacts",
           {{"front_lateral", {{"count", run.lateral[0].impacts.count}, {"peak_N", run.lateral[0].impacts.peak_N}}},
            {"rear_lateral", {{"count", run.lateral[1].impacts.count}, {"peak_N", run.lateral[1].impacts.peak_N}}}}},
          {"observed_s", run.observed},
          {"mirrored", attractor.mirrored},
          {"lyapunov", LyapunovToJson(attractor.lyapunov)}};
}

Json BoxToJson(const StartBox& box) {
  return {{"wheelset_lateral_mm", 1e3 * box.wheelset_y}, {"wheelset_yaw_mrad", 1e3 * box.wheelset_psi},
          {"body_lateral_mm", 1e3 * box.body_y},         {"body_yaw_mrad", 1e3 * box.body_psi},
          {"body_roll_mrad", 1e3 * box.body_phi},        {"least_factor", box.least_factor}};
}

/// Number of the attractor that each run led to, from 1; 0: none.
std::vector<std::size_t> NumberRuns(const AttractorSurvey& survey) {
  std::vector<std::size_t> numbers(survey.runs.size(), 0);
  for (std::size_t i = 0; i < survey.attractors.size(); ++i)
    for (const std::size_t run : survey.attractors[i].runs) numbers[run] = i + 1;
  return numbers;
}

}  // namespace

std::string DescribeMotion(const RunOutcome& run) {
  if (run.end == RunEnd::kDerailed || run.end == RunEnd::kFailed) return EndName(run.end);
  std::string text = MotionKindName(run.motion.kind);
  if (run.motion.k > 1) text += fmt::format(", {} returns", run.motion.k);
  if (run.motion.modulation_period > 0) text += fmt::format(", {:.3g} s", run.motion.modulation_period);
  if (run.end == RunEnd::kUnsettled) text += " (not settled)";
  return text;
}

std::string DescribeStarts(const AttractorSurvey& survey, const AttractorOptions& options) {
  const StartBox& box = options.box;
  return fmt::format(
      "{} start states at {:g} m/s, seed {}: within +- {:g} mm and {:g} mrad of each wheelset, {:g} mm, {:g} and {:g} "
      "mrad of the body\n(lateral, yaw, roll), sizes down to {:g} of that. Shares are of this set of starts.\n",
      survey.runs.size(), survey.V, options.seed, 1e3 * box.wheelset_y, 1e3 * box.wheelset_psi, 1e3 * box.body_y,
      1e3 * box.body_psi, 1e3 * box.body_phi, box.least_factor);
}

TextTable MakeSurveyTable(const AttractorSurvey& survey) {
  TextTable table;
  table.AddColumn("no");
  table.AddColumn("share\n[%]");
  table.AddColumn("95 % bounds\n[%]");
  table.AddColumn("motion\n(period of modulation)", TextTable::Align::kLeft);
  for (const char* head : {"frequency\n[Hz]", "front\n[mm]", "rear\n[mm]", "body\n[mm]", "Lyapunov exponent\n[1/s]"})
    table.AddColumn(head);
  for (std::size_t i = 0; i < survey.attractors.size(); ++i) {
    const Attractor& attractor = survey.attractors[i];
    const RunOutcome& run = attractor.typical;
    table.AddRow({fmt::format("{}", i + 1), fmt::format("{:.1f}", 100 * attractor.share),
                  fmt::format("{:.0f} to {:.0f}", 100 * attractor.low, 100 * attractor.high), DescribeMotion(run),
                  fmt::format("{:.3f}", run.frequency), fmt::format("{:.3f}", 1e3 * run.half_width[kFront]),
                  fmt::format("{:.3f}", 1e3 * run.half_width[kRear]),
                  fmt::format("{:.3f}", 1e3 * run.half_width[kBodyMotion]), FormatExponent(attractor)});
  }
  return table;
}

std::string FormatSurvey(const AttractorSurvey& survey, const AttractorOptions& options) {
  std::string text = DescribeStarts(survey, options) + MakeSurveyTable(survey).Format();
  if (survey.derailed + survey.failed + survey.unsettled > 0)
    text += fmt::format("{} derailed, {} failed, {} had not settled after {:g} s.\n", survey.derailed, survey.failed,
                        survey.unsettled, options.longest);
  return text;
}

std::vector<DataColumn> SurveyColumns(const AttractorSurvey& survey) {
  const std::vector<std::size_t> numbers = NumberRuns(survey);
  std::vector<DataColumn> columns;
  const auto add = [&](const std::string& name, const std::string& unit,
                       const std::function<double(const RunOutcome&)>& value) {
    columns.push_back({name, unit, {}});
    for (const RunOutcome& run : survey.runs) columns.back().values.push_back(value(run));
  };
  columns.push_back({"attractor", "", {numbers.begin(), numbers.end()}});
  add("start_front_lateral", "mm", [](const RunOutcome& run) { return 1e3 * run.start.front_y; });
  add("start_rear_lateral", "mm", [](const RunOutcome& run) { return 1e3 * run.start.rear_y; });
  add("start_body_lateral", "mm", [](const RunOutcome& run) { return 1e3 * run.start.body_y; });
  add("start_front_yaw", "mrad", [](const RunOutcome& run) { return 1e3 * run.start.front_psi; });
  add("start_rear_yaw", "mrad", [](const RunOutcome& run) { return 1e3 * run.start.rear_psi; });
  add("start_body_yaw", "mrad", [](const RunOutcome& run) { return 1e3 * run.start.body_psi; });
  add("start_body_roll", "mrad", [](const RunOutcome& run) { return 1e3 * run.start.body_phi; });
  add("simulated", "s", [](const RunOutcome& run) { return run.simulated; });
  add("frequency", "Hz", [](const RunOutcome& run) { return run.frequency; });
  add("modulation_period", "s", [](const RunOutcome& run) { return run.motion.modulation_period; });
  for (std::size_t i = 0; i < kMotionCount; ++i)
    add(std::string(kMotionNames[i]) + "_amplitude",
        i < static_cast<std::size_t>(TrackedMotion::kBodyYaw) ? "mm" : "mrad",
        [i](const RunOutcome& run) { return 1e3 * run.half_width[i]; });
  return columns;
}

Json AmplitudesToJson(const std::array<double, kMotionCount>& half_widths) {
  Json json = Json::object();
  for (std::size_t i = 0; i < kMotionCount; ++i) json[kMotionNames[i]] = NumberOrNull(1e3 * half_widths[i]);
  return json;
}

Json LyapunovToJson(const std::optional<LyapunovResult>& lyapunov) {
  if (!lyapunov) return nullptr;
  return {{"exponent_1_per_s", NumberOrNull(lyapunov->exponent)},
          {"error_1_per_s", NumberOrNull(lyapunov->error)},
          {"over_s", lyapunov->duration}};
}

Json MotionToJson(const SectionMotion& motion) {
  return {{"kind", MotionKindName(motion.kind)},
          {"returns", motion.k},
          {"period_s", NumberOrNull(motion.period)},
          {"modulation_period_s", motion.modulation_period > 0 ? Json(motion.modulation_period) : Json(nullptr)},
          {"rate_1_per_s", NumberOrNull(motion.rate)}};
}

Json SurveyToJson(const AttractorSurvey& survey, const AttractorOptions& options) {
  Json json{{"speed", survey.V},
            {"starts", survey.runs.size()},
            {"seed", options.seed},
            {"start_box", BoxToJson(options.box)},
            {"settle_s", options.settle},
            {"longest_s", options.longest},
            {"derailed", survey.derailed},
            {"failed", survey.failed},
            {"unsettled", survey.unsettled},
            {"wall_s", survey.wall_s}};
  json["attractors"] = Json::array();
  for (const Attractor& attractor : survey.attractors) json["attractors"].push_back(AttractorToJson(attractor));
  return json;
}

}  // namespace uiclink
