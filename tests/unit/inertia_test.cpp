#include "vehicle/inertia.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "data/file.h"
#include "data/input_error.h"
#include "vehicle/inertia_report.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::filesystem::path DataFolder() { return std::filesystem::path(UICLINK_SOURCE_DIR) / "data"; }
WagonData Hbbills() { return ReadWagonData(DataFolder() / "wagons" / "hbbills311.toml"); }

/// A wagon whose body is one part.
WagonData WagonOf(const WagonPart& part) {
  WagonData wagon;
  wagon.g = 9.82;
  wagon.b = 1;
  wagon.l = 5;
  wagon.parts = {part};
  wagon.cargo = {.floor = 0, .length = 10, .width = 3, .height = 2, .ridge_height = 3, .ridge_width = 1};
  return wagon;
}

Freight FreightOf(const FreightBox& box) {
  Freight freight;
  freight.name = "box";
  freight.boxes = {box};
  return freight;
}

// All closed forms below are a few products of numbers of order 1 to 1000: 1e-13 relative is some hundred roundings.
void ExpectClose(double found, double expected) { EXPECT_NEAR(found, expected, 1e-13 * (1 + std::abs(expected))); }

TEST(Inertia, OfAThinPlateLyingFlat) {
  WagonPart plate{.name = "plate", .mass = 12, .kind = SectionKind::kLine, .section = {{-1.5, 0.5}, {1.5, 0.5}}};
  plate.length = 4;
  plate.at = {{0, 0}};
  const BodyInertia body = CalcBodyInertia(WagonOf(plate), {});
  ExpectClose(body.m, 12);
  ExpectClose(body.h, 0.5);
  ExpectClose(body.I_x, 12 * 9.0 / 12);
  ExpectClose(body.I_z, 12 * (9.0 + 16.0) / 12);
}

TEST(Inertia, OfASolidPrismIsThatOfABox) {
  WagonPart prism{
      .name = "prism", .mass = 12, .kind = SectionKind::kArea, .section = {{-1, 0}, {1, 0}, {1, 3}, {-1, 3}}};
  prism.length = 5;
  prism.at = {{0.25, -0.5}};
  const BodyInertia body = CalcBodyInertia(WagonOf(prism), {});
  ExpectClose(body.h, 1.5);
  ExpectClose(body.x, 0.25);
  ExpectClose(body.y, -0.5);
  ExpectClose(body.I_x, 12 * (4.0 + 9.0) / 12);
  ExpectClose(body.I_z, 12 * (4.0 + 25.0) / 12);
  EXPECT_NEAR(body.I_xz, 0, 1e-13);
}

TEST(Inertia, OfAPolygonDoesNotDependOnItsSenseOrFirstCorner) {
  WagonPart wall{.name = "wall", .mass = 7, .kind = SectionKind::kArea, .section = {{0, 0}, {3, 0}, {2, 2}, {0, 1}}};
  wall.at = {{0, 0}};
  const BodyInertia one = CalcBodyInertia(WagonOf(wall), {});
  wall.section = {{2, 2}, {3, 0}, {0, 0}, {0, 1}};
  const BodyInertia other = CalcBodyInertia(WagonOf(wall), {});
  ExpectClose(other.I_x, one.I_x);
  ExpectClose(other.I_z, one.I_z);
  ExpectClose(other.h, one.h);
}

TEST(Inertia, OfATriangle) {
  // About the centroid, base b and height h: m h^2/18 for the distances along h, m b^2/24 along b when it is isosceles.
  WagonPart wall{.name = "gable", .mass = 6, .kind = SectionKind::kArea, .section = {{-1, 0}, {1, 0}, {0, 3}}};
  wall.at = {{0, 0}};
  const BodyInertia body = CalcBodyInertia(WagonOf(wall), {});
  ExpectClose(body.h, 1);
  ExpectClose(body.I_x, 6 * (9.0 / 18 + 4.0 / 24));
  ExpectClose(body.I_z, 6 * 4.0 / 24);
}

