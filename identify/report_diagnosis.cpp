// What the plain model lacks, told to an engineer at a terminal.
#include "identify/report_diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/gain_by_amplitude.h"
#include "identify/report.h"
#include "identify/report_tables.h"
#include "reports/text_table.h"
#include "reports/wrap.h"

namespace uiclink {
namespace {

constexpr std::size_t kColumns = 110;  // of the terminal
constexpr std::size_t kIndent = 2;
constexpr std::size_t kMostSymptoms = 6;
using Align = TextTable::Align;

std::string Replace(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// Paragraph and list item. A number stays on one line with its unit or symbol.
std::string Bound(const std::string& text) {
  constexpr std::string_view kNoBreak = "\u00a0";
  std::string bound = text;
  for (const char* together : {" %", " mm", " Hz", " = ", " noise levels"})
    bound = Replace(bound, together, Replace(together, " ", kNoBreak));
  return bound;
}
std::string Tell(const std::string& text) { return Replace(Paragraph(Bound(text), kIndent, kColumns), "\u00a0", " "); }
std::string Item(const std::string& text) {
  return std::string(kIndent, ' ') + "- " + Replace(Wrap(Bound(text), kIndent + 2, kColumns), "\u00a0", " ") + '\n';
}

}  // namespace

std::string FormatP(double p) {
  if (p < 1e-6) return "< 1e-6";
  return p > 0.995 ? "1" : fmt::format("{:.1g}", p);
}

std::string FormatRatio(double ratio) {
  return std::isfinite(ratio) ? fmt::format("{:.{}f}", ratio, ratio < 10 ? 2 : 1) : "-";
}

std::string FormatMm(double metres) {
  const double mm = 1e3 * metres;
  return fmt::format("{:.{}f}", mm, mm < 0.1 ? 4 : 3);
}

namespace {

/// Metres are told as millimetres.
double UnitScale(const EffectEstimate& e) { return e.unit == "m" ? 1e3 : 1; }
std::string UnitName(const EffectEstimate& e) { return e.unit == "m" ? "mm" : e.unit; }

/// "T_r = 0.00030 (95 %: 0.00029 to 0.00031)"
std::string FormatEstimate(const EffectEstimate& e) {
  const double scale = UnitScale(e), std = scale * e.std;
  const std::string unit = UnitName(e) == "-" ? "" : " " + UnitName(e);
  std::string text = fmt::format("{} = {}{} (95 %: {} to {})", e.symbol, Round(scale * e.value, std), unit,
                                 Round(scale * e.low, std), Round(scale * e.high, std));
  if (e.spread > 0) text += ", mean of the records";
  return text;
}

}  // namespace

std::string ListParameters(const std::vector<EffectEstimate>& parameters) {
  std::string list;
  for (const EffectEstimate& e : parameters) list += (list.empty() ? "" : ", ") + FormatEstimate(e);
  return list;
}

std::string NameOf(const Effect& effect) { return fmt::format("{} ({})", effect.title, effect.id); }

namespace {

std::string ListNames(const std::vector<const Effect*>& effects) {
  std::string list;
  for (std::size_t i = 0; i < effects.size(); ++i)
    list += (i == 0 ? "" : i + 1 == effects.size() ? " and " : ", ") + std::string(effects[i]->id);
  return list;
}

// ---------------------------------------------------------------- the answer

/// "falls from 49.4 to 1.00 noise levels (0.645 to 0.0131 mm)"
std::string FormatFall(double before, double after, double noise) {
  return fmt::format("from {} to {} noise levels ({} to {} mm)", FormatRatio(before / noise),
                     FormatRatio(after / noise), FormatMm(before), FormatMm(after));
}

std::string FormatHeldOut(const HeldOut& held_out, double noise) {
  if (!held_out.known) return "nothing could be held out to check it";
  return fmt::format("on {} that it was not fitted to, {}",
                     held_out.by_time ? "the later part of the record" : "records",
                     FormatFall(held_out.rms_before, held_out.rms_after, noise));
}

std::string DescribeAdequate(const Diagnosis& diagnosis) {
  return fmt::format(
      "Verdict: adequate. What the plain model leaves of these records cannot be told from their noise (rms {} noise "
      "levels; a noise level is the standard deviation of one reading), and none of the {} effects that were tried "
      "adds "
      "anything that is more than chance.",
      FormatRatio(diagnosis.plain.structure.RmsOverNoise()), diagnosis.candidates.size());
}

std::string DescribeUnexplained(const Diagnosis& diagnosis) {
  return fmt::format(
      "Verdict: unexplained. The plain model leaves {} noise levels (a noise level is the standard deviation of one "
      "reading; 1 would be noise alone), and none of the {} effects that were tried accounts for it. Something is "
      "missing that the catalogue does not have: k, ki and T0i below and above are not to be trusted as they stand.",
      FormatRatio(diagnosis.plain.structure.RmsOverNoise()), diagnosis.candidates.size());
}

/// "friction of the rolling joints (rolling_friction), T_r = ..., and ..."
std::string ListCauses(const Diagnosis& diagnosis) {
  std::string list;
  for (const Cause& cause : diagnosis.causes) {
    if (!list.empty()) list += &cause == &diagnosis.causes.back() ? "; and " : "; ";
    list += NameOf(*cause.effect);
    const std::string parameters = ListParameters(cause.parameters);
    if (!parameters.empty()) list += ", " + parameters;
  }
  return list;
}

std::string DescribeCauses(const Diagnosis& diagnosis) {
  const bool whole = diagnosis.verdict == Verdict::kExplained, one = diagnosis.causes.size() == 1;
  const double noise = diagnosis.extended.structure.noise;
  std::string text = fmt::format("Verdict: {}. The plain model lacks {}. With {} the rms falls {}",
                                 whole ? "explained" : "partly explained", ListCauses(diagnosis), one ? "it" : "these",
                                 FormatFall(diagnosis.plain.structure.rms, diagnosis.extended.structure.rms, noise));
  if (one) text += "; " + FormatHeldOut(diagnosis.causes[0].held_out, noise);
  text += ". A noise level is the standard deviation of one reading; 1 is noise alone.";
  text += whole
              ? " Nothing is left that is more than noise."
              : " Structure is left that no effect of the catalogue accounts for: the values are not to be trusted as "
                "they stand.";
  return text;
}

}  // namespace

std::string FormatAnswer(const Diagnosis& diagnosis) {
  switch (diagnosis.verdict) {
    case Verdict::kAdequate:
      return DescribeAdequate(diagnosis);
    case Verdict::kUnexplained:
      return DescribeUnexplained(diagnosis);
    case Verdict::kExplained:
    case Verdict::kPartlyExplained:
      break;
  }
  return DescribeCauses(diagnosis);
}

namespace {

// ---------------------------------------------------------------- causes

std::string DescribeRepairs(const Cause& cause) {
  if (cause.repairable == 0) return "";
  std::string list;
  for (const std::string& id : cause.repaired) list += (list.empty() ? "" : ", ") + id;
  if (list.empty())
    return fmt::format("Read-outs that were wrong and that it should repair: {}; none comes right, which is doubtful.",
                       cause.repairable);
  return fmt::format("Read-outs that were wrong and that it should repair: {}; come right with it: {} ({}).",
                     cause.repairable, cause.repaired.size(), list);
}

}  // namespace

std::string DescribeRivals(const Cause& cause) {
  if (cause.rivals.empty()) return "No other effect does as well in its place.";
  std::string text = fmt::format(
      "These records cannot tell it from {}, which {} as well in its place. What would separate them: for {}, {}",
      ListNames(cause.rivals), cause.rivals.size() == 1 ? "does" : "do", cause.effect->id, cause.effect->separated_by);
  for (const Effect* rival : cause.rivals) text += fmt::format("; for {}, {}", rival->id, rival->separated_by);
  return text + ".";
}

std::string DescribeCause(const Diagnosis& diagnosis, const Cause& cause) {
  const double noise = diagnosis.extended.structure.noise;
  std::string text = fmt::format("{}: {}.", cause.effect->id, cause.effect->signature.text);
  for (const EffectEstimate& e : cause.parameters) text += fmt::format(" {}: {}.", e.symbol, e.meaning);
  if (diagnosis.causes.size() > 1)
    text += fmt::format(" Beside the others it takes the rms {}; {}.",
                        FormatFall(cause.rms_before, cause.rms_after, noise), FormatHeldOut(cause.held_out, noise));
  text += fmt::format(" Probability that chance does as much, over the whole catalogue: p {}{}.",
                      cause.p_value < 1e-6 ? "" : "= ", FormatP(cause.p_value));
  for (const std::string& more : {DescribeRivals(cause), DescribeRepairs(cause)})
    if (!more.empty()) text += " " + more;
  return text;
}

namespace {

std::string FormatCauses(const Diagnosis& diagnosis) {
  std::string text;
  for (const Cause& cause : diagnosis.causes) text += Item(DescribeCause(diagnosis, cause));
  return text.empty() ? "" : text + "\n";
}

// ---------------------------------------------------------------- parameters

}  // namespace

std::string DescribeSharingChange(const Identification& id, const ExtendedResult& extended) {
  if (id.CountUsed() < 2) return "";
  const bool shares = extended.sharing == Sharing::kLink;
  if (shares == id.shared) return "";
  return fmt::format(
      "With the named cause in the model the records share one link (p = {}): what looked like scatter between records "
      "was what the model lacked.",
      FormatP(extended.sharing_p));
}

namespace {

void AddLinkRows(const Identification& id, const Diagnosis& diagnosis, TextTable* table) {
  for (const ParameterShift& shift : CalcParameterShifts(id, diagnosis)) {
    int quantity = 0;
    while (QuantityName(id.sliders, quantity) != shift.symbol) ++quantity;
    const Estimate& plain = id.quantities[static_cast<std::size_t>(quantity)];
    const Estimate& extended = diagnosis.extended.quantities[static_cast<std::size_t>(quantity)];
    table->AddRow({shift.symbol, shift.symbol.find("T0") != std::string::npos ? "-" : "1/m",
                   Round(plain.value, plain.std), Round(plain.std, plain.std), Round(extended.value, extended.std),
                   Round(extended.std, extended.std), Round(extended.low, extended.std),
                   Round(extended.high, extended.std), fmt::format("{:+.1f} %", 100 * shift.shift / extended.value),
                   fmt::format("{:+.1f}", shift.in_std)});
  }
}

}  // namespace

TextTable MakeLinkTable(const Identification& id, const Diagnosis& diagnosis) {
  TextTable table;
  table.AddColumn("parameter", Align::kLeft);
  table.AddColumn("unit", Align::kLeft);
  table.AddColumn("plain\nmodel");
  table.AddColumn("\nstd");
  table.AddColumn("extended\nmodel");
  table.AddColumn("\nstd");
  table.AddColumn("95 % bounds\nlow");
  table.AddColumn("\nhigh");
  table.AddColumn("plain is\noff by");
  table.AddColumn("in std of\nthe plain");
  AddLinkRows(id, diagnosis, &table);
  return table;
}

TextTable MakeEffectTable(const std::vector<EffectEstimate>& effects) {
  TextTable table;
  table.AddColumn("effect", Align::kLeft);
  table.AddColumn("parameter", Align::kLeft);
  table.AddColumn("unit", Align::kLeft);
  table.AddColumn("value");
  table.AddColumn("std");
  table.AddColumn("95 % bounds\nlow");
  table.AddColumn("\nhigh");
  for (const EffectEstimate& e : effects) {
    const double scale = UnitScale(e), std = scale * e.std;
    table.AddRow({std::string(e.effect->id), e.symbol, UnitName(e), Round(scale * e.value, std), Round(std, std),
                  Round(scale * e.low, std), Round(scale * e.high, std)});
  }
  return table;
}

namespace {

std::string FormatParameters(const Identification& id, const Diagnosis& diagnosis) {
  if (!diagnosis.HasCauses()) return "";
  std::string text = Tell("How far the plain model's values were off because this was missing:") +
                     MakeLinkTable(id, diagnosis).Format(kIndent);
  if (const std::string change = DescribeSharingChange(id, diagnosis.extended); !change.empty()) text += Tell(change);
  text += "\n";
  if (!diagnosis.extended.effects.empty()) text += MakeEffectTable(diagnosis.extended.effects).Format(kIndent);
  return text + "\n";
}

// ---------------------------------------------------------------- gain by amplitude

}  // namespace

TextTable MakeGainTable(const Identification& id, const Diagnosis& diagnosis) {
  std::vector<const RecordResult*> records;
  for (const std::size_t i : id.UsedIndices()) records.push_back(&id.records[i]);
  TextTable table;
  table.AddColumn("amplitude\n[mm]", Align::kLeft);
  table.AddColumn("samples");
  table.AddColumn("rms plain\n[mm]");
  table.AddColumn("extended\n[mm]");
  table.AddColumn("rms/noise\nplain");
  table.AddColumn("\nextended");
  for (const AmplitudeGain& range : CalcGainByAmplitude(records, diagnosis.plain, diagnosis.extended)) {
    if (range.samples == 0) continue;
    table.AddRow({fmt::format("{:.1f} to {:.1f}", 1e3 * range.high, 1e3 * range.low), fmt::format("{}", range.samples),
                  FormatMm(range.rms_before), FormatMm(range.rms_after), FormatRatio(range.rms_before / range.noise),
                  FormatRatio(range.rms_after / range.noise)});
  }
  return table;
}

namespace {

std::string FormatGain(const Identification& id, const Diagnosis& diagnosis) {
  if (!diagnosis.HasCauses()) return "";
  return Tell("What the extended model gains while the motion has some amplitude:") +
         MakeGainTable(id, diagnosis).Format(kIndent) + "\n";
}

// ---------------------------------------------------------------- symptoms

/// The residual's size and colour are the answer's rms; the others say where it comes from.
bool IsSizeOnly(const Symptom& symptom) {
  return symptom.id == "residual_over_noise" || symptom.id == "residual_not_white";
}

std::string DescribeSymptom(const Diagnosis& diagnosis, const Symptom& symptom) {
  std::string left;
  if (diagnosis.HasCauses()) {
    const std::vector<Symptom>& list = diagnosis.symptoms_left.list;
    const auto same = std::find_if(list.begin(), list.end(), [&](const Symptom& s) { return s.id == symptom.id; });
    left = same == list.end() ? ", gone with the causes" : fmt::format(", with the causes {:.1f}", same->z);
  }
  return fmt::format("{} (z = {:.{}f}{})", symptom.sentence, symptom.z, std::abs(symptom.z) < 100 ? 1 : 0, left);
}

}  // namespace

SymptomWords DescribeSymptoms(const Diagnosis& diagnosis, std::size_t most) {
  SymptomWords words;
  for (const Symptom& symptom : diagnosis.symptoms.list) {
    if (!symptom.IsSignificant() || IsSizeOnly(symptom)) continue;
    if (!symptom.of_model) {
      words.of_method.push_back("a bias of the method, which no model repairs: " + symptom.sentence);
    } else if (words.of_model.size() < most) {
      words.of_model.push_back(DescribeSymptom(diagnosis, symptom));
    } else {
      ++words.more;
    }
  }
  return words;
}

std::string DescribeMissingForce(const Diagnosis& diagnosis) {
  if (!diagnosis.missing_force) return "";
  const MissingForce& force = *diagnosis.missing_force;
  std::string text = "The force that the model lacks, read along the measured motion and divided by the load M g: it " +
                     force.words + ".";
  text += fmt::format(
      " By itself, a function of displacement explains {:.0f} % of what is beyond noise, one of velocity {:.0f} %, one "
      "of time {:.0f} % (they overlap).",
      100 * force.share_of_y, 100 * force.share_of_v, 100 * force.share_of_t);
  if (diagnosis.HasCauses()) text += " What the named causes do to the mass is in this force.";
  return text;
}

namespace {

std::string FormatSymptoms(const Diagnosis& diagnosis) {
  const SymptomWords words = DescribeSymptoms(diagnosis, kMostSymptoms);
  if (words.of_model.empty() && words.of_method.empty()) return "";
  std::string list;
  for (const std::string& sentence : words.of_model) list += Item(sentence);
  if (words.more > 0) list += Item(fmt::format("and {} more (result.json: diagnosis.symptoms)", words.more));
  for (const std::string& sentence : words.of_method) list += Item(sentence);
  const std::string head = words.of_model.empty()
                               ? "The plain model gets nothing wrong that an engineer would look for."
                               : fmt::format(
                                     "What the plain model gets wrong, surest first (z: difference over its "
                                     "standard error; chance seldom gives more than {:g}):",
                                     kSymptomThreshold);
  return Tell(head) + list + "\n";
}

std::string FormatMissingForce(const Diagnosis& diagnosis) {
  return diagnosis.missing_force ? Tell(DescribeMissingForce(diagnosis)) + "\n" : "";
}

// ---------------------------------------------------------------- candidates

std::string RoleOf(const Diagnosis& diagnosis, const Candidate& candidate) {
  for (const Cause& cause : diagnosis.causes) {
    if (cause.effect == candidate.effect) return "named";
    if (std::find(cause.rivals.begin(), cause.rivals.end(), candidate.effect) != cause.rivals.end()) return "rival";
  }
  return candidate.inadmissible.empty() ? "" : "impossible";
}

}  // namespace

std::string DescribeImpossible(const Diagnosis& diagnosis) {
  std::string list;
  for (const Candidate& candidate : diagnosis.candidates) {
    if (RoleOf(diagnosis, candidate) != "impossible") continue;
    list += fmt::format("{}{}: {}", list.empty() ? "" : "; ", candidate.effect->id, candidate.inadmissible);
  }
  return list.empty() ? "" : "Impossible: " + list + ".";
}

TextTable MakeCandidateTable(const Diagnosis& diagnosis) {
  TextTable table;
  table.AddColumn("effect", Align::kLeft);
  table.AddColumn("u");
  table.AddColumn("|cos|");
  table.AddColumn("most alike", Align::kLeft);
  table.AddColumn("rms/\nnoise");
  table.AddColumn("delta\nBIC");
  table.AddColumn("p");
  table.AddColumn("", Align::kLeft);
  for (const Candidate& c : diagnosis.candidates)
    table.AddRow({std::string(c.effect->id), fmt::format("{:.2f}", c.visibility), fmt::format("{:.3f}", c.collinearity),
                  c.most_alike == nullptr ? "" : std::string(c.most_alike->id),
                  c.refitted ? FormatRatio(c.rms_over_noise) : "-",
                  c.refitted ? fmt::format("{:.0f}", c.delta_bic) : "-", c.refitted ? FormatP(c.p_value) : "-",
                  RoleOf(diagnosis, c)});
  return table;
}

std::string DescribeCandidates() {
  return "Every effect of the catalogue, each added to the plain model by itself, best first. u: share of its "
         "trace in the readings that the other unknowns cannot imitate (0: invisible). |cos|: likeness of its "
         "trace to that of the effect most alike (1: the same). Delta BIC: misfit with a penalty for each unknown, "
         "below 0 it is worth it. p: probability of chance, over the whole catalogue. -: nothing to gain, not "
         "fitted.";
}

std::vector<std::string> DescribeUnseen() {
  std::vector<std::string> words;
  for (const Effect* effect : Effects())
    if (!effect->unseen.empty())
      words.push_back(
          fmt::format("Not to be seen in such records, and so never named: {}: {}.", NameOf(*effect), effect->unseen));
  return words;
}

namespace {

std::string FormatCandidates(const Diagnosis& diagnosis) {
  if (diagnosis.candidates.empty()) return "";
  const std::string impossible = DescribeImpossible(diagnosis);
  return Tell(DescribeCandidates()) + MakeCandidateTable(diagnosis).Format(kIndent) +
         (impossible.empty() ? "" : Tell(impossible)) + "\n";
}

std::string FormatUnseen() {
  std::string text;
  for (const std::string& words : DescribeUnseen()) text += Tell(words);
  return text;
}

}  // namespace

std::string Round(double value, double uncertainty) {
  if (!(uncertainty > 0) || !std::isfinite(uncertainty)) return fmt::format("{:.5g}", value);
  const int decimals = static_cast<int>(std::ceil(1 - std::log10(uncertainty)));
  return fmt::format("{:.{}f}", value, std::clamp(decimals, 0, 9));
}

std::string FormatDiagnosis(const Identification& identification, const Diagnosis& diagnosis) {
  if (identification.CountUsed() == 0) return "";
  std::string text = Tell(FormatAnswer(diagnosis)) + "\n";
  text += FormatCauses(diagnosis) + FormatMissingForce(diagnosis) + FormatParameters(identification, diagnosis) +
          FormatGain(identification, diagnosis) + FormatSymptoms(diagnosis) + FormatCandidates(diagnosis) +
          FormatUnseen();
  for (const std::string& notice : diagnosis.notices) text += Tell("Note: " + notice + ".");
  return text +
         Tell(fmt::format("Diagnosis: {} further model evaluations, {:.1f} s.", diagnosis.evaluations,
                          diagnosis.wall_s)) +
         "\n";
}

std::vector<std::string> FormatDiagnosisWarnings(const RunResult& run) {
  std::vector<std::string> lines;
  for (std::size_t d = 0; d < run.diagnoses.size(); ++d) {
    const Verdict verdict = run.diagnoses[d].verdict;
    const char* what = verdict == Verdict::kUnexplained       ? "nothing in the catalogue accounts for it"
                       : verdict == Verdict::kPartlyExplained ? "the named causes account for a part of it only"
                                                              : nullptr;
    if (what == nullptr) continue;
    lines.push_back(fmt::format(
        "{}: warning: the model leaves structure in the residuals, and {}; k, ki and T0i are not to be trusted as they "
        "stand",
        Name(run.directions[d].direction), what));
  }
  return lines;
}

}  // namespace uiclink
