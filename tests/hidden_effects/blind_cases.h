#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "measurements/rig/rig.h"

namespace uiclink {

/// What a blind case is there to show.
enum class CaseKind {
  kSingle,   ///< one effect of the catalogue that a record can show
  kClean,    ///< nothing: one link, a scattered one, or asymmetric friction (a constant force, which nobody can see)
  kDecoy,    ///< nothing either, but unusual records: noise, converter, start forces, zeros, rate, scatter
  kPair,     ///< two effects of the catalogue
  kOutside,  ///< an effect that the catalogue does not have
};
inline constexpr CaseKind kCaseKinds[] = {CaseKind::kSingle, CaseKind::kClean, CaseKind::kDecoy, CaseKind::kPair,
                                          CaseKind::kOutside};
std::string_view Name(CaseKind kind);

/// Numbers of a kind's cases start at kCasesPerKind times its place in kCaseKinds: 0 single, 10000 clean, ...
inline constexpr int kCasesPerKind = 10000;

/// Friction asymmetry is exactly a constant force (DESIGN, section 2): it may act, and must never be named.
inline constexpr std::string_view kUnobservable = "asymmetric_friction";

inline constexpr int kBlindRecords = 3;

/// One case: three lateral records of one drawn link, with what was hidden in them.
struct BlindCase {
  int number = 0;
  CaseKind kind = CaseKind::kSingle;
  std::string variant;               ///< which clean case, decoy; empty for the others
  std::vector<std::string> effects;  ///< hidden on purpose; empty for clean cases and decoys
  std::vector<std::string> sizes;    ///< of each effect, all parameters, for people
  bool scattered = false;            ///< the records do not share their link
  double swing = 0;                  ///< largest first extremum of the records [m]
  /// One for each record: they differ in the first extremum only.
  std::vector<rig::Settings> settings;
};

/// Draws a case.  k is log-uniform in 2.5..6 1/m, k1/k log-uniform in 0.3..4, T0 log-uniform in 0.005..0.025 under the
/// condition that T0/k1 is in 1..8 mm; first extrema are uniform from 14 mm (or 2.5 T0/k1, if that is more) to 30 mm.
/// Everything follows from `study_seed` and `number`: any case can be made again alone.
/// @throws std::invalid_argument when the number belongs to no kind.
BlindCase DrawBlindCase(std::uint64_t study_seed, int number);

/// The catalogue's effects that a record can show, in its order.
std::vector<const rig::Effect*> ObservableEffects();

/// Population means or, as `identify` may see it, the mean of what the records themselves were made with.
struct LinkTruth {
  double k = 0, k1 = 0, T01 = 0;
};

/// Records on disk, and what their links were.
struct WrittenCase {
  std::vector<std::string> files;  ///< record_1.txt, ..., names within the folder
  LinkTruth population, records_mean;
  double noise_mm = 0;  ///< white noise and the converter's steps together
};

/// Makes the records and writes them to `folder` under names that tell nothing.
/// @throws std::runtime_error when a file cannot be written, std::invalid_argument from the rig.
WrittenCase WriteBlindCase(const BlindCase& blind, const std::filesystem::path& folder);

}  // namespace uiclink
