#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace uiclink {

/// One wheelset (table 2.1): mass [kg] and moments of inertia about its own axes [kg m^2]; roll x, pitch y, yaw z.
struct WheelsetInertia {
  double m = 0;
  double I_x = 0;
  double I_y = 0;
  double I_z = 0;
};

/// Car body with its freight, as one rigid body that sways, bounces, rolls and yaws.
struct BodyInertia {
  double m = 0;     ///< [kg]
  double I_x = 0;   ///< roll, about the longitudinal line through the centre of mass [kg m^2]
  double I_z = 0;   ///< yaw, about the vertical line through the centre of mass [kg m^2]
  double h = 0;     ///< height of the centre of mass above the underframe, where links and guidance act [m]
  double x = 0;     ///< centre of mass ahead of the middle of the wagon [m]
  double y = 0;     ///< centre of mass left of the middle of the wagon [m]
  double I_xz = 0;  ///< product of inertia, integral of x z dm about the centre of mass [kg m^2]; it couples roll with
                    ///< yaw, vanishes for an even freight, and the equations of motion leave it out
};

/// How the mass of a part is spread over its cross-section, in the plane of y (left) and z (up from the underframe).
enum class SectionKind {
  kPoint,  ///< all in one point
  kLine,   ///< evenly along a polyline: thin walls, roofs, columns
  kArea,   ///< evenly over a polygon: walls across the wagon
};

/// A part of the empty car body: a cross-section drawn out along the wagon by `length`, once for each place in `at`.
struct WagonPart {
  std::string name;
  double mass = 0;  ///< of one of them [kg]
  SectionKind kind = SectionKind::kPoint;
  std::vector<std::array<double, 2>> section = {};    ///< corners (y, z) [m]
  double length = 0;                                  ///< along the wagon, 0 for a thin one [m]
  std::vector<std::array<double, 2>> at = {};         ///< places (x, y) that its section is moved to [m], one for each
  std::vector<std::array<double, 2>> at_spread = {};  ///< places when spread evenly along the wagon; empty: as `at`
  /// What the printed calculation (appendix G) took instead: the mass of one of them in the centre of mass [kg], and
  /// how often it counted each piece of a polyline in the yaw inertia.
  std::optional<double> printed_com_mass = std::nullopt;
  std::vector<double> printed_yaw_weights = {};
};

/// The room for freight: a floor with side walls, and a roof that rises over slopes to a flat middle.
struct CargoSpace {
  double floor = 0;         ///< height of the floor above the underframe [m]
  double length = 0;        ///< [m]
  double width = 0;         ///< [m]
  double height = 0;        ///< of the side walls above the floor [m]
  double ridge_height = 0;  ///< of the roof's flat middle above the floor [m]
  double ridge_width = 0;   ///< of the flat middle [m]
};

/// Guidance of an axle box (chapter 6): a linear spring beyond a clearance.
struct GuidanceStop {
  double clearance = 0;  ///< free travel to each side, relative to the body [m]
  double k = 0;          ///< stiffness of one axle box beyond it [N/m]
};
struct Guidance {
  GuidanceStop longitudinal;
  GuidanceStop lateral;  ///< both boxes of a wheelset touch together: 2k in all
};

/// Parabolic spring (equation (5.1)): F = k1 s + d s' up to s0, beyond it F = F0 + k2 (s - s0) + d s', F0 = k1 s0 so
/// that the force is continuous.
struct ParabolicSpring {
  double F0 = 0;          ///< force at which the supplementary leaf engages [N]
  double s0 = 0;          ///< compression there [m]
  double k2 = 0;          ///< stiffness beyond [N/m]
  double d_unloaded = 0;  ///< damping, empty wagon [N s/m]
  double d_loaded = 0;    ///< damping, loaded wagon [N s/m]

  double k1() const { return F0 / s0; }  ///< stiffness below [N/m]
};

/// Linear spring and damper, vertical: F = k s + d s'.
struct LinearSpring {
  double k = 0;  ///< [N/m]
  double d = 0;  ///< [N s/m]
};

/// Fancher's leaf spring (section 5.1), F > 0 in compression:  F' = (F_env - F) |s'| / beta,
///   F_env = c (1 + mu0) s + F_r while loading (s' > 0),  c (1 - mu0) s - F_r while unloading.
struct LeafSpring {
  double c = 0;     ///< mean stiffness [N/m]
  double mu0 = 0;   ///< relative difference of the envelopes' slopes [-]
  double F_r = 0;   ///< half the distance of the envelopes at s = 0 [N]
  double beta = 0;  ///< displacement over which the force goes over to the envelope [m]
};

/// What a wagon is made of, without its freight, its links and its wheel-rail contact. data/wagons/*.toml.
struct WagonData {
  std::string name;
  std::string source;
  double g = 0;  ///< [m/s^2]
  double b = 0;  ///< lateral half distance of links, springs and guidance [m]
  double l = 0;  ///< half the wheelbase [m]
  WheelsetInertia wheelset;
  Guidance guidance;
  LinearSpring linear_vertical;  ///< --suspension linear
  ParabolicSpring parabolic;     ///< --suspension parabolic
  LeafSpring leaf;               ///< --suspension leaf
  std::vector<WagonPart> parts;  ///< of the empty car body (table 7.1, appendix G)
  CargoSpace cargo;
};

/// Reads data/wagons/NAME.toml; the format is in data/wagons/README.md.
/// @throws InputError with all faults of the file, each with its line.
WagonData ReadWagonData(const std::filesystem::path& path);
/// @param text the whole file. @param file its name for messages.
WagonData ParseWagonData(std::string_view text, const std::string& file);

}  // namespace uiclink
