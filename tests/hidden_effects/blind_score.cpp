#include "tests/hidden_effects/blind_score.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace uiclink {
namespace {

using Json = nlohmann::json;

bool Contains(const std::vector<std::string>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

/// Is the truth inside low..high? A bound of null is open.
bool IsInside(const Json& parameter, double truth) {
  const Json& low = parameter.at("low");
  const Json& high = parameter.at("high");
  return (low.is_null() || low.get<double>() <= truth) && (high.is_null() || truth <= high.get<double>());
}

Inside ReadInside(const Json& parameters, bool shared, const WrittenCase& written) {
  const char* names[] = {"k", "k1", "T01"};
  const auto values = [](const LinkTruth& t) { return std::array<double, 3>{t.k, t.k1, t.T01}; };
  const std::array<double, 3> population = values(written.population);
  const std::array<double, 3> records = values(shared ? written.population : written.records_mean);
  Inside inside;
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& parameter = parameters.at(names[i]);
    inside.population[i] = IsInside(parameter, population[i]);
    inside.records[i] = IsInside(parameter, records[i]);
  }
  return inside;
}

void ReadCandidates(const Json& diagnosis, CaseResult* result) {
  result->best_wrong = result->plain;
  result->best_wrong_effect = "(plain model)";
  const std::vector<std::string>& hidden = result->blind.effects;
  for (const Json& candidate : diagnosis.at("candidates")) {
    const std::string effect = candidate.at("effect");
    if (result->blind.kind != CaseKind::kPair && Contains(hidden, effect)) continue;
    // An effect that the screen dropped has not been fitted: the plain model's figure stands for it.
    const auto told = candidate.find("rms_over_noise");
    if (told == candidate.end() || told->is_null()) continue;
    const double ratio = result->noise_factor * told->get<double>();
    if (ratio >= result->best_wrong) continue;
    result->best_wrong = ratio;
    result->best_wrong_effect = effect;
  }
}

void ReadDiagnosis(const Json& answer, const WrittenCase& written, CaseResult* result) {
  const auto diagnosis = answer.find("diagnosis");
  if (diagnosis == answer.end() || !diagnosis->is_object()) {
    result->fault = "identify's JSON has no `diagnosis`";
    return;
  }
  result->verdict = diagnosis->at("verdict");
  for (const Json& cause : diagnosis->at("causes"))
    result->causes.push_back({cause.at("effect"), cause.at("rivals").get<std::vector<std::string>>()});
  ReadCandidates(*diagnosis, result);
  const auto extended = answer.find("extended_fit");
  if (extended == answer.end() || extended->is_null()) {
    if (!result->causes.empty()) result->fault = "a cause is named, but there is no `extended_fit`";
    return;
  }
  result->extended = result->noise_factor * extended->at("rms_over_noise").get<double>();
  const bool shared = extended->value("shared", result->shared);
  result->extended_inside = ReadInside(extended->at("parameters"), shared, written);
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " + ") + word;
  return text;
}

std::string FormatTruth(const BlindCase& blind) {
  if (!blind.effects.empty()) return Join(blind.effects);
  return blind.variant.empty() ? "nothing" : "nothing (" + blind.variant + ")";
}

std::string FormatCauses(const CaseResult& result) {
  if (!result.fault.empty()) return result.fault;
  std::string text;
  for (const NamedCause& cause : result.causes) {
    text += (text.empty() ? "" : "; ") + cause.effect;
    if (!cause.rivals.empty()) text += " (or " + Join(cause.rivals) + ")";
  }
  return text.empty() ? "-" : text;
}

std::string FormatFlags(const std::array<bool, 3>& inside) {
  std::string text;
  for (const bool is_inside : inside) text += is_inside ? 'y' : 'n';
  return text;
}

}  // namespace

void ReadAnswer(const std::string& json, const WrittenCase& written, CaseResult* result) {
  try {
    const Json answer = Json::parse(json);
    for (const Json& record : answer.at("records"))
      if (!record.at("used").get<bool>())
        throw std::runtime_error("a record was left out: " + record.at("reason").get<std::string>());
    const Json& fit = answer.at("fit");
    result->plain = fit.at("rms_mm").get<double>() / written.noise_mm;
    result->noise_factor = result->plain / fit.at("rms_over_noise").get<double>();
    result->shared = fit.at("shared");
    result->plain_inside = ReadInside(fit.at("parameters"), result->shared, written);
    result->extended = result->plain;
    result->extended_inside = result->plain_inside;
    ReadDiagnosis(answer, written, result);
  } catch (const std::exception& error) {
    result->fault = error.what();
  }
}

bool Counts(const CaseResult& result) { return result.fault.empty() && result.best_wrong >= kCounts; }

bool IsNamedAlone(const CaseResult& result) {
  return result.causes.size() == 1 && result.causes[0].rivals.empty() &&
         result.causes[0].effect == result.blind.effects.at(0);
}

bool IsNamedOrRival(const CaseResult& result) {
  if (result.causes.empty() || result.causes[0].rivals.size() > kMostRivals) return false;
  const std::string& truth = result.blind.effects.at(0);
  return result.causes[0].effect == truth || Contains(result.causes[0].rivals, truth);
}

bool IsAmongCauses(const CaseResult& result, std::string_view effect) {
  return std::any_of(result.causes.begin(), result.causes.end(),
                     [&](const NamedCause& cause) { return cause.effect == effect; });
}

bool IsFound(const CaseResult& result, std::string_view effect) {
  return std::any_of(result.causes.begin(), result.causes.end(), [&](const NamedCause& cause) {
    return cause.effect == effect || (cause.rivals.size() <= kMostRivals && Contains(cause.rivals, effect));
  });
}

std::string FormatHeading() {
  return fmt::format("{:>6} {:<8}{:<40} {:>9} {:>9} {:>9}  {:<17} {:<5} {:<5} {:<4} {:<4} {:>6}  {}\n", "case", "kind",
                     "hidden", "plain", "extended", "wrong", "verdict", "alone", "rival", "in", "in_x", "s",
                     "best wrong | causes | sizes");
}

std::string FormatRow(const CaseResult& r) {
  const bool is_single = r.IsSingle() && r.fault.empty();
  return fmt::format(
      "{:>6} {:<8}{:<40} {:>9.2f} {:>9.2f} {:>9.2f}  {:<17} {:<5} {:<5} {:<4} {:<4} {:>6.2f}  {} | {} | {}{}\n",
      r.blind.number, Name(r.blind.kind), FormatTruth(r.blind), r.plain, r.extended, r.best_wrong,
      r.verdict.empty() ? "-" : r.verdict,
      !is_single        ? "-"
      : IsNamedAlone(r) ? "yes"
                        : "no",
      !is_single          ? "-"
      : IsNamedOrRival(r) ? "yes"
                          : "no",
      FormatFlags(r.plain_inside.records), FormatFlags(r.extended_inside.records), r.wall_s,
      r.best_wrong_effect.empty() ? "-" : r.best_wrong_effect, FormatCauses(r), Join(r.blind.sizes),
      r.blind.scattered ? " | scattered" : "");
}

}  // namespace uiclink
