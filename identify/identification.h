#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/record_fit.h"
#include "identify/statistics.h"

namespace uiclink {

struct IdentifyOptions {
  SineFitOptions sine;
  int sliders = 0;         ///< 0: one lateral, four longitudinal (the thesis); kAutoSliders: chosen from the data
  ScatteredStarts starts;  ///< of the check that a minimum is the lowest
  int threads = 0;         ///< 0: as many as the machine has
  std::function<void(const std::string& what, int done, int of)> progress;  ///< called from the calling thread only
};
inline constexpr int kAutoSliders = -1;

/// Is one link enough for all records?  Weighted distance of the records' own levels from their common value.
struct SharingTest {
  bool shared = true;
  double statistic = 0;  ///< sum over records of d' C^-1 d
  double dof = 0;
  double p_value = 1;
};

/// Mean and standard deviation of the frequency method over the records.
struct SineSummary {
  Population k, sum_ki, T0;                                ///< as published
  Population k_corrected, sum_ki_corrected, T0_corrected;  ///< centre free
  int records = 0;
};

/// How a number of sliders was chosen, or would have been.
struct SliderChoice {
  int sliders = 0;
  /// sum over records of n_eff log(mean square) + unknowns log(sum n_eff) (BIC), with n_eff independent observations
  /// instead of samples; smaller is better.
  double penalised = 0;
  double held_out_rms = 0;  ///< rms on records that the shape was not fitted to [m]; of their own fits for one slider
  bool chosen = false;
};

/// The answer for one direction.
struct Identification {
  Direction direction = Direction::kLateral;
  double g = kThesisGravity;
  std::vector<RecordResult> records;  ///< used and unused, in the order of the command line
  SineSummary sine;

  int sliders = 1;
  std::vector<SliderChoice> choices;  ///< with kAutoSliders
  SharingTest sharing;
  bool shared = true;
  Oscillator<double> link;           ///< shared link, or population mean; sliders ordered by critical displacement
  std::vector<Estimate> quantities;  ///< by CountQuantities
  std::vector<std::string> unidentifiable;
  Eigen::MatrixXd covariance;  ///< of (k, k1..kn, T01..T0n): of the shared values, or of the means
  double rms = 0;              ///< of all records [m]
  double noise = 0;            ///< rms of the records' noise levels [m]
  double whiteness_p = 1;      ///< smallest p-value of the records
  int evaluations = 0;
  double wall_s = 0;
  std::vector<std::string> warnings;  ///< results that should not be trusted as they stand, in words

  int CountUsed() const;
  std::vector<std::size_t> UsedIndices() const;
};

/// The samples of the used records, in their order; valid while the identification stays where it is.
std::vector<FitData> CollectData(const Identification& identification);
/// The final fit as a state: one link for all, or one per record (Sharing::kShape; with several sliders a shape, too).
FitState CollectState(const Identification& identification, Sharing sharing);

/// Fits records that PrepareRecord has seen: each alone, then all together, with result->sliders sliders.
void FitAll(const IdentifyOptions& options, Identification* result);

/// Identifies one direction from its records. Never throws for what is in the records; an unusable one says why and is
/// left out.  With no usable record the result has CountUsed() == 0 and nothing else.
Identification Identify(Direction direction, std::vector<Record> records, const IdentifyOptions& options = {});

}  // namespace uiclink
