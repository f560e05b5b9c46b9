#include "vehicle/inertia_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "reports/text_table.h"
#include "reports/wrap.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

/// A row of table 7.3.
struct PublishedInertia {
  const char* freight;
  double h;    ///< [m]
  double I_x;  ///< [kg m^2]
  double I_z;  ///< [kg m^2]
};

const PublishedInertia* FindPublished(const std::string& freight) {
  static constexpr PublishedInertia kTable73[] = {{"empty", 0.802, 32675, 413097},
                                                  {"water", 0.610, 48428, 854314},
                                                  {"gold", 0.489, 49893, 854314},
                                                  {"packed", 1.182, 58014, 854314}};
  for (const PublishedInertia& row : kTable73)
    if (freight == row.freight) return &row;
  return nullptr;
}

void CheckFreights(std::span<const Freight> freights) {
  if (freights.empty()) throw std::invalid_argument("FormatInertiaReport: no freight, must be at least one");
}

double FreightMass(const Freight& freight, const WagonData& wagon) {
  double mass = 0;
  for (const FreightBox& box : PlaceFreight(freight, wagon.cargo)) mass += box.mass;
  return mass;
}

/// Freight that moves the centre of mass off the middle by a millimetre and more.
bool IsUneven(const BodyInertia& body) { return std::abs(body.x) >= 1e-3 || std::abs(body.y) >= 1e-3; }

void AddFreightRow(const WagonData& wagon, const Freight& freight, const InertiaOptions& options,
                   const std::string& label, TextTable* table) {
  const BodyInertia body = CalcBodyInertia(wagon, freight, options);
  table->AddRow({label, fmt::format("{:.0f}", body.m), fmt::format("{:.3f}", body.h), fmt::format("{:.0f}", body.I_x),
                 fmt::format("{:.0f}", body.I_z)});
}

std::string FormatUneven(const WagonData& wagon, const Freight& freight, const InertiaOptions& options) {
  std::string text;
  const BodyInertia body = CalcBodyInertia(wagon, freight, options);
  if (IsUneven(body)) {
    const std::array<double, 4> loads = CalcCornerLoads(wagon, body);
    text += fmt::format(
        "{}: centre of mass {:+.0f} mm ahead and {:+.0f} mm left of the middle; product of inertia {:.0f} kg m².\n"
        "  static load of the springs (equal and linear): front {:.1f} left, {:.1f} right; rear {:.1f} left, {:.1f} "
        "right [kN]\n",
        freight.name, 1e3 * body.x, 1e3 * body.y, body.I_xz, 1e-3 * loads[0], 1e-3 * loads[1], 1e-3 * loads[2],
        1e-3 * loads[3]);
    for (const double load : loads)
      if (load <= 0) return text + "  a spring carries nothing: the wagon would tip, and no run can start from this.\n";
  }
  return text;
}

std::string FormatNotices(const WagonData& wagon, std::span<const Freight> freights, const InertiaOptions& options) {
  std::string text;
  for (const Freight& freight : freights) {
    text += FormatUneven(wagon, freight, options);
    for (const std::string& notice : CheckFreight(freight, wagon.cargo))
      text += fmt::format("{}: {}.\n", freight.name, notice);
  }
  return text.empty() ? text : "\n" + text;
}

Json PartsJson(const WagonData& wagon, const InertiaOptions& options) {
  Json parts = Json::array();
  for (const PartInertia& part : CalcBodyInertiaTable(wagon, {}, options).parts) {
    parts.push_back({{"name", part.name},
                     {"count", part.count},
                     {"mass_kg", part.mass},
                     {"z_m", part.z},
                     {"I_roll_kg_m2", part.I_x},
                     {"I_yaw_kg_m2", part.I_z}});
  }
  return parts;
}

Json FreightJson(const WagonData& wagon, const Freight& freight, const InertiaOptions& options) {
  const BodyInertia body = CalcBodyInertia(wagon, freight, options);
  const std::array<double, 4> loads = CalcCornerLoads(wagon, body);
  Json json = {
      {"name", freight.name},
      {"mass_kg", FreightMass(freight, wagon)},
      {"total_mass_kg", body.m},
      {"com_m", {{"x", body.x}, {"y", body.y}, {"z", body.h}}},
      {"I_roll_kg_m2", body.I_x},
      {"I_yaw_kg_m2", body.I_z},
      {"I_xz_kg_m2", body.I_xz},
      {"corner_loads_N",
       {{"front_left", loads[0]}, {"front_right", loads[1]}, {"rear_left", loads[2]}, {"rear_right", loads[3]}}}};
  const PublishedInertia* published = FindPublished(freight.name);
  json["published"] = published == nullptr ? Json(nullptr)
                                           : Json{{"source", "thesis 2003, table 7.3"},
                                                  {"z_m", published->h},
                                                  {"I_roll_kg_m2", published->I_x},
                                                  {"I_yaw_kg_m2", published->I_z}};
  json["notices"] = CheckFreight(freight, wagon.cargo);
  return json;
}

}  // namespace

