#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/effect_search.h"
#include "identify/extended_result.h"
#include "identify/held_out.h"
#include "identify/identification.h"
#include "identify/missing_force.h"
#include "identify/symptoms.h"

namespace uiclink {

/// DESIGN 4.1.
enum class Verdict {
  kAdequate,         ///< no structure is left in the residual of the plain model
  kExplained,        ///< none is left after the named causes
  kPartlyExplained,  ///< causes are significant, structure remains
  kUnexplained,      ///< structure, and nothing in the catalogue accounts for it
};
const char* Name(Verdict verdict);

/// One effect tried on the plain model by itself.
struct Candidate {
  const Effect* effect = nullptr;
  double score = 0;         ///< fall of the sum of squares that the linear screen promised
  double visibility = 0;    ///< u, 0..1
  double collinearity = 0;  ///< |cos| with the effect that is most alike
  const Effect* most_alike = nullptr;
  bool refitted = false;
  double statistic = 0;  ///< n_eff log(mean square without / with)
  int unknowns = 0;
  double p_value = 1;         ///< family-wise, over the whole catalogue
  double delta_bic = 0;       ///< with library-size term; negative: better than the plain model
  double rms_over_noise = 0;  ///< of the refit
  std::vector<EffectEstimate> parameters = {};
  std::string inadmissible = {};  ///< why it cannot be a cause by itself; empty when it can
};

/// A named effect, with what speaks for it.
struct Cause {
  const Effect* effect = nullptr;
  std::vector<EffectEstimate> parameters = {};
  double p_value = 1;                    ///< family-wise
  double delta_bic = 0;                  ///< of the final model against the final model without it
  double rms_before = 0, rms_after = 0;  ///< of the fit without and with it [m]
  HeldOut held_out = {};
  std::vector<const Effect*> rivals = {};  ///< effects that do as well in its place

  /// Symptoms of Effect::repairs: how many were significant in the plain fit, and which of these (by id) are at most
  /// half as significant in the extended one.
  int repairable = 0;
  std::vector<std::string> repaired = {};
};

/// What the plain model lacks, for the records of one direction.
struct Diagnosis {
  Verdict verdict = Verdict::kAdequate;
  std::vector<Candidate> candidates;  ///< by what they explain, best first
  std::vector<Cause> causes;          ///< in the order in which they were found
  ExtendedResult plain;               ///< the plain model as the extended ones are judged
  ExtendedResult extended;            ///< with the named causes; the plain one where there are none
  Symptoms symptoms;                  ///< of the plain fit
  Symptoms symptoms_left;             ///< of the extended fit; empty without causes
  /// Where structure is left: along the plain link, or where causes are named along that of the extended fit. What the
  /// named causes do to the reading is taken away, what they do to the mass is in it.
  std::optional<MissingForce> missing_force;
  std::vector<std::string> notices;  ///< in words, for the report
  int evaluations = 0;
  double wall_s = 0;

  bool HasCauses() const { return !causes.empty(); }
};

struct DiagnoseOptions {
  int threads = 0;
  std::function<void(const std::string& what, int done, int of)> progress;
};

/// Tests every effect of the catalogue as what the plain model lacks, extends the model by what is significant and
/// predicts better, until nothing is left or nothing helps.  Never throws for what is in the records.
///
/// 1. The plain model is fitted with a link per record unless the records share one, so that scatter between records
/// can
///    neither pass for an effect nor hide one.
/// 2. Each effect: linear screen, then full refits (effect_search.h).
/// 3. The effect with the best penalised likelihood is taken, n_eff log(mean square) + unknowns log(n_eff) + 2
///    log(number of effects); with it in the model step 2 is repeated, up to three effects.
/// 4. Effects that the final model can do without are dropped again.
/// 5. A cause is named when it is significant over the whole catalogue, improves the prediction of records that were
///    not fitted, is inside its physical bounds, and puts read-outs right that it should (diagnose_symptoms.h). Effects
///    that do as well in its place are its rivals.
Diagnosis Diagnose(const Identification& plain, const DiagnoseOptions& options = {});

/// How much the plain fit was off because the causes were missing: plain less extended value of a quantity, and the
/// same in standard deviations of the plain fit.
struct ParameterShift {
  std::string symbol;
  double shift = 0;
  double in_std = 0;
};
std::vector<ParameterShift> CalcParameterShifts(const Identification& plain, const Diagnosis& diagnosis);

}  // namespace uiclink
