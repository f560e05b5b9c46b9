#pragma once

#include <span>
#include <string>

#include "reports/text_table.h"
#include "vehicle/freight.h"
#include "vehicle/inertia.h"
#include "vehicle/wagon_data.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// What `wagon inertia` prints: the parts (table 7.1), then for each freight mass, centre of mass and inertias beside
/// tables 7.2 and 7.3 where they have it, both with the slips of the printed calculation and without; corner loads and
/// notices where the freight is not even.
/// @throws std::invalid_argument when the wagon has no parts or there is no freight (an empty wagon is one, too).
std::string FormatInertiaReport(const WagonData& wagon, std::span<const Freight> freights,
                                const InertiaOptions& options = {});
/// Tables of it: parts of the empty body, and the body with each freight.
TextTable MakePartTable(const WagonData& wagon, const InertiaOptions& options);
TextTable MakeFreightTable(const WagonData& wagon, std::span<const Freight> freights, const InertiaOptions& options);
/// What has to be said about the centre of mass, the partitions and uneven freight.
std::string DescribeInertiaOptions(const InertiaOptions& options);

/// The same as JSON, schema "wagon-inertia/1". SI units.
///   { "schema", "version", "inputs", "wagon", "com": "printed"|"corrected", "partitions": "at-ends"|"spread",
///     "printed_yaw_slip",
///     "parts": [ { "name", "count", "mass_kg", "z_m", "I_roll_kg_m2", "I_yaw_kg_m2" } ],       of the empty body
///     "freights": [ { "name", "mass_kg", "total_mass_kg", "com_m": {"x","y","z"}, "I_roll_kg_m2", "I_yaw_kg_m2",
///                     "I_xz_kg_m2", "corner_loads_N": {"front_left",..}, "published": {..}|null, "notices": [..] } ] }
/// @param inputs  its data and choice.inertia, and the files behind them.
/// @throws std::invalid_argument as above.
std::string FormatInertiaJson(const WagonInputs& inputs, std::span<const Freight> freights);

}  // namespace uiclink
