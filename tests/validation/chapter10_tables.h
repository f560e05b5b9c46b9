#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>

#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_inputs.h"

/// What chapter 10 of the thesis publishes, and what this program makes of it: the rows of chapter10.md. The tests
/// measure `ours` again, within `tolerance`; that the page holds the rows is a test too.
namespace uiclink::chapter10 {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
enum Geometry : std::size_t { kThesisEquivalent, kNominal, kGeometries };
inline constexpr std::array<const char*, kGeometries> kGeometryNames{"thesis-equivalent", "nominal-1435"};

/// A wagon as the thesis computes it: its inertias and centre of mass as printed.
inline WagonChoice Choice(Geometry geometry, const char* set, const char* cargo) {
  WagonChoice choice;
  choice.sets = {set};
  choice.cargo = cargo;
  choice.geometry = kGeometryNames[geometry];
  choice.inertia = InertiaOptions::Printed();
  return choice;
}
inline Wagon MakeWagon(Geometry geometry, const char* set, const char* cargo) {
  return uiclink::MakeWagon(ReadWagonInputs(Choice(geometry, set, cargo)));
}

struct Figure {
  const char* what;
  const char* theirs;  ///< as printed
  double published;    ///< to subtract; kNone where nothing is printed that can be compared
  std::array<double, kGeometries> ours;
  std::array<double, kGeometries> tolerance;
  double met_within = 0;  ///< > 0: on thesis-equivalent ours is theirs within this, which their digits allow
};

struct Outcome {
  const char* what;
  const char* theirs;
  std::array<const char*, kGeometries> ours;
};

/// Linear critical speeds [m/s].  Tolerance: the speeds move by 1.5e-5 when the contact table is made twice as fine and
/// are located to 1e-6; 5e-3 leaves the contact's interpolation some freedom and sees 1 um of gauge.
inline constexpr double kSpeedTolerance = 5e-3;
inline constexpr std::array<double, 2> kSpeedTolerances{kSpeedTolerance, kSpeedTolerance};
inline constexpr Figure kCritical[] = {
    {"set 1 empty, eigenvalues", "18.4", 18.4, {18.400, 10.029}, kSpeedTolerances, 0.05},
    {"set 1 water", "under 23 (ramp)", kNone, {19.882, 10.699}, kSpeedTolerances},
    {"set 1 packed", "about 25 (ramp)", kNone, {19.425, 10.263}, kSpeedTolerances},
    {"set 2 empty", "-", kNone, {28.279, 14.874}, kSpeedTolerances},
    {"set 2 water", "-", kNone, {29.719, 15.137}, kSpeedTolerances},
    {"set 2 packed, eigenvalues", "33.7", 33.7, {34.283, 16.993}, kSpeedTolerances},
};

/// Hunting from the running equilibrium with both wheelsets 0.1 mm aside, 150 s, figures of the last 20 s.
/// Tolerance of a frequency: a fifth of a line (0.05 Hz) of the spectrum; integration at 1e-7 instead of 1e-6 moves
/// them by less than 0.002 Hz. Of nominal-1435 in this state the longitudinal motion does not repeat: not kept; set 2
/// empty settles at 1.71 or 1.73 Hz.
struct HuntingRow {
  const char* set;
  const char* cargo;
  double V;
  Figure lateral, longitudinal;
};
inline constexpr double kLine = 0.01;
inline constexpr HuntingRow kHunting[] = {
    {"set1",
     "empty",
     24,
     {"set 1 empty, 24 m/s: lateral, yaw, roll", "1.07", 1.07, {1.065, 1.114}, {kLine, kLine}, 0.01},
     {"longitudinal, highest line", "2.14, 4.28", 2.14, {3.191, kNone}, {3 * kLine, 0}}},
    {"set1",
     "water",
     24,
     {"set 1 water, 24 m/s: lateral, yaw, roll", "1.04", 1.04, {1.106, 1.213}, {kLine, kLine}},
     {"longitudinal, highest line", "2.07, 4.15", 4.15, {4.421, kNone}, {4 * kLine, 0}}},
    {"set1",
     "packed",
     24,
     {"set 1 packed, 24 m/s: lateral, yaw, roll", "0.96", 0.96, {0.961, 1.215}, {kLine, kLine}, 0.01},
     {"longitudinal, highest line", "1.93, 3.86, 5.30", 5.30, {5.24, kNone}, {0.05, 0}, 0.1}},
    {"set2",
     "empty",
     38,
     {"set 2 empty, 38 m/s: lateral, yaw, roll", "1.36", 1.36, {1.429, 1.73}, {kLine, 3 * kLine}},
     {"longitudinal, highest line", "2.7, 3.9", 2.7, {2.859, kNone}, {2 * kLine, 0}}},
    {"set2",
     "water",
     38,
     {"set 2 water, 38 m/s: lateral, yaw, roll", "1.31", 1.31, {1.397, 1.883}, {kLine, kLine}},
     {"longitudinal, highest line", "2.6, 5.2, 6.1", 5.2, {5.589, kNone}, {4 * kLine, 0}}},
    {"set2",
     "packed",
     38,
     {"set 2 packed, 38 m/s: lateral, yaw, roll", "1.46", 1.46, {1.488, 1.889}, {kLine, kLine}},
     {"longitudinal, highest line", "2.9, 5.8", 5.8, {5.956, kNone}, {4 * kLine, 0}}},
};

/// Set 1 empty, followed down from hunting at 25 m/s in steps of 0.05 m/s and 5 s, as the thesis does. Tolerance of a
/// speed: ten steps; a trace is late by several of them, and by how many depends on where it comes from.
inline constexpr double kTraceTolerance = 0.5;
inline constexpr Figure kTrace[] = {
    {"set 1 empty: rear wheelset hits its guidance from", "above 20", kNone, {17.15, kNone}, {kTraceTolerance, 0}},
    {"set 1 empty: front wheelset hits too from", "just under 14", kNone, {11.80, kNone}, {kTraceTolerance, 0}},
    {"set 1 empty: hunting dies at", "about 9", 9, {8.80, 5.15}, {kTraceTolerance, 2 * kTraceTolerance}, 0.5},
    {"set 1 empty, 20 m/s: lateral, peak to peak [mm]", "about 4", 4, {4.37, kNone}, {0.1, 0}},
    {"set 1 water: hunting dies at", "just over 9", 9, {9.90, kNone}, {kTraceTolerance, 0}},
    {"set 1 packed: motion of 0.96 Hz lost at", "about 17", 17, {21.70, kNone}, {kTraceTolerance, 0}},
    {"set 2 empty: hunting dies at", "-", kNone, {19.10, kNone}, {kTraceTolerance, 0}},
};
enum TraceRow { kRearFrom, kFrontFrom, kDies, kPeakToPeak, kWaterDies, kPackedLost, kSet2Dies };

/// Which wheelsets hit their lateral guidance within 20 s, after 60 s at that speed on the way down.
struct ImpactRow {
  double V;
  Outcome outcome;
};
inline constexpr ImpactRow kImpacts[] = {
    {20, {"set 1 empty, 20 m/s", "rear", {"none", "none"}}},   {15, {"set 1 empty, 15 m/s", "rear", {"rear", "none"}}},
    {13, {"set 1 empty, 13 m/s", "both", {"rear", "none"}}},   {11, {"set 1 empty, 11 m/s", "both", {"both", "none"}}},
    {9.5, {"set 1 empty, 9.5 m/s", "both", {"rear", "none"}}},
};
inline constexpr Outcome kOtherOutcomes[] = {
    {"set 1 empty, 40 m/s", "none", {"none", "none"}},
    {"set 2 empty, 38 to 19 m/s", "none", {"none", "-"}},
    {"set 1 empty without guidance, 20 m/s: a wheel lifts", "yes", {"no", "-"}},
    {"set 1 empty without guidance, 15 m/s: a wheel lifts", "-", {"yes", "-"}},
    {"longitudinal impacts in all these runs", "none", {"none", "none"}},
};

/// The same wagon on elastic contact under its own load, 38 kN a wheel, with the rails moved until set 1 empty has 18.4
/// m/s again: not a geometry file, but the contact that a table for the loaded wheel would hold.
inline constexpr double kElasticLoad = 38e3;         // [N]
inline constexpr double kElasticOffset = 1.9884e-3;  // [m]
struct ElasticRow {
  double V;
  const char* what;
  const char* theirs;
  const char* rigid;
  const char* ours;
};
inline constexpr ElasticRow kElasticImpacts[] = {
    {20, "set 1 empty, 20 m/s", "rear", "none", "rear"},
    {15, "set 1 empty, 15 m/s", "rear", "rear", "rear"},
    {13, "set 1 empty, 13 m/s", "both", "rear", "rear"},
    {11, "set 1 empty, 11 m/s", "both", "both", "both"},
};
inline constexpr std::array<double, 3> kElasticLines{1.060, 2.120, 4.238};  ///< at 24 m/s: lateral; longitudinal [Hz]

inline std::string FormatNumber(double x, const char* format) {
  if (std::isnan(x)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, format, x);
  return text;
}
/// "| what | theirs | ours | difference | ours | difference |"
inline std::string FormatRow(const Figure& f, const std::array<double, kGeometries>& ours) {
  std::string row = std::string("| ") + f.what + " | " + f.theirs;
  for (double x : ours) {
    const double percent = 100 * (x - f.published) / f.published;
    row += " | " + FormatNumber(x, "%.3f") + " | " + FormatNumber(percent, "%+.1f %%");
  }
  return row + " |";
}
inline std::string FormatRow(const Outcome& o) {
  return std::string("| ") + o.what + " | " + o.theirs + " | " + o.ours[0] + " | " + o.ours[1] + " |";
}

/// The figure has not moved, and theirs is met where it was.
inline void Keep(const Figure& figure, Geometry geometry, double measured) {
  EXPECT_NEAR(measured, figure.ours[geometry], figure.tolerance[geometry])
      << figure.what << ", " << kGeometryNames[geometry];
  if (geometry == kThesisEquivalent && figure.met_within > 0) {
    EXPECT_NEAR(measured, figure.published, figure.met_within) << figure.what << ": no longer what is published";
  }
}

inline const char* NameImpacts(const SimulationResult& run) {
  const bool front = run.lateral[0].impacts_in_window.count > 0;
  const bool rear = run.lateral[1].impacts_in_window.count > 0;
  return front && rear ? "both" : rear ? "rear" : front ? "front" : "none";
}
inline int CountLongitudinal(const SimulationResult& run) {
  return run.longitudinal[0].impacts.count + run.longitudinal[1].impacts.count;
}

inline const MotionFigures& Motion(const SimulationResult& run, TrackedMotion motion) {
  return run.motions[static_cast<std::size_t>(motion)];
}
inline double HighestLine(const SimulationResult& run, TrackedMotion motion) {
  const MotionFigures& figures = Motion(run, motion);
  return figures.frequencies.empty() ? 0 : figures.frequencies.front();
}

/// The run that a row of kHunting is about.
inline SimulationResult SimulateHunting(const HuntingRow& row, Geometry geometry) {
  const Wagon wagon = MakeWagon(geometry, row.set, row.cargo);
  SimulationOptions options;
  options.duration = 150;
  options.window = 20;
  const WagonState start = Perturb(wagon, FindEquilibrium(wagon, row.V), {.front_y = 1e-4, .rear_y = 1e-4});
  return Simulate(wagon, row.V, start, options);
}

}  // namespace uiclink::chapter10
