// The figures of a blind study: shares, confusion matrices, sizes.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tests/hidden_effects/blind_score.h"

namespace uiclink {
namespace {

void AddInside(const std::array<bool, 3>& inside, std::array<Share, 3>* shares) {
  for (std::size_t i = 0; i < 3; ++i) (*shares)[i].Add(inside[i]);
}

bool All(const std::array<bool, 3>& inside) { return inside[0] && inside[1] && inside[2]; }

void AddSingle(const CaseResult& r, Summary* s) {
  if (!Counts(r)) return;
  s->alone.Add(IsNamedAlone(r));
  s->named_or_rival.Add(IsNamedOrRival(r));
  s->first.Add(!r.causes.empty() && r.causes[0].effect == r.blind.effects.at(0));
  AddInside(r.plain_inside.records, &s->plain_inside);
  AddInside(r.extended_inside.records, &s->extended_inside);
  AddInside(r.plain_inside.population, &s->plain_inside_population);
  AddInside(r.extended_inside.population, &s->extended_inside_population);
  s->plain_all_inside.Add(All(r.plain_inside.records));
  s->extended_all_inside.Add(All(r.extended_inside.records));
}

void AddPair(const CaseResult& r, Summary* s) {
  const auto both = [&](auto is_there) {
    return is_there(r, r.blind.effects.at(0)) && is_there(r, r.blind.effects.at(1));
  };
  s->all_pairs_found.Add(both(IsFound));
  if (!Counts(r)) return;
  s->pairs_found.Add(both(IsFound));
  s->pairs_named.Add(both(IsAmongCauses));
}

void AddOutside(const CaseResult& r, Summary* s) {
  s->all_outside_adequate.Add(r.verdict == "adequate");
  s->all_outside_explained.Add(r.verdict == "explained");
  if (!Counts(r)) return;
  s->outside_adequate.Add(r.verdict == "adequate");
  s->outside_explained.Add(r.verdict == "explained");
}

std::string FormatShare(const char* what, const Share& share) {
  return fmt::format("| {} | {:.1f} % | {} of {} |\n", what, share.Percent(), share.right, share.all);
}

std::string FormatInside(const char* what, const std::array<Share, 3>& shares) {
  const char* names[] = {"k", "k1", "T01"};
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) text += FormatShare(fmt::format("{}: {}", what, names[i]).c_str(), shares[i]);
  return text;
}

std::string FormatSummary(const Summary& s) {
  std::string text = "| figure | share | count |\n| --- | --- | --- |\n";
  text += FormatShare("single effects (best wrong >= 3 noise levels): named, alone", s.alone);
  text += FormatShare("the same: named first, whatever else is said", s.first);
  text += FormatShare("the same: named first or among at most two rivals", s.named_or_rival);
  text += FormatShare("clean cases: false alarms", s.false_alarms);
  text += FormatShare("clean cases: a cause named", s.false_names);
  text += FormatShare("decoys: false alarms", s.decoy_alarms);
  text += FormatShare("pairs (best single effect >= 3 noise levels): both found, at most two rivals", s.pairs_found);
  text += FormatShare("the same: both named", s.pairs_named);
  text += FormatShare("all pairs: both found, at most two rivals", s.all_pairs_found);
  text += FormatShare("out of catalogue (best effect >= 3 noise levels): called adequate", s.outside_adequate);
  text += FormatShare("the same: called explained", s.outside_explained);
  text += FormatShare("all out of catalogue: called adequate", s.all_outside_adequate);
  text += FormatShare("all out of catalogue: called explained", s.all_outside_explained);
  text += FormatShare("any case: friction asymmetry named", s.unobservable_named);
  text += FormatInside("counted single effects, plain fit, inside 95 % bounds", s.plain_inside);
  text += FormatInside("extended fit, inside 95 % bounds", s.extended_inside);
  text += FormatShare("plain fit, all three inside", s.plain_all_inside);
  text += FormatShare("extended fit, all three inside", s.extended_all_inside);
  text += FormatInside("plain fit, population means inside", s.plain_inside_population);
  text += FormatInside("extended fit, population means inside", s.extended_inside_population);
  return text + fmt::format("\nCases that could not be scored: {}\n", s.faults);
}

/// Truth down, first cause across. Columns: only what occurs, so that the table stays readable.
std::string FormatMatrix(const std::vector<const CaseResult*>& cases) {
  std::map<std::string, std::map<std::string, int>> count;
  std::map<std::string, int> answers;
  for (const CaseResult* r : cases) {
    const std::string answer = r->causes.empty() ? "(" + r->verdict + ")" : r->causes[0].effect;
    ++count[r->blind.effects.at(0)][answer];
    ++answers[answer];
  }
  std::string text = "| hidden \\ named first |", line = "| --- |";
  for (const auto& [answer, total] : answers) text += " " + answer + " |", line += " ---: |";
  text += "\n" + line + "\n";
  for (const auto& [truth, row] : count) {
    text += "| " + truth + " |";
    for (const auto& [answer, total] : answers) {
      const auto found = row.find(answer);
      const std::string number = found == row.end() ? "" : std::to_string(found->second);
      text += answer == truth && !number.empty() ? " **" + number + "** |" : " " + number + " |";
    }
    text += "\n";
  }
  return text;
}

/// One matrix for single and out-of-catalogue cases whose best wrong explanation lies in low..high.
std::string FormatMatrix(const std::string& title, const std::vector<CaseResult>& results, double low, double high) {
  std::vector<const CaseResult*> cases;
  for (const CaseResult& r : results) {
    const bool one_effect = r.IsSingle() || r.blind.kind == CaseKind::kOutside;
    if (one_effect && r.fault.empty() && r.best_wrong >= low && r.best_wrong < high) cases.push_back(&r);
  }
  return fmt::format("\n### {} ({} cases)\n\n{}", title, cases.size(), cases.empty() ? "none\n" : FormatMatrix(cases));
}

/// Nearest-rank quantile of sorted values.
double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

/// How visible the drawn sizes are: rms over noise of the plain fit, for each effect.
std::string FormatSizes(const std::vector<CaseResult>& results) {
  std::map<std::string, std::vector<double>> ratios;
  for (const CaseResult& r : results) {
    if (!std::isfinite(r.plain)) continue;
    const bool by_effect = r.IsSingle() || r.blind.kind == CaseKind::kOutside;
    ratios[by_effect ? r.blind.effects.at(0) : "(" + std::string(Name(r.blind.kind)) + ")"].push_back(r.plain);
  }
  std::string text =
      "\n### Sizes: rms of the plain fit over the noise\n\n"
      "| hidden | cases | least | 10 % | 50 % | 90 % | most | below 1.5 | 3 and more |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
  for (auto& [name, values] : ratios) {
    std::sort(values.begin(), values.end());
    text += fmt::format("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {} | {} |\n", name, values.size(),
                        values.front(), Quantile(values, 0.1), Quantile(values, 0.5), Quantile(values, 0.9),
                        values.back(), std::count_if(values.begin(), values.end(), [](double v) { return v < 1.5; }),
                        std::count_if(values.begin(), values.end(), [](double v) { return v >= kCounts; }));
  }
  return text;
}

}  // namespace