std::string DescribeInertiaOptions(const InertiaOptions& options) {
  std::string text =
      options.com == CentreOfMass::kPrinted
          ? "Centre of mass as printed: appendix G weights the sliding panels with the partitions' mass. "
          : "Centre of mass corrected: the sliding panels have their own mass, not the partitions'. ";
  text += options.partitions == Partitions::kAtEnds ? "Partitions at the ends, as in appendix G"
                                                    : "Partitions spread evenly along the wagon";
  text += options.printed_yaw_slip ? "; centre column's struts twice and posts not at all in yaw, as printed there."
                                   : "; centre column whole.";
  return text;
}

TextTable MakePartTable(const WagonData& wagon, const InertiaOptions& options) {
  const BodyInertiaTable empty = CalcBodyInertiaTable(wagon, {}, options);
  TextTable table;
  table.AddColumn("part", TextTable::Align::kLeft);
  table.AddColumn("#");
  table.AddColumn("mass each\nkg");
  table.AddColumn("total\nkg");
  table.AddColumn("height\nm");
  table.AddColumn("roll\nkg m²");
  table.AddColumn("yaw\nkg m²");
  const auto number = [](double value, int digits) { return fmt::format("{:.{}f}", value, digits); };
  for (const PartInertia& part : empty.parts) {
    table.AddRow({part.name, fmt::format("{}", part.count), number(part.mass / part.count, 0), number(part.mass, 0),
                  number(part.z, 3), number(part.I_x, 0), number(part.I_z, 0)});
  }
  table.AddRule();
  table.AddRow({"sum", "", "", number(empty.body.m, 0), number(empty.body.h, 3), number(empty.body.I_x, 0),
                number(empty.body.I_z, 0)});
  return table;
}

TextTable MakeFreightTable(const WagonData& wagon, std::span<const Freight> freights, const InertiaOptions& options) {
  TextTable table;
  table.AddColumn("freight", TextTable::Align::kLeft);
  table.AddColumn("mass\nkg");
  table.AddColumn("height of c.o.m.\nm");
  table.AddColumn("roll\nkg m²");
  table.AddColumn("yaw\nkg m²");
  for (const Freight& freight : freights) {
    AddFreightRow(wagon, freight, options, freight.name, &table);
    const PublishedInertia* published = FindPublished(freight.name);
    if (published == nullptr) continue;
    AddFreightRow(wagon, freight, InertiaOptions::Printed(), "  as appendix G calculates", &table);
    table.AddRow({"  table 7.3", "", fmt::format("{:.3f}", published->h), fmt::format("{:.0f}", published->I_x),
                  fmt::format("{:.0f}", published->I_z)});
  }
  return table;
}

std::string FormatInertiaReport(const WagonData& wagon, std::span<const Freight> freights,
                                const InertiaOptions& options) {
  CheckFreights(freights);
  return fmt::format("{}, car body without freight\n\n", wagon.name) + MakePartTable(wagon, options).Format(2) + "\n" +
         Paragraph(DescribeInertiaOptions(options), 0, 100) + "\nWith freight\n\n" +
         MakeFreightTable(wagon, freights, options).Format(2) + FormatNotices(wagon, freights, options);
}

std::string FormatInertiaJson(const WagonInputs& inputs, std::span<const Freight> freights) {
  CheckFreights(freights);
  const WagonData& wagon = inputs.data;
  const InertiaOptions& options = inputs.choice.inertia;
  Json json = BeginResult("inertia", inputs);
  json["wagon"] = wagon.name;
  json["com"] = Name(options.com);
  json["partitions"] = Name(options.partitions);
  json["printed_yaw_slip"] = options.printed_yaw_slip;
  json["parts"] = PartsJson(wagon, options);
  json["freights"] = Json::array();
  for (const Freight& freight : freights) json["freights"].push_back(FreightJson(wagon, freight, options));
  return FormatJson(json);
}

}  // namespace uiclink
