#include "vehicle/hunting/progress_file.h"

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "data/input_error.h"
#include "vehicle/state_file.h"

namespace uiclink {
namespace {

constexpr const char* kTraceSchema = "wagon-trace-progress/1";
constexpr const char* kRunSchema = "wagon-attractors-progress/1";
/// FormatState wants a speed, which a state alone does not have.
constexpr double kNoSpeed = 1;

double NumberOf(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json StateToJson(const Wagon& wagon, const WagonState& state) {
  return FormatState(wagon, {.state = state, .V = kNoSpeed, .identity = "-"});
}
WagonState StateOf(const Json& json, const std::string& file, const Wagon& wagon) {
  return ParseState(json.get<std::string>(), file, wagon, "").state;
}

template <std::size_t n>
Json NumbersToJson(const std::array<double, n>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(NumberOrNull(value));
  return json;
}
template <std::size_t n>
std::array<double, n> NumbersOf(const Json& json) {
  std::array<double, n> values{};
  for (std::size_t i = 0; i < n; ++i) values[i] = NumberOf(json.at(i));
  return values;
}

/// What of a use belongs to a stretch (WindowWatch::Lateral).
Json UsesToJson(const std::array<GuidanceUse, kAxles>& uses) {
  Json json = Json::array();
  for (const GuidanceUse& use : uses)
    json.push_back({NumberOrNull(use.clearance_used), use.impacts.count, NumberOrNull(use.impacts.peak_N)});
  return json;
}
std::array<GuidanceUse, kAxles> UsesOf(const Json& json) {
  std::array<GuidanceUse, kAxles> uses{};
  for (std::size_t i = 0; i < kAxles; ++i) {
    uses[i].clearance_used = NumberOf(json.at(i).at(0));
    uses[i].impacts.count = json.at(i).at(1).get<int>();
    uses[i].impacts.peak_N = NumberOf(json.at(i).at(2));
  }
  return uses;
}

Json RowToJson(const TraceRow& row) {
  return {{"V", row.V},
          {"leg", row.leg},
          {"largest", NumbersToJson(row.largest)},
          {"half_width", NumbersToJson(row.half_width)},
          {"lateral", UsesToJson(row.lateral)},
          {"longitudinal", UsesToJson(row.longitudinal)},
          {"minimum_wheel_load", NumberOrNull(row.minimum_wheel_load)},
          {"wheel_lift", row.wheel_lift},
          {"derailed", row.derailed}};
}
TraceRow RowOf(const Json& json) {
  TraceRow row;
  row.V = json.at("V").get<double>();
  row.leg = json.at("leg").get<std::size_t>();
  row.largest = NumbersOf<kMotionCount>(json.at("largest"));
  row.half_width = NumbersOf<kMotionCount>(json.at("half_width"));
  row.lateral = UsesOf(json.at("lateral"));
  row.longitudinal = UsesOf(json.at("longitudinal"));
  row.minimum_wheel_load = NumberOf(json.at("minimum_wheel_load"));
  row.wheel_lift = json.at("wheel_lift").get<bool>();
  row.derailed = json.at("derailed").get<bool>();
  return row;
}

Json MotionToJson(const SectionMotion& motion) {
  return {{"kind", static_cast<int>(motion.kind)},
          {"k", motion.k},
          {"numbers", NumbersToJson(std::array{motion.period, motion.modulation_period, motion.rate, motion.scatter,
                                               motion.tolerance, motion.correlation})}};
}
SectionMotion MotionOf(const Json& json) {
  const auto numbers = NumbersOf<6>(json.at("numbers"));
  return {.kind = static_cast<MotionKind>(json.at("kind").get<int>()),
          .k = json.at("k").get<int>(),
          .period = numbers[0],
          .modulation_period = numbers[1],
          .rate = numbers[2],
          .scatter = numbers[3],
          .tolerance = numbers[4],
          .correlation = numbers[5]};
}

Json OutcomeToJson(const Wagon& wagon, std::size_t number, const RunOutcome& run) {
  return {{"number", number},
          {"end", static_cast<int>(run.end)},
          {"reason", run.reason},
          {"motion", MotionToJson(run.motion)},
          {"numbers", NumbersToJson(std::array{run.simulated, run.observed, run.frequency, run.minimum_wheel_load})},
          {"half_width", NumbersToJson(run.half_width)},
          {"middle", NumbersToJson(run.middle)},
          {"lateral", UsesToJson(run.lateral)},
          {"longitudinal", UsesToJson(run.longitudinal)},
          {"wheel_lift", run.wheel_lift},
          {"state", StateToJson(wagon, run.state)}};
}
RunOutcome OutcomeOf(const Json& json, const std::string& file, const Wagon& wagon) {
  RunOutcome run;
  run.end = static_cast<RunEnd>(json.at("end").get<int>());
  run.reason = json.at("reason").get<std::string>();
  run.motion = MotionOf(json.at("motion"));
  const auto numbers = NumbersOf<4>(json.at("numbers"));
  run.simulated = numbers[0];
  run.observed = numbers[1];
  run.frequency = numbers[2];
  run.minimum_wheel_load = numbers[3];
  run.half_width = NumbersOf<kMotionCount>(json.at("half_width"));
  run.middle = NumbersOf<kMotionCount>(json.at("middle"));
  run.lateral = UsesOf(json.at("lateral"));
  run.longitudinal = UsesOf(json.at("longitudinal"));
  run.wheel_lift = json.at("wheel_lift").get<bool>();
  run.state = StateOf(json.at("state"), file, wagon);
  return run;
}

std::string Dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// Calls `take` with the text as JSON, if it is what is looked for.
/// @return whether it was.
bool ReadProgress(const std::string& text, const std::string& file, const char* schema, const Json& of,
                  const std::function<void(const Json&)>& take) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != schema) return false;
    if (json.at("of") != of) return false;
    take(json);
    return true;
  } catch (const nlohmann::json::exception&) {
    throw InputError(file, 0, std::string("expected ") + schema + " as a run leaves it, found something else");
  }
}

}  // namespace

