#include "vehicle/inertia.h"

#include <cmath>
#include <stdexcept>

namespace uiclink {
namespace {

/// Share of the whole, and mean values over a cross-section: y, z, y^2, z^2 about the origin of the section.
struct SectionMeans {
  double y = 0, z = 0, yy = 0, zz = 0;

  void Add(double share, const SectionMeans& piece) {
    y += share * piece.y;
    z += share * piece.z;
    yy += share * piece.yy;
    zz += share * piece.zz;
  }
};

/// Mean of t^2 along a straight line between t = a and t = b.
double MeanSquare(double a, double b) { return (a * a + a * b + b * b) / 3; }

SectionMeans CalcPieceMeans(const std::array<double, 2>& p, const std::array<double, 2>& q) {
  return {.y = (p[0] + q[0]) / 2, .z = (p[1] + q[1]) / 2, .yy = MeanSquare(p[0], q[0]), .zz = MeanSquare(p[1], q[1])};
}

double CalcLength(const WagonPart& part) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < part.section.size(); ++i) {
    length += std::hypot(part.section[i + 1][0] - part.section[i][0], part.section[i + 1][1] - part.section[i][1]);
  }
  return length;
}

/// @param weights how often each piece counts; empty: once.
SectionMeans CalcLineMeans(const WagonPart& part, const std::vector<double>& weights) {
  const double length = CalcLength(part);
  SectionMeans means;
  for (std::size_t i = 0; i + 1 < part.section.size(); ++i) {
    const auto& p = part.section[i];
    const auto& q = part.section[i + 1];
    const double weight = weights.empty() ? 1.0 : weights[i];
    means.Add(weight * std::hypot(q[0] - p[0], q[1] - p[1]) / length, CalcPieceMeans(p, q));
  }
  return means;
}

/// Green's theorem: the polygon as a sum of triangles with the origin, of signed area.
SectionMeans CalcAreaMeans(const WagonPart& part) {
  double area = 0;
  SectionMeans sums;
  for (std::size_t i = 0; i < part.section.size(); ++i) {
    const auto& p = part.section[i];
    const auto& q = part.section[(i + 1) % part.section.size()];
    const double triangle = (p[0] * q[1] - q[0] * p[1]) / 2;
    area += triangle;
    sums.Add(triangle, {.y = (p[0] + q[0]) / 3,
                        .z = (p[1] + q[1]) / 3,
                        .yy = MeanSquare(p[0], q[0]) / 2,
                        .zz = MeanSquare(p[1], q[1]) / 2});
  }
  SectionMeans means;
  means.Add(1 / area, sums);
  return means;
}

SectionMeans CalcMeans(const WagonPart& part, const std::vector<double>& weights = {}) {
  switch (part.kind) {
    case SectionKind::kPoint:
      return CalcPieceMeans(part.section.at(0), part.section.at(0));
    case SectionKind::kLine:
      return CalcLineMeans(part, weights);
    case SectionKind::kArea:
      return CalcAreaMeans(part);
  }
  throw std::logic_error("CalcMeans: unknown kind of section");
}

/// One rigid piece: mass, centre of mass, inertia about its own centre.
struct Piece {
  double mass = 0, x = 0, y = 0, z = 0, I_x = 0, I_z = 0;
  double com_mass = 0;  // its weight in the centre of mass
  /// What the printed calculation adds to I_z + m R^2, at the middle of the wagon.
  double printed_yaw_excess = 0;
};

/// The pieces of one line of the table: count equal pieces at different places.
struct Line {
  std::string name;
  std::vector<Piece> pieces;
  bool freight = false;
};

