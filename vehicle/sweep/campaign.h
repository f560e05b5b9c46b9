#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle/sweep/counter_random.h"
#include "vehicle/sweep/run_kind.h"
#include "vehicle/sweep/sweep_axis.h"

namespace uiclink {

/// Where the values of a sampled axis come from.
struct Distribution {
  enum class Law { kUniform, kNormal, kLogNormal, kChoice };
  Law law = Law::kUniform;
  double a = 0, b = 0;             ///< bounds (uniform); mean and standard deviation of the value (both normal laws)
  double low = 0, high = 0;        ///< values outside are drawn anew: [sample] low, high and what the axis allows
  std::vector<AxisValue> choices;  ///< kChoice, all equally likely

  /// The value of a sample. @throws std::runtime_error if none of a thousand draws lies within the bounds.
  AxisValue Draw(CounterRandom random) const;
};

/// A campaign, data/campaigns/*.toml; the format is in data/campaigns/README.md.
struct Campaign {
  std::string name;
  std::string text;              ///< the file
  std::filesystem::path folder;  ///< of the file: what paths in it are relative to
  std::uint64_t seed = 0;
  std::vector<std::optional<AxisValue>> base;  ///< by index of the axis; with the axes' own values where none is given
  std::vector<bool> said;                      ///< ... whether the campaign has it in [base]

  struct Grid {
    std::size_t axis;
    std::vector<AxisValue> values;
  };
  std::vector<Grid> grid;  ///< in the order of SweepAxes()
  struct Sampled {
    std::size_t axis;
    Distribution distribution;
  };
  std::vector<Sampled> sampled;  ///< in the order of SweepAxes()
  std::uint32_t samples = 0;     ///< of every point of the grid; 0: the campaign draws nothing
  bool own_draws = false;        ///< every point of the grid draws its own samples; else all points have the same ones
  std::shared_ptr<const RunKind> kind;
};

inline constexpr double kMostRuns = 1e6;  ///< of a campaign

/// @throws InputError with all faults of the file.
Campaign ReadCampaign(const std::filesystem::path& path);
/// @param text the whole file at `path`, read already.
Campaign ParseCampaign(std::string_view text, const std::filesystem::path& path);

}  // namespace uiclink
