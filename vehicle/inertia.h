#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle/freight.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

/// Which centre of mass: the printed calculation weights the two sliding panels' height with the mass of the four
/// partitions (appendix G): 0.802 m, where the parts list gives 0.916 m.
enum class CentreOfMass { kPrinted, kCorrected };

/// Where the partitions stand: nobody says. Appendix G takes all four at the ends, which makes the most of their yaw
/// inertia; spread evenly they take 50 033 kg m^2 away.
enum class Partitions { kAtEnds, kSpread };

struct InertiaOptions {
  CentreOfMass com = CentreOfMass::kCorrected;
  Partitions partitions = Partitions::kAtEnds;
  /// Whether the yaw inertia counts the centre column's roof struts twice and its posts not at all, as appendix G does:
  /// 153 kg m^2 less.
  bool printed_yaw_slip = false;

  /// Everything as in appendix G: tables 7.1 to 7.3 to all their digits.
  static InertiaOptions Printed() {
    return {.com = CentreOfMass::kPrinted, .partitions = Partitions::kAtEnds, .printed_yaw_slip = true};
  }
};

/// A part or a piece of freight as it enters the sums: all `count` of them together unless it says otherwise.
struct PartInertia {
  std::string name;
  int count = 1;
  double mass = 0;       ///< [kg]
  double x = 0;          ///< centre of mass ahead of the middle of the wagon [m]
  double y = 0;          ///< ... left of the middle [m]
  double z = 0;          ///< ... above the underframe [m]
  double I_x_own = 0;    ///< roll inertia about the longitudinal line through its own centre of mass, of one [kg m^2]
  double I_z_own = 0;    ///< yaw inertia about the vertical line through its own centre of mass, of one [kg m^2]
  double I_x = 0;        ///< contribution to the body's roll inertia, about the body's reference line [kg m^2]
  double I_z = 0;        ///< contribution to the body's yaw inertia [kg m^2]
  double I_xz = 0;       ///< contribution to its product of inertia [kg m^2]
  bool freight = false;  ///< freight, not a part of the car body
};

/// The body with what it is made of. The sums of `parts` are those of `body`.
struct BodyInertiaTable {
  BodyInertia body;
  std::vector<PartInertia> parts;
};

/// Car body and freight as one rigid body. With mass m_i and centre of mass r_i of each part (equation of chapter 7),
///   r_C = sum m_i r_i / m,   I = sum (I_i + m_i R_i^2),  R_i the distance of its centre of mass from the line through
/// r_C; h = z_C. With the printed centre of mass all lines pass through that point instead, as in appendix G.
/// @throws std::invalid_argument when the wagon has no parts.
BodyInertiaTable CalcBodyInertiaTable(const WagonData& wagon, const Freight& freight,
                                      const InertiaOptions& options = {});
BodyInertia CalcBodyInertia(const WagonData& wagon, const Freight& freight, const InertiaOptions& options = {});

/// Static force on each spring [N]: front left, front right, rear left, rear right. Four springs under a rigid body are
/// statically indeterminate; these are for equal linear springs, m g/4 (1 +- x/l +- y/b).
std::array<double, 4> CalcCornerLoads(const WagonData& wagon, const BodyInertia& body);

}  // namespace uiclink