TEST(Inertia, OfASlopingRodAndOfPoints) {
  WagonPart rod{.name = "rod", .mass = 3, .kind = SectionKind::kLine, .section = {{0, 0}, {3, 4}}};
  rod.at = {{0, 0}};
  const BodyInertia body = CalcBodyInertia(WagonOf(rod), {});
  ExpectClose(body.I_x, 3 * 25.0 / 12);
  ExpectClose(body.I_z, 3 * 9.0 / 12);
  WagonPart points{.name = "points", .mass = 2, .kind = SectionKind::kPoint, .section = {{0, 1}}};
  points.at = {{-3, -1}, {-3, 1}, {3, -1}, {3, 1}};
  const BodyInertia four = CalcBodyInertia(WagonOf(points), {});
  ExpectClose(four.m, 8);
  ExpectClose(four.I_x, 8 * 1.0);
  ExpectClose(four.I_z, 8 * 10.0);
}

TEST(Inertia, FreightEntersWithSteiner) {
  WagonPart point{.name = "point", .mass = 1000, .kind = SectionKind::kPoint, .section = {{0, 0}}};
  point.at = {{0, 0}};
  const FreightBox box{.name = "box", .mass = 3000, .length = 4, .width = 2, .height = 1, .x = 2, .y = 0.5, .z = 0.5};
  const BodyInertia body = CalcBodyInertia(WagonOf(point), FreightOf(box));
  const double reduced = 750;  // m1 m2 / (m1 + m2)
  ExpectClose(body.m, 4000);
  ExpectClose(body.x, 1.5);
  ExpectClose(body.y, 0.375);
  ExpectClose(body.h, 0.75);
  ExpectClose(body.I_x, 3000 * (4.0 + 1.0) / 12 + reduced * (0.25 + 1));
  ExpectClose(body.I_z, 3000 * (4.0 + 16.0) / 12 + reduced * (0.25 + 4));
  ExpectClose(body.I_xz, reduced * 2 * 1);
}

TEST(Inertia, MirroredFreightGivesTheMirroredBody) {
  const WagonData wagon = Hbbills();
  FreightBox box{.name = "coil", .mass = 9000, .length = 1.8, .width = 1.4, .height = 1.6, .x = 3, .y = 0.4};
  const BodyInertia one = CalcBodyInertia(wagon, FreightOf(box));
  box.x = -box.x;
  box.y = -box.y;
  const BodyInertia other = CalcBodyInertia(wagon, FreightOf(box));
  ExpectClose(other.x, -one.x);
  ExpectClose(other.y, -one.y);
  ExpectClose(other.I_x, one.I_x);
  ExpectClose(other.I_z, one.I_z);
  ExpectClose(other.I_xz, -one.I_xz);
  EXPECT_GT(one.x, 1);
  EXPECT_GT(std::abs(one.I_xz), 100);
}

TEST(Inertia, ManyBoxesAreTheOneTheyFill) {
  const WagonData wagon = Hbbills();
  const FreightBox whole{.name = "whole", .mass = 8000, .length = 8, .width = 2, .height = 1, .x = 1, .y = 0.1};
  Freight slices;
  slices.name = "slices";
  for (int i = 0; i < 4; ++i) {
    FreightBox slice = whole;
    slice.mass /= 4;
    slice.length /= 4;
    slice.x += 2 * i - 3;
    slices.boxes.push_back(slice);
  }
  const BodyInertia one = CalcBodyInertia(wagon, FreightOf(whole)), other = CalcBodyInertia(wagon, slices);
  ExpectClose(other.h, one.h);
  ExpectClose(other.I_x, one.I_x);
  ExpectClose(other.I_z, one.I_z);
  ExpectClose(other.I_xz, one.I_xz);
}

TEST(Inertia, PartsAddUpToTheBody) {
  const BodyInertiaTable table = CalcBodyInertiaTable(Hbbills(), ReadFreight(DataFolder() / "freight" / "water.toml"));
  double m = 0, I_x = 0, I_z = 0, moment = 0;
  for (const PartInertia& part : table.parts) {
    m += part.mass;
    I_x += part.I_x;
    I_z += part.I_z;
    moment += part.mass * (part.z - table.body.h);
  }
  ExpectClose(m, table.body.m);
  ExpectClose(I_x, table.body.I_x);
  ExpectClose(I_z, table.body.I_z);
  EXPECT_NEAR(moment, 0, 1e-13 * m);  // heights of order 1 m
  EXPECT_TRUE(table.parts.back().freight);
}

