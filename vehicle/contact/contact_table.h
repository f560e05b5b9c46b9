#pragma once

#include <array>
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

/// A column of the text file and of reports: the name of a member, and what its numbers must be.
struct ContactColumn {
  enum class Rule {
    kAny,       ///< finite
    kPositive,  ///< > 0
    kAngle,     ///< between -pi/2 and pi/2 [rad]
  };
  std::string_view name;
  double ContactRow::*value;
  Rule rule;
};
inline constexpr std::array<ContactColumn, 15> kContactColumns{{
    {"y", &ContactRow::y, ContactColumn::Rule::kAny},
    {"a_wheel", &ContactRow::a_wheel, ContactColumn::Rule::kPositive},
    {"a_rail", &ContactRow::a_rail, ContactColumn::Rule::kPositive},
    {"r", &ContactRow::r, ContactColumn::Rule::kPositive},
    {"z_rail", &ContactRow::z_rail, ContactColumn::Rule::kAny},
    {"delta", &ContactRow::delta, ContactColumn::Rule::kAngle},
    {"c11", &ContactRow::c11, ContactColumn::Rule::kPositive},
    {"c22", &ContactRow::c22, ContactColumn::Rule::kPositive},
    {"c23", &ContactRow::c23, ContactColumn::Rule::kAny},
    {"a_e", &ContactRow::a_e, ContactColumn::Rule::kPositive},
    {"b_e", &ContactRow::b_e, ContactColumn::Rule::kPositive},
    {"q0", &ContactRow::q0, ContactColumn::Rule::kPositive},
    {"n0", &ContactRow::n0, ContactColumn::Rule::kPositive},
    {"z_lift", &ContactRow::z_lift, ContactColumn::Rule::kAny},
    {"phi_roll", &ContactRow::phi_roll, ContactColumn::Rule::kAngle},
}};

/// Reads a contact table: `# key: value` lines (name, r0, shear_modulus), a header row with the names of the columns in
/// any order, then rows. Everything is checked: every column once, finite numbers, rows by increasing y with at most
/// two at one y, positive r, a_e, b_e, q0, n0, c11, c22.
/// @throws InputError with file and line.
ContactTable ReadContactTable(const std::filesystem::path& path);
ContactTable ParseContactTable(std::string_view text, const std::string& file);

/// The table as text that reads back bit by bit.
/// @throws std::invalid_argument for a table that could not be read back.
std::string FormatContactTable(const ContactTable& table);

}  // namespace uiclink
