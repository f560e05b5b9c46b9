#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/commands.h"
#include "vehicle/hunting/propagation.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/report_json.h"

namespace uiclink {

/// What commands have in common that tell how uncertain their results are.
struct BoundsArguments {
  std::size_t draws = 0;
  std::uint64_t seed = 1;
  double corner_scatter = 0;       ///< [%]
  bool corners_as_in_set = false;  ///< instead: what the sets say of the spread between links
  std::optional<double> coverage;  ///< half of a 95 % interval in standard deviations; none: as the sets say
  bool asked = false;              ///< --draws or --corner-scatter was given: then there has to be something to draw
};

/// --draws, --corner-scatter, --coverage, --seed. @param draws  the default of --draws.
void AddBoundsOptions(CLI::App* app, BoundsArguments* arguments, std::size_t draws);

/// The draws for a wagon; none where nothing was asked for, or no set has a covariance and corners do not differ.
/// @throws InputError where draws were asked for, but there is nothing to draw from, or a covariance is none.
std::optional<SetScatter> MakeScatter(const BoundsArguments& arguments, const WagonInputs& inputs);

/// Options of the propagation that show their progress.
PropagateOptions MakePropagateOptions(const Progress& progress, const std::string& what);

/// A result's JSON text with a further key. Keys that exist stay as they are.
std::string WithKey(const std::string& json, const std::string& key, const Json& value);
/// { "low", "high", "shares" } beside the "value" under `key`, if that is an object.
std::string WithLowAndHigh(const std::string& json, const std::string& key, const ScalarBounds& bounds);

/// The same as a page takes it. A view.
PageBounds MakePageBounds(const std::optional<SetScatter>& scatter, const std::vector<ScalarBounds>& all);

/// bounds.svg, bounds_draws.csv.
void WriteBounds(const std::string& title, const SetScatter& scatter, const std::vector<ScalarBounds>& all,
                 FigureWriter* files);

}  // namespace uiclink
