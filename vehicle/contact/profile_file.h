#pragma once

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "vehicle/contact/profile.h"

namespace uiclink {

enum class ProfileKind { kWheel, kRail };

/// How the axes of a file of points run.
struct ProfileAxes {
  enum class Lateral {
    kDetect,  ///< wheels: from the side of the flange; rails: as kField, since an upright head looks the same both ways
    kField,   ///< y grows to the field side
    kGauge,   ///< y grows to the flange, or to the gauge face
  };
  enum class Vertical {
    kDetect,  ///< wheels: the flange hangs down; rails: the ends hang down
    kUp,
    kDown,
  };
  Lateral lateral = Lateral::kDetect;
  Vertical vertical = Vertical::kDetect;
};

/// Points of a cross-section in the axes of Profile [m], by increasing y.
using ProfilePoints = std::vector<std::pair<double, double>>;

/// Reads a file of points [mm]: two columns y and z, separated by blanks, tabs, commas or semicolons (a third column, a
/// weight, is ignored); lines that begin with #, ! or % and text after them are comments; or a SIMPACK file (.prw,
/// .prr), known by its "spline.begin", whose units.len.f (length unit per metre) is honoured and whose points stand
/// between point.begin and point.end. Points may run either way; equal neighbours are dropped; where the curve
/// overhangs (flange back, undercut), that end is left out.
/// @throws InputError with file and line: not a number, a column missing, fewer than 10 points, no steady direction,
///         a SIMPACK file whose shift or rotation is not zero or whose type is not `kind`.
ProfilePoints ReadProfilePoints(const std::filesystem::path& path, ProfileKind kind, const ProfileAxes& axes = {});
ProfilePoints ParseProfilePoints(std::string_view text, const std::string& file, ProfileKind kind,
                                 const ProfileAxes& axes = {});

/// A curve with continuous curvature through points: the natural cubic smoothing spline y(t), z(t) over the length of
/// the polygon, as z(y).  Smallest  integral (y''^2 + z''^2) dt  such that the mean square distance of the points is
/// sigma^2 (Reinsch 1967).
/// @param sigma standard deviation of the points [m], >= 0; 0 passes through them.
/// @throws std::invalid_argument for less than four points, or where no part of the curve is less steep than 20.
Profile FitProfile(std::string name, const ProfilePoints& points, double sigma);

/// Reads and fits. A wheel is shifted so that z = 0 at the tape circle, where its radius is r0.
/// @throws InputError.
Profile ReadProfile(const std::filesystem::path& path, ProfileKind kind, double sigma, const ProfileAxes& axes = {});

}  // namespace uiclink
