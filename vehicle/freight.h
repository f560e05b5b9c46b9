#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle/wagon_data.h"

namespace uiclink {

/// Freight that fills a box evenly.
struct FreightBox {
  std::string name;
  double mass = 0;    ///< [kg]
  double length = 0;  ///< along the wagon [m]; with width and height 0 it is a point
  double width = 0;   ///< [m]
  double height = 0;  ///< [m]
  double x = 0;       ///< its middle ahead of the middle of the floor [m]
  double y = 0;       ///< its middle left of the middle of the floor [m]
  double z = 0;       ///< its bottom above the floor [m]
};

/// Freight spread over the whole floor; its height is mass / (density x floor).
struct EvenFreight {
  double mass = 0;     ///< [kg]
  double density = 0;  ///< [kg/m^3]
};

/// What lies in the wagon: data/freight/*.toml.
struct Freight {
  std::string name;
  std::string source;
  std::optional<EvenFreight> even;
  std::vector<FreightBox> boxes;
};

/// Reads data/freight/NAME.toml or a file of the user's; the format is in data/freight/README.md.
/// @throws InputError with all faults of the file, each with its line.
Freight ReadFreight(const std::filesystem::path& path);
/// @param text the whole file. @param file its name for messages.
Freight ParseFreight(std::string_view text, const std::string& file);

/// All freight as boxes in this wagon: the even one first, as a box as long and wide as the floor.
std::vector<FreightBox> PlaceFreight(const Freight& freight, const CargoSpace& cargo);

/// What stands out of the cargo space, a sentence each; empty when everything fits. A millimetre does not count: a
/// density with four digits leaves 0.6 mm of a full wagon open (packed: 2.35006 m under walls of 2.350 m).
std::vector<std::string> CheckFreight(const Freight& freight, const CargoSpace& cargo);

}  // namespace uiclink
