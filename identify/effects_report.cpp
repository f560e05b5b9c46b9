#include "identify/effects_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "reports/wrap.h"

namespace uiclink {
namespace {

constexpr std::size_t kColumns = 100;  // of the terminal
constexpr std::size_t kTextColumn = 18;

void AddEntry(std::string_view name, std::string_view text, std::string* out) {
  if (text.empty()) return;
  *out += fmt::format("  {:<{}}{}\n", name, kTextColumn - 2, Wrap(text, kTextColumn, kColumns));
}

std::string FormatBounds(const EffectParameter& p) {
  if (std::isinf(p.high)) return fmt::format("above {:g}", p.low);
  return fmt::format("{:g} to {:g}", p.low, p.high);
}

std::string FormatParameter(const Effect& effect, const EffectParameter& p) {
  std::string text = fmt::format("{} [{}]  {}, {}", p.symbol, p.unit, p.meaning, FormatBounds(p));
  if (p.scope == Scope::kRecord) text += ", each record its own";
  if (&p == &effect.parameters.front() && !effect.quadrature) text += fmt::format("; none at {:g}", effect.neutral);
  return text;
}

std::string FormatSignature(const Signature& signature) {
  std::string text(signature.text);
  if (signature.loss_exponent > 0)
    text += fmt::format("; energy loss while all joints roll: ~ amplitude^{:g}", signature.loss_exponent);
  return text;
}

std::string FormatEffect(const Effect& effect) {
  std::string out = fmt::format("{}\n", effect.id);
  AddEntry("missing", effect.title, &out);
  AddEntry("acts on", Name(effect.acts_on), &out);
  AddEntry("equation", effect.equation, &out);
  for (const EffectParameter& p : effect.parameters)
    AddEntry(&p == &effect.parameters.front() ? "parameters" : "", FormatParameter(effect, p), &out);
  AddEntry("look for", FormatSignature(effect.signature), &out);
  AddEntry("confused with", effect.confused_with, &out);
  AddEntry("separated by", effect.separated_by, &out);
  AddEntry("never named:", effect.unseen, &out);
  return out;
}

using Json = nlohmann::ordered_json;

Json OrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json OrNull(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

Json ToJson(const EffectParameter& p) {
  return {{"symbol", p.symbol},   {"unit", p.unit},         {"meaning", p.meaning},
          {"low", OrNull(p.low)}, {"high", OrNull(p.high)}, {"scope", p.scope == Scope::kRecord ? "record" : "link"}};
}

Json ToJson(const Effect& effect) {
  Json parameters = Json::array();
  for (const EffectParameter& p : effect.parameters) parameters.push_back(ToJson(p));
  return {{"id", effect.id},
          {"title", effect.title},
          {"equation", effect.equation},
          {"acts_on", Name(effect.acts_on)},
          {"parameters", parameters},
          {"neutral", OrNull(effect.neutral)},
          {"signature",
           {{"text", effect.signature.text},
            {"loss_exponent", effect.signature.loss_exponent},
            {"even_harmonics", effect.signature.even_harmonics}}},
          {"confused_with", effect.confused_with},
          {"separated_by", effect.separated_by},
          {"unseen", OrNull(effect.unseen)},
          {"repairs", effect.repairs}};
}

}  // namespace

std::string FormatEffects(std::span<const Effect* const> effects) {
  std::string out =
      fmt::format("{} effects that the plain model, y''/g = -k y + sum of the joints' T, lacks.\n", effects.size());
  out += Wrap(
             "Forces are divided by the load M g; y [m] is the displacement, t [s] the record's clock. Bounds are "
             "physical: an effect is named only inside them.",
             0, kColumns) +
         '\n';
  for (const Effect* effect : effects) out += '\n' + FormatEffect(*effect);
  return out;
}

std::string FormatEffectsJson(std::span<const Effect* const> effects) {
  Json list = Json::array();
  for (const Effect* effect : effects) list.push_back(ToJson(*effect));
  const Json json = {{"schema", "identify-effects/1"}, {"effects", list}};
  return json.dump(2) + '\n';
}

}  // namespace uiclink
