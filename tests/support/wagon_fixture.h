#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include "data/parameter_set_file.h"
#include "vehicle/contact/contact_table.h"
#include "vehicle/contact/calc_contact_table.h"
#include "vehicle/freight.h"
#include "vehicle/inertia.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

/// A wheel profile by hand on rails that are knife edges, so that everything about the contact is a formula: the
/// rolling radius at the distance a0 - u from the wheelset's centre is
///   R(u) = r0 + conicity u + flange(u),
/// flange() rises smoothly from `flange_at` on, over `flange_width`, to the slope of a flange.
struct HandMadeProfile {
  double r0 = 0.425;  ///< [m]
  double a0 = 0.75;   ///< distance of the rails from the track's centre [m]
  double conicity = 0.03;
  double flange_at = 5.5e-3;   ///< [m]
  double flange_width = 2e-3;  ///< [m]
  double flange_slope = 2.7;   ///< tan 70 degrees; 0: a cone without flange
  double y_max = 9e-3;         ///< the table reaches to -+ y_max [m]
  int rows = 181;

  double Slope(double u) const {
    const double t = std::clamp((u - flange_at) / flange_width, 0.0, 1.0);
    return conicity + flange_slope * t * t * (3 - 2 * t);
  }
  double Radius(double u) const {
    const double t = std::clamp((u - flange_at) / flange_width, 0.0, 1.0);
    const double beyond = std::max(u - flange_at - flange_width, 0.0);
    return r0 + conicity * u + flange_slope * (flange_width * t * t * t * (1 - 0.5 * t) + beyond);
  }
};

/// Both wheels on their edges, exactly: with the wheelset's centre at (y, r0 + z) and its roll phi the points (a_l,
/// -r_l) and (-a_r, -r_r) of it are on (a0, 0) and (-a0, 0). Hertz: 38 kN make 55 um and an ellipse of 6 mm by 5 mm.
inline ContactTable MakeHandMadeTable(const HandMadeProfile& profile = {}) {
  ContactTable table{.name = "hand-made", .r0 = profile.r0, .shear_modulus = 8.27e10, .rows = {}};
  for (int i = 0; i < profile.rows; ++i) {
    const double y = profile.y_max * (2.0 * i / (profile.rows - 1) - 1);
    double phi = 0, z = 0, a_l = 0, a_r = 0, r_l = 0, r_r = 0;
    // R changes little with a, so that putting one into the other converges by the slope times phi a round.
    for (int round = 0; round < 200; ++round) {
      const double c = std::cos(phi), s = std::sin(phi);
      a_l = ((profile.a0 - y) - r_l * s) / c;
      a_r = ((profile.a0 + y) + r_r * s) / c;
      r_l = profile.Radius(profile.a0 - a_l);
      r_r = profile.Radius(profile.a0 - a_r);
      const double z_l = r_l * c - a_l * s;
      const double z_r = r_r * c + a_r * s;
      z = 0.5 * (z_l + z_r) - profile.r0;
      phi += 0.5 * (z_l - z_r) / profile.a0;  // until both stand at one height
    }
    ContactRow row;
    row.y = y;
    row.a_wheel = a_l;
    row.a_rail = profile.a0;
    row.r = r_l;
    row.z_rail = 0;
    row.delta = std::atan(profile.Slope(profile.a0 - a_l));
    row.c11 = 4.12;
    row.c22 = 3.67;
    row.c23 = 1.47;
    row.a_e = 6e-3;
    row.b_e = 5e-3;
    row.q0 = 55e-6;
    row.n0 = 38e3;
    row.z_lift = z;
    row.phi_roll = phi;
    table.rows.push_back(row);
  }
  return table;
}

/// What a wagon for tests is made of.
struct WagonFixture {
  std::string set = "set1";
  std::string freight = "empty";
  WagonOptions options = {};

  static std::filesystem::path Data() { return std::filesystem::path(UICLINK_SOURCE_DIR) / "data"; }
  WagonData ReadData() const { return ReadWagonData(Data() / "wagons" / "hbbills311.toml"); }
  BodyInertia ReadBody() const {
    return CalcBodyInertia(ReadData(), ReadFreight(Data() / "freight" / (freight + ".toml")));
  }
  CornerLinks ReadLinks() const {
    const ParameterSet parameters = ReadParameterSet(Data() / "parameter_sets" / (set + ".toml"));
    return {*parameters.longitudinal, *parameters.lateral, parameters.g};
  }
  Wagon Make(const ContactTable& table) const {
    const CornerLinks links = ReadLinks();
    return Wagon(ReadData(), ReadBody(), freight != "empty", {links, links, links, links}, table, options);
  }
  /// On the knife edges.
  Wagon Make() const { return Make(MakeHandMadeTable()); }
  /// On a geometry of data/geometry/.
  Wagon MakeOn(const std::string& geometry) const {
    return Make(CalcContactTable(ReadTrackGeometry(Data() / "geometry" / (geometry + ".toml"))));
  }
};

}  // namespace uiclink
