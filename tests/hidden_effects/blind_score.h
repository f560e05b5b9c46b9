#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "tests/hidden_effects/blind_cases.h"

namespace uiclink {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A cause that `identify` named.
struct NamedCause {
  std::string effect;
  std::vector<std::string> rivals;
};

/// Which of k, k1, T01 lie inside the stated 95 % bounds.
struct Inside {
  /// Against the population means or, where the fit does not share the link, the mean of the records' own truths.
  std::array<bool, 3> records{};
  std::array<bool, 3> population{};  ///< against the population means in any case
};

/// What `identify --json` said of one case, beside the truth.
struct CaseResult {
  BlindCase blind;
  std::string fault;           ///< why nothing can be scored, e.g. that there is no diagnosis; empty when all is there
  double noise_factor = 1;     ///< noise as `identify` sees it over the true one
  double plain = kUnknown;     ///< rms over noise of the plain fit
  double extended = kUnknown;  ///< of the extended fit; the plain one's where nothing was named
  /// Best explanation by one effect that is not hidden in the case, the plain model included. In a pair no single
  /// effect is the truth, so all of them are wrong.
  std::string best_wrong_effect;
  double best_wrong = kUnknown;
  std::string verdict;
  std::vector<NamedCause> causes;
  bool shared = false;
  Inside plain_inside, extended_inside;
  double wall_s = 0;
  int exit_code = -1;

  bool IsSingle() const { return blind.kind == CaseKind::kSingle; }
  /// An alarm: a cause, or structure, where there is none.
  bool IsAlarm() const { return !causes.empty() || verdict != "adequate"; }
};

/// Wrong explanations leave at least this many noise levels: the case counts.
inline constexpr double kCounts = 3;
/// More rivals than this are no answer.
inline constexpr std::size_t kMostRivals = 2;

/// Reads what `identify` printed. Everything that is missing or malformed ends up in `fault`. Ratios are referred to
/// the noise that the rig made, not to what `identify` takes for it: a hum that passes for noise is still visible.
void ReadAnswer(const std::string& json, const WrittenCase& written, CaseResult* result);

bool Counts(const CaseResult& result);
/// The effect is the only cause named and has no rivals.
bool IsNamedAlone(const CaseResult& result);
/// The effect is the first cause or one of its rivals, and these are at most two.
bool IsNamedOrRival(const CaseResult& result);
/// The effect is one of the causes.
bool IsAmongCauses(const CaseResult& result, std::string_view effect);
/// The effect is one of the causes or a rival of one that has at most two.
bool IsFound(const CaseResult& result, std::string_view effect);

/// Counted things and how many of them were right.
struct Share {
  int right = 0, all = 0;
  void Add(bool is_right) { right += is_right ? 1 : 0, ++all; }
  double Percent() const { return all == 0 ? 0 : 100.0 * right / all; }
};

/// The figures of a study.
struct Summary {
  Share alone, named_or_rival;      ///< counted single effects
  Share first;                      ///< the same: first cause, whatever else is said
  Share false_alarms, false_names;  ///< clean cases: any alarm; a cause named
  Share decoy_alarms;
  Share pairs_found, pairs_named;  ///< counted pairs: both, rivals allowed; both as causes
  Share all_pairs_found;
  Share outside_adequate, outside_explained;  ///< counted out-of-catalogue cases
  Share all_outside_adequate, all_outside_explained;
  Share unobservable_named;                            ///< any case: friction asymmetry among the causes
  std::array<Share, 3> plain_inside, extended_inside;  ///< counted single effects; k, k1, T01
  std::array<Share, 3> plain_inside_population, extended_inside_population;
  Share plain_all_inside, extended_all_inside;  ///< all three at once
  int faults = 0;
};
Summary Summarise(const std::vector<CaseResult>& results);

/// One row of the list of cases, and its heading.
std::string FormatHeading();
std::string FormatRow(const CaseResult& result);

/// The figures, confusion matrices by size, and the sizes drawn, as Markdown, which is also what is printed.
std::string FormatStudy(const std::vector<CaseResult>& results);

}  // namespace uiclink