std::string FormatTraceProgress(const Wagon& wagon, const Json& of, const TraceProgress& progress) {
  Json json{{"schema", kTraceSchema}, {"of", of}, {"wall_s", progress.wall_s}, {"rows", Json::array()}};
  for (const TraceRow& row : progress.rows) json["rows"].push_back(RowToJson(row));
  json["state"] = StateToJson(wagon, progress.at.state);
  return Dump(json);
}

std::optional<TraceProgress> ParseTraceProgress(const std::string& text, const std::string& file, const Wagon& wagon,
                                                const Json& of) {
  TraceProgress progress;
  const bool same = ReadProgress(text, file, kTraceSchema, of, [&](const Json& json) {
    progress.wall_s = json.at("wall_s").get<double>();
    for (const Json& row : json.at("rows")) progress.rows.push_back(RowOf(row));
    progress.at = {progress.rows.size(), StateOf(json.at("state"), file, wagon)};
  });
  return same ? std::optional(std::move(progress)) : std::nullopt;
}

std::string FormatRunProgress(const Wagon& wagon, const Json& of, const KnownRuns& runs) {
  Json json{{"schema", kRunSchema}, {"of", of}, {"runs", Json::array()}};
  for (const auto& [number, run] : runs) json["runs"].push_back(OutcomeToJson(wagon, number, run));
  return Dump(json);
}

std::optional<KnownRuns> ParseRunProgress(const std::string& text, const std::string& file, const Wagon& wagon,
                                          const Json& of) {
  KnownRuns runs;
  const bool same = ReadProgress(text, file, kRunSchema, of, [&](const Json& json) {
    for (const Json& run : json.at("runs"))
      runs.emplace(run.at("number").get<std::size_t>(), OutcomeOf(run, file, wagon));
  });
  return same ? std::optional(std::move(runs)) : std::nullopt;
}

}  // namespace uiclink
