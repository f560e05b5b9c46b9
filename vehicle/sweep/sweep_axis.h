#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "data/table.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// What one run of a campaign stands on, resolved: SI units.
struct RunSetup {
  WagonChoice choice;

  // Instead of what the geometry's file says.
  std::string wheel_profile, rail_profile;  ///< empty: as in the file
  std::optional<double> gauge, back_to_back, rail_offset, cant, wheel_load;
  // Instead of what the wagon's file says: guidance of all axle boxes.
  std::optional<double> lateral_clearance, longitudinal_clearance, lateral_stiffness, longitudinal_stiffness;

  bool draw_sets = false;     ///< the values of each set, from its covariance
  bool draw_corners = false;  ///< factors of each corner's parameters, by the spread between links that its set has
  double scatter = 0;         ///< coefficient of variation of every parameter of every link, corner by corner [-]
  double speed = 0;           ///< [m/s]
  std::string start;          ///< ParsePerturbation, or "equilibrium"
  Perturbation by;            ///< added to it

  std::uint64_t seed = 0;    ///< of what is drawn within the run (its links), with the sample
  std::uint32_t sample = 0;  ///< 0, 1, ...

  bool DrawsLinks() const { return draw_sets || draw_corners || scatter > 0; }
};

/// A number, or text. Numbers are in the unit of their axis.
using AxisValue = std::variant<double, std::string>;

/// The value as it stands in identities and messages; numbers read back bit by bit.
std::string FormatValue(const AxisValue& value);

/// Something that a campaign may fix, spread over a grid, or draw.
struct SweepAxis {
  std::string name;                        ///< key in the campaign's file, column in the store
  std::optional<Range> range;              ///< of a number; none: the axis has texts
  std::vector<std::string> words = {};     ///< the texts that there are; empty: any (names of files)
  std::optional<AxisValue> fallback = {};  ///< where the campaign says nothing; none: as in the files
  std::function<void(const AxisValue&, RunSetup*)> apply;
  bool is_motion = false;  ///< speed and start: the wagon stays the same
  bool is_start = false;   ///< counts for kinds of runs that start somewhere

  bool IsNumber() const { return range.has_value(); }
};

/// All of them. What is costly to change stands first: in a campaign the last one that varies changes from run to run.
const std::vector<SweepAxis>& SweepAxes();
std::optional<std::size_t> FindAxis(const std::string& name);

}  // namespace uiclink
