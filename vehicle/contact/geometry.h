#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "vehicle/contact/profile_file.h"

namespace uiclink {

/// How wheel and rail touch.
enum class ContactModel {
  kRigid,    ///< where rigid profiles touch; the contact point jumps between local minima of the gap
  kElastic,  ///< virtual penetration (Kik and Piotrowski): the interpenetration under the static load decides
};

/// Wheels on rails, as named in data/geometry/*.toml. SI units.
struct TrackGeometry {
  std::string name;
  std::string source;
  double gauge = 0;         ///< distance of the rails' inner faces [m] ...
  double gauge_depth = 0;   ///< ... this far below their highest points [m]
  double cant = 0;          ///< inclination of the rails towards the centre, tangent [-]
  double rail_offset = 0;   ///< each rail further outward by this [m]
  double back_to_back = 0;  ///< distance of the wheels' inner faces [m]
  double tape_circle = 0;   ///< of the tape circle from the wheel's inner face [m]
  double r0 = 0;            ///< nominal rolling radius [m]
  std::string wheel;        ///< "S1002" or the path of a file of points
  std::string rail;         ///< "UIC60", "60E1" or the path of a file of points
  ProfileAxes wheel_axes;   ///< how the axes of a file of points run
  ProfileAxes rail_axes;
  double profile_smoothing = 0;  ///< of files of points: standard deviation of their heights [m]; 0 interpolates
  ContactModel contact = ContactModel::kRigid;
  double wheel_load = 0;  ///< vertical load of a wheel that the table is made for [N]
  double young = 0;       ///< E [N/m^2]
  double poisson = 0;     ///< nu [-]
  double y_max = 0;       ///< the table reaches from -y_max to y_max [m]
  int rows = 0;           ///< number of rows without those that a jump adds

  double shear_modulus() const { return young / (2 * (1 + poisson)); }
};

/// Reads data/geometry/NAME.toml; profiles that are files of points stand beside it.
/// @throws InputError with all faults of the file.
TrackGeometry ReadTrackGeometry(const std::filesystem::path& path);
/// @param text the whole file at `path`, read already.
TrackGeometry ParseTrackGeometry(std::string_view text, const std::filesystem::path& path);

}  // namespace uiclink
