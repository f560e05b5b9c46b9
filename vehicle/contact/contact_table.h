#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace uiclink {

/// Contact of the left wheel with the wheelset displaced by y (positive left: the left flange nears its rail) and
/// standing in its kinematic position: both wheels just touch their rails. SI units, angles [rad].
struct ContactRow {
  double y = 0;        ///< lateral displacement of the wheelset [m]
  double a_wheel = 0;  ///< lateral distance of the contact point from the wheelset's centre, wheelset frame [m], > 0
  double a_rail = 0;   ///< the same from the track centre, track frame [m], > 0
  double r = 0;        ///< rolling radius [m]
  double z_rail = 0;   ///< height of the contact point above the top of the rail [m]
  double delta = 0;    ///< contact angle, wheelset frame; positive towards the flange
  double c11 = 0;      ///< Kalker's coefficients [-] for the ratio a_e/b_e
  double c22 = 0;
  double c23 = 0;
  double a_e = 0;       ///< semi-axis of the contact ellipse along rolling [m], under n0
  double b_e = 0;       ///< semi-axis across rolling [m], under n0
  double q0 = 0;        ///< approach under n0 [m], measured from the touching height, along the normal
  double n0 = 0;        ///< normal force that a_e, b_e and q0 belong to [N]
  double z_lift = 0;    ///< height of the wheelset's centre above r0 over the rail tops when both wheels touch [m]
  double phi_roll = 0;  ///< its roll there [rad]
};

/// The table that RSGEO supplied to the thesis: rows by increasing y.  Where the contact jumps, two rows have the same
/// y: the contact before and after. The right wheel is the left one at -y, mirrored.
struct ContactTable {
  std::string name;          ///< geometry that it was built from
  double r0 = 0;             ///< nominal rolling radius [m]
  double shear_modulus = 0;  ///< G [N/m^2]
  std::vector<ContactRow> rows;
};

/// Reads a contact table: `# key: value` lines (name, r0, shear_modulus), a header row with the names of the columns in
/// any order, then rows. Everything is checked: every column once, finite numbers, rows by increasing y with at most
/// two at one y, positive r, a_e, b_e, q0, n0, c11, c22.
/// @throws InputError with file and line.
ContactTable ReadContactTable(const std::filesystem::path& path);
ContactTable ParseContactTable(std::string_view text, const std::string& file);

/// The table as text that reads back bit by bit.
std::string FormatContactTable(const ContactTable& table);
/// Writes it whole or not at all.
void WriteContactTable(const ContactTable& table, const std::filesystem::path& path);

}  // namespace uiclink