Line MakeLine(const WagonPart& part, const InertiaOptions& options) {
  const SectionMeans means = CalcMeans(part);
  Piece piece{.mass = part.mass, .z = means.z};
  const double own_yy = means.yy - means.y * means.y;
  piece.I_x = part.mass * (own_yy + means.zz - means.z * means.z);
  piece.I_z = part.mass * (own_yy + part.length * part.length / 12);
  piece.com_mass = options.com == CentreOfMass::kPrinted ? part.printed_com_mass.value_or(part.mass) : part.mass;
  if (options.printed_yaw_slip && !part.printed_yaw_weights.empty()) {
    piece.printed_yaw_excess = part.mass * (CalcMeans(part, part.printed_yaw_weights).yy - means.yy);
  }
  Line line;
  line.name = part.name;
  const bool spread = options.partitions == Partitions::kSpread && !part.at_spread.empty();
  for (const std::array<double, 2>& at : spread ? part.at_spread : part.at) {
    line.pieces.push_back(piece);
    line.pieces.back().x = at[0];
    line.pieces.back().y = means.y + at[1];
  }
  return line;
}

Line MakeLine(const FreightBox& box, const CargoSpace& cargo) {
  const double yy = box.width * box.width / 12;
  return {.name = box.name,
          .pieces = {{.mass = box.mass,
                      .x = box.x,
                      .y = box.y,
                      .z = cargo.floor + box.z + box.height / 2,
                      .I_x = box.mass * (yy + box.height * box.height / 12),
                      .I_z = box.mass * (yy + box.length * box.length / 12),
                      .com_mass = box.mass}},
          .freight = true};
}

/// Centre of mass: each piece with its weight, over the true mass (which is how the slip of appendix G works).
void CalcCentre(const std::vector<Line>& lines, BodyInertia* body) {
  double x = 0, y = 0, z = 0;
  for (const Line& line : lines) {
    for (const Piece& piece : line.pieces) {
      body->m += piece.mass;
      x += piece.com_mass * piece.x;
      y += piece.com_mass * piece.y;
      z += piece.com_mass * piece.z;
    }
  }
  body->x = x / body->m;
  body->y = y / body->m;
  body->h = z / body->m;
}

PartInertia CalcPart(const Line& line, const BodyInertia& body) {
  PartInertia part{.name = line.name, .count = static_cast<int>(line.pieces.size()), .freight = line.freight};
  for (const Piece& piece : line.pieces) {
    const double x = piece.x - body.x, y = piece.y - body.y, z = piece.z - body.h;
    part.mass += piece.mass;
    part.x += piece.mass * piece.x;
    part.y += piece.mass * piece.y;
    part.z += piece.mass * piece.z;
    part.I_x_own = piece.I_x;
    part.I_z_own = piece.I_z;
    part.I_x += piece.I_x + piece.mass * (y * y + z * z);
    part.I_z += piece.I_z + piece.mass * (x * x + y * y) + piece.printed_yaw_excess;
    part.I_xz += piece.mass * x * z;  // a piece is symmetric fore and aft of its middle: none of its own
  }
  part.x /= part.mass;
  part.y /= part.mass;
  part.z /= part.mass;
  return part;
}

}  // namespace

BodyInertiaTable CalcBodyInertiaTable(const WagonData& wagon, const Freight& freight, const InertiaOptions& options) {
  if (wagon.parts.empty()) throw std::invalid_argument("CalcBodyInertia: wagon has no parts, must have at least one");
  std::vector<Line> lines;
  for (const WagonPart& part : wagon.parts) lines.push_back(MakeLine(part, options));
  for (const FreightBox& box : PlaceFreight(freight, wagon.cargo)) lines.push_back(MakeLine(box, wagon.cargo));
  BodyInertiaTable table;
  CalcCentre(lines, &table.body);
  for (const Line& line : lines) {
    table.parts.push_back(CalcPart(line, table.body));
    table.body.I_x += table.parts.back().I_x;
    table.body.I_z += table.parts.back().I_z;
    table.body.I_xz += table.parts.back().I_xz;
  }
  return table;
}

BodyInertia CalcBodyInertia(const WagonData& wagon, const Freight& freight, const InertiaOptions& options) {
  return CalcBodyInertiaTable(wagon, freight, options).body;
}

std::array<double, 4> CalcCornerLoads(const WagonData& wagon, const BodyInertia& body) {
  const double quarter = body.m * wagon.g / 4;
  const double fore = body.x / wagon.l, left = body.y / wagon.b;
  return {quarter * (1 + fore + left), quarter * (1 + fore - left), quarter * (1 - fore + left),
          quarter * (1 - fore - left)};
}

}  // namespace uiclink