Summary Summarise(const std::vector<CaseResult>& results) {
  Summary s;
  for (const CaseResult& r : results) {
    if (!r.fault.empty()) {
      ++s.faults;
      continue;
    }
    s.unobservable_named.Add(IsAmongCauses(r, kUnobservable));
    switch (r.blind.kind) {
      case CaseKind::kSingle:
        AddSingle(r, &s);
        break;
      case CaseKind::kClean:
        s.false_alarms.Add(r.IsAlarm());
        s.false_names.Add(!r.causes.empty());
        break;
      case CaseKind::kDecoy:
        s.decoy_alarms.Add(r.IsAlarm());
        break;
      case CaseKind::kPair:
        AddPair(r, &s);
        break;
      case CaseKind::kOutside:
        AddOutside(r, &s);
        break;
    }
  }
  return s;
}

std::string FormatStudy(const std::vector<CaseResult>& results) {
  std::string text = fmt::format("## Blind study: {} cases of {} records\n\n", results.size(), kBlindRecords);
  text += FormatSummary(Summarise(results));
  constexpr double kNone = std::numeric_limits<double>::infinity();
  text += FormatMatrix("Best wrong explanation leaves 3 noise levels or more", results, kCounts, kNone);
  text += FormatMatrix("1.5 to 3 noise levels", results, 1.5, kCounts);
  text += FormatMatrix("Below 1.5 noise levels", results, 0, 1.5);
  return text + FormatSizes(results);
}

}  // namespace uiclink