TEST(Inertia, CornerLoadsCarryTheBodyInBalance) {
  const WagonData wagon = Hbbills();
  const BodyInertia body{.m = 20000, .x = 0.5, .y = -0.1};
  const auto [fl, fr, rl, rr] = CalcCornerLoads(wagon, body);
  const double weight = body.m * wagon.g;
  ExpectClose(fl + fr + rl + rr, weight);
  ExpectClose(wagon.l * (fl + fr - rl - rr), weight * body.x);
  ExpectClose(wagon.b * (fl + rl - fr - rr), weight * body.y);
}

TEST(Inertia, NeedsParts) { EXPECT_THROW(CalcBodyInertia(WagonData{}, {}), std::invalid_argument); }

// --- files ---

TEST(WagonFile, KeepsTheSpringContinuous) {
  const WagonData wagon = Hbbills();
  EXPECT_NEAR(wagon.parabolic.k1(), 653418, 0.5);  // corrections.md 3, rounded to the newton per metre
  EXPECT_EQ(wagon.guidance.longitudinal.clearance, 0.0225);
  EXPECT_EQ(wagon.guidance.lateral.clearance, 0.020);
  EXPECT_EQ(wagon.guidance.lateral.k, 1.5e6);
}

/// The shipped file with one change, which must be there.
std::string Changed(const std::string& from, const std::string& to) {
  std::string text = ReadFileWhole(DataFolder() / "wagons" / "hbbills311.toml");
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string FaultOf(const std::string& text) {
  try {
    ParseWagonData(text, "wagon.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(WagonFile, NamesEveryFaultWithItsLine) {
  EXPECT_EQ(FaultOf(Changed("g = 9.82", "g = 9.82")), "none");
  EXPECT_THAT(FaultOf(Changed("m = 1022.0", "m = -1022.0")), HasSubstr("expected 10 <= m <= 1000000 [kg], found -1022"));
  EXPECT_THAT(FaultOf(Changed("mu0 = 0.2", "mu0 = 1.0")), HasSubstr("mu0"));
  EXPECT_THAT(FaultOf(Changed("[leaf]", "[leaves]")), HasSubstr("expected a table [leaf]"));
  EXPECT_THAT(FaultOf(Changed("point = [0.0, 2.615]", "point = [0.0]")), HasSubstr("expected a pair [y, z]"));
  EXPECT_THAT(FaultOf(Changed("point = [0.0, 2.615]\n", "")), HasSubstr("expected one of point, line and area"));
  EXPECT_THAT(FaultOf(Changed("line = [[0.0, 0.265], [0.0, 2.615]]", "line = [[0.0, 0.265], [0.0, 0.265]]")),
              HasSubstr("expected corners that differ"));
  EXPECT_THAT(FaultOf(Changed(", [4.803, 0.0]]", "]")), HasSubstr("expected 4 places as in at, found 3"));
  EXPECT_THAT(FaultOf(Changed("[0.0, 2.0, 1.0, 2.0, 0.0]", "[1.0]")), HasSubstr("each of the 5 pieces"));
  const std::string both = FaultOf(Changed("b = 1.074", "b = 0.0\nc = 3"));
  EXPECT_THAT(both, HasSubstr("0.1 <= b <= 10"));
  EXPECT_THAT(both, HasSubstr("\"c\""));
}

TEST(FreightFile, ReadsEvenFreightAndBoxes) {
  const Freight freight = ParseFreight(
      "name = \"coils\"\nsource = \"list\"\n[even]\nmass = 1000.0\ndensity = 500.0\n"
      "[[boxes]]\nmass = 5.0\nlength = 1.0\nwidth = 2.0\nheight = 0.5\nx = -3.0\n",
      "f.toml");
  const CargoSpace cargo{.floor = 0.2, .length = 10, .width = 2, .height = 2, .ridge_height = 3, .ridge_width = 1};
  const std::vector<FreightBox> boxes = PlaceFreight(freight, cargo);
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_DOUBLE_EQ(boxes[0].height, 0.1);
  EXPECT_DOUBLE_EQ(boxes[0].length, 10);
  EXPECT_DOUBLE_EQ(boxes[1].x, -3);
  EXPECT_EQ(boxes[1].name, "box 1");
}

TEST(FreightFile, NamesEveryFault) {
  try {
    ParseFreight("name = \"x\"\nsource = \"y\"\n[[boxes]]\nmass = 0.0\nlength = -1.0\nwidth = 1.0\nhieght = 1.0\n",
                 "f.toml");
    FAIL() << "no fault found";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("f.toml:4"));
    EXPECT_THAT(error.what(), HasSubstr("f.toml:5"));
    EXPECT_THAT(error.what(), HasSubstr("hieght"));
  }
}

TEST(Freight, ThatDoesNotFitIsTold) {
  const CargoSpace cargo{.floor = 0, .length = 10, .width = 2, .height = 2, .ridge_height = 3, .ridge_width = 1};
  EXPECT_THAT(CheckFreight(FreightOf({.name = "b", .mass = 1, .length = 10, .width = 1, .height = 3}), cargo),
              IsEmpty());
  EXPECT_THAT(CheckFreight(FreightOf({.name = "b", .mass = 1, .length = 10.1, .width = 1, .height = 1}), cargo),
              ElementsAre("b stands 50 mm over the end of the floor"));
  EXPECT_THAT(CheckFreight(FreightOf({.name = "b", .mass = 1, .length = 1, .width = 2, .height = 2.1}), cargo),
              ElementsAre("b stands 100 mm through the roof"));
  // Half-way down the slope of the roof it has 2.5 m.
  EXPECT_THAT(
      CheckFreight(FreightOf({.name = "b", .mass = 1, .length = 1, .width = 1, .height = 2.6, .y = 0.25}), cargo),
      ElementsAre("b stands 100 mm through the roof"));
  EXPECT_THAT(CheckFreight(FreightOf({.name = "b", .mass = 1, .length = 1, .width = 1, .height = 1, .y = -0.6}), cargo),
              ElementsAre("b stands 100 mm through a side wall"));
}

TEST(InertiaReport, TellsUnevenFreightAndTipping) {
  const WagonData wagon = Hbbills();
  const std::vector<Freight> coil{
      FreightOf({.name = "coil", .mass = 9000, .length = 2, .width = 1, .height = 1, .x = 3})};
  EXPECT_THAT(FormatInertiaReport(wagon, coil), HasSubstr("centre of mass +1197 mm ahead and +0 mm left"));
  const std::vector<Freight> tips{
      FreightOf({.name = "lump", .mass = 9e4, .length = 1, .width = 1, .height = 1, .x = 7})};
  EXPECT_THAT(FormatInertiaReport(wagon, tips), HasSubstr("would tip"));
  EXPECT_THROW(FormatInertiaReport(wagon, {}), std::invalid_argument);
}

TEST(InertiaReport, JsonUsesTheWordsOfTheOptions) {
  WagonInputs inputs;
  inputs.data = Hbbills();
  inputs.choice.inertia.partitions = Partitions::kSpread;
  const std::vector<Freight> coil{FreightOf({.name = "coil", .mass = 9000, .length = 2, .width = 1, .height = 1})};
  const nlohmann::json json = nlohmann::json::parse(FormatInertiaJson(inputs, coil));
  EXPECT_EQ(json.at("schema"), "wagon-inertia/1");
  EXPECT_EQ(json.at("partitions"), "spread");
  EXPECT_EQ(json.at("com"), "corrected");
  EXPECT_EQ(json.at("partitions"), json.at("inputs").at("options").at("partitions"));
  EXPECT_EQ(json.at("freights").at(0).at("total_mass_kg"), 13563 + 9000);
  EXPECT_THROW(FormatInertiaJson(inputs, {}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
