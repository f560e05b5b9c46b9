#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/extended_fit.h"
#include "identify/statistics.h"
#include "identify/uncertainty.h"

namespace uiclink {

/// A parameter of an effect with its uncertainty, in its own unit.
struct EffectEstimate : Estimate {
  const Effect* effect = nullptr;
  std::string symbol;  ///< "A" for an amplitude that is fitted by its cosine and sine parts
  std::string unit;
  std::string meaning;
  bool at_bound = false;  ///< ended at a physical bound, so that the data do not want the effect as it is
};

/// What the residuals of a fit are like, all records together.
struct Structure {
  double rms = 0;             ///< [m]
  double noise = 0;           ///< noise floor [m]; estimated anew where a steady tone had counted as noise before
  double whiteness_p = 1;     ///< smallest of the records, corrected for their number
  double effective_size = 0;  ///< independent observations
  bool structured = false;    ///< the residuals are more than noise
  std::vector<double> rms_of_record, noise_of_record;  ///< [m]

  double RmsOverNoise() const { return rms / noise; }
};
Structure CalcStructure(std::span<const FitData> data, const Extension& extension, const ExtendedState& state);

/// An extended fit with everything that is said about it.
struct ExtendedResult {
  Extension extension;
  Sharing sharing = Sharing::kLink;
  double sharing_p = 1;  ///< of the test of one link for all records
  ExtendedOutcome outcome;
  Structure structure;
  double variance_factor = 1;        ///< by how much variances exceed those of white noise of the stated sigma
  Oscillator<double> link;           ///< shared link, or population mean
  std::vector<Estimate> quantities;  ///< by CountQuantities
  std::vector<EffectEstimate> effects;
};

/// Estimates and bounds of a fitted extended model. A link per record gives population means (statistics.h), to whose
/// error the common uncertainty of the effects is added.
ExtendedResult Describe(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                        const ExtendedOutcome& outcome);

}  // namespace uiclink
