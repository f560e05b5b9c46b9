#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/contact/calc_contact_table.h"
#include "vehicle/contact/conicity.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Equivalent conicity for one amplitude; NaN where the wheelset does not swing about a centre within the table.
struct ConicityPoint {
  double amplitude = 0;   ///< half of the motion from peak to peak [m]
  double equivalent = 0;  ///< of the table, hence with roll and, where it is, elastic contact [-]
  double harmonic = 0;    ///< of the table, by the first harmonic [-]
  double en15302 = 0;     ///< of the geometry as the standard wants it: rigid, without roll [-]; NaN without a geometry
};

/// What `wagon contact` finds out about a contact table, beside inputs.contact_notes.
struct ContactAnalysis {
  RollingRadiusDifference difference;                       ///< of the table
  std::vector<ConicityPoint> conicity;                      ///< by amplitude
  std::optional<RollingRadiusDifference> rigid_difference;  ///< of the geometry as EN 15302 wants it, if there is one
};

/// Conicity of inputs.table and of inputs.geometry, where that says what the table was made from.
/// @param inputs  with the contact read (ReadWagonContact).
ContactAnalysis AnalyseContact(const WagonInputs& inputs);

/// For a terminal: a handful of rows, conicity, jumps, two-point contact.
std::string FormatContact(const WagonInputs& inputs, const ContactAnalysis& analysis);
/// Tables of it.
TextTable MakeContactRowTable(const ContactTable& table);
TextTable MakeConicityTable(const ContactAnalysis& analysis);
TextTable MakeJumpTable(const ContactNotes& notes);
/// @param inputs  with contact_notes and geometry.
TextTable MakeTwoPointTable(const WagonInputs& inputs);

/// Schema "wagon-contact/1". SI units. "rows" are a handful: the whole table is the text file that --out writes.
///   { "schema", "version", "inputs",
///     "table": { "name", "r0", "shear_modulus", "contact": "rigid"|"elastic"|null, "rows", "y_max", "wall_s" },
///     "rows": [ { "y", "a_wheel", ..., "phi_roll" } ],
///     "conicity": [ { "amplitude", "equivalent", "harmonic", "en15302" } ],
///     "centre_conicity",                                          for the least amplitude
///     "rolling_radius_difference": [ { "y", "delta_r" } ],
///     "jumps": [ { "y", "before": {"a_wheel","a_rail","r","delta"}, "after": {..} } ] | null,
///     "two_point_contact": [ { "y_from", "y_to", "where": "tread"|"flange root", "touching_a_wheel", "second_a_wheel",
///                              "touching_delta", "second_delta", "least_gap" } ] | null }
std::string FormatContactJson(const WagonInputs& inputs, const ContactAnalysis& analysis);

/// What appendix H of the thesis draws, over the lateral displacement: Kalker's coefficients, contact angle, semi-axes,
/// contact point on wheel and on rail, rolling radius, normal force, static penetration, height on the rail.
Figure ContactTableFigure(const WagonInputs& inputs);
/// Rolling radius difference over displacement and equivalent conicity over amplitude.
Figure ConicityFigure(const WagonInputs& inputs, const ContactAnalysis& analysis);

}  // namespace uiclink
