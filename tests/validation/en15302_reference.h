#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "vehicle/contact/contact_search.h"

namespace uiclink::en15302 {

// EN 15302:2021, Annex I: reference wheels A, B, H, I and rail A, by arcs and lines in mm. The standard counts F
// downward, so an arc "c - sqrt(R^2 - ...)" of it is the upper half of a circle here.

inline constexpr double kMm = 1e-3;

/// F = centre - sqrt(R^2 - (y - y_centre)^2).
inline ProfilePiece Hollow(double from, double to, double y_centre, double centre, double radius) {
  return ProfilePiece::UpperArc(from * kMm, to * kMm, y_centre * kMm, -centre * kMm, radius * kMm);
}
/// F = centre + sqrt(R^2 - (y - y_centre)^2).
inline ProfilePiece Bulge(double from, double to, double y_centre, double centre, double radius) {
  return ProfilePiece::LowerArc(from * kMm, to * kMm, y_centre * kMm, -centre * kMm, radius * kMm);
}
/// F = constant + slope y.
inline ProfilePiece Line(double from, double to, double constant, double slope) {
  return ProfilePiece::Polynomial(from * kMm, to * kMm, 0, std::array{-constant * kMm, -slope});
}

inline Profile ReferenceRailA() {
  return Profile(
      "EN 15302 rail A",
      {Hollow(-32.6340, -23.2401, -19.63949, 15.899044, 13), Hollow(-23.2401, -7.87490, -1.08250, 80.277908, 80),
       Hollow(-7.87490, 13.09890, 17.59660, 299.483490, 300), Hollow(13.09890, 28.67090, 14.29829, 79.508225, 80),
       Hollow(28.67090, 39.27050, 26.33535, 13.598369, 13)});
}

inline Profile ReferenceWheelA() {
  return Profile(
      "EN 15302 wheel A",
      {Bulge(-70, -62.7647, -49.5, 9.51926, 20.5), Bulge(-62.7647, -49.6625, -55, 16.00065, 12),
       Bulge(-49.6625, -39.7645, -58.5583, 8.83556, 20), Line(-39.7645, -38.7372, -93.57685, -2.7475),
       Hollow(-38.7372, -29.4591, -25.5816, 17.64215, 14), Hollow(-29.4591, -10.8749, -2.6594, 97.16493, 96.76055),
       Hollow(-10.8749, 18.4173, 18.4173, 344.50806, 345), Line(18.4173, 30, -0.49194, 0),
       Line(30, 60, 1.50804, -0.066666)});
}

inline Profile ReferenceWheelB() {
  return Profile("EN 15302 wheel B",
                 {Bulge(-70, -62.7647, -49.5, 9.5193, 20.5), Bulge(-62.7647, -49.6625, -55, 16, 12),
                  Bulge(-49.6625, -39.7640, -58.5583, 8.8349, 20), Line(-39.7640, -38.7879, -93.5767, -2.7475),
                  Hollow(-38.7879, -29.3505, -25.6322, 17.7814, 14), Hollow(-29.3505, -0.4787, 2.5204, 119.9745, 120),
                  Line(-0.4787, 30, 0, -0.025), Line(30, 60, 0.75, -0.05)});
}

inline Profile ReferenceWheelH() {
  return Profile("EN 15302 wheel H",
                 {Bulge(-70, -62.7647, -49.5, 9.5193, 20.5), Bulge(-62.7647, -49.6625, -55, 16, 12),
                  Bulge(-49.6625, -39.7645, -58.5583, 8.8349, 20), Line(-39.7645, -38.7220, -93.5767, -2.7475),
                  Hollow(-38.7220, -28.3119, -25.5663, 17.6003, 14), Line(-28.3119, -10.2297, -1.7902, -0.2),
                  Line(-10.2297, 30, 0, -0.025), Line(30, 60, 1.251, -0.0667)});
}

inline Profile ReferenceWheelI() {
  const double centre = 119.89578808281798;  // sqrt(14375) mm, so that F(0) = 0
  return Profile("EN 15302 wheel I",
                 {Bulge(-70, -62.7647, -49.5, 9.51929, 20.5), Bulge(-62.7647, -49.6625, -55, 16.00054, 12),
                  Bulge(-49.6625, -39.7640, -58.5583, 8.83545, 20), Line(-39.7640, -39.0486, -93.5767, -2.7475),
                  Hollow(-39.0486, -29.9231, -25.8929, 18.49733, 14), Hollow(-29.9231, 5, 5, centre, 120),
                  Line(5, 30, centre - 120, 0), Line(30, 60, 1.89679, -0.0667)});
}

/// The zones are printed with four digits, which leaves steps of up to 0.06 um on the treads, 0.7 um on the flanges:
/// each zone is lifted or lowered to meet its neighbour, from y = 0 to both ends. Slopes stay as printed.
inline Profile MeetingZones(const Profile& profile) {
  std::vector<ProfilePiece> zones = profile.pieces();
  std::size_t middle = 0;
  while (zones[middle].y_end() < 0) ++middle;
  const auto lift = [](ProfilePiece& zone, const ProfilePiece& neighbour, double y) {
    const double step = neighbour.Eval(y).z - zone.Eval(y).z;
    zone = zone.WithLine(step, step);
  };
  for (std::size_t i = middle + 1; i < zones.size(); ++i) lift(zones[i], zones[i - 1], zones[i].y_begin());
  for (std::size_t i = middle; i-- > 0;) lift(zones[i], zones[i + 1], zones[i].y_end());
  return Profile(profile.name(), zones);
}

/// A wheel on rail A, whose axis y = 0 is 750 mm from the track centre at gauge 1435 mm; e = 1500 mm.
inline WheelOnRail OnRailA(const Profile& wheel, double r0 = 0.460) {
  return {MeetingZones(wheel), MeetingZones(ReferenceRailA()).Shifted(0.750, 0), 0.750, r0};
}

/// EN 15302:2021, Annex J: rolling radius difference [mm] at y = 0.1 mm, 0.2 mm, ... (as transcribed by
/// github.com/rohrbecka/EN15302).
struct ReferenceDifference {
  std::string wheel;
  Profile profile;
  std::vector<double> delta_r_mm;
  double misprint_mm;  ///< y at which the transcription has an error, or 0
};

inline std::vector<ReferenceDifference> ReferenceDifferences() {
  return {
      // At 1.7 mm it repeats the value of 1.8 mm.
      {"A",
       ReferenceWheelA(),
       {0.028, 0.051, 0.071, 0.093, 0.116, 0.142, 0.168, 0.197, 0.227, 0.259, 0.292, 0.327, 0.364, 0.402,
        0.442, 0.484, 0.572, 0.572, 0.619, 0.667, 0.717, 0.769, 0.822, 0.877, 0.934, 0.993, 1.053, 1.114,
        1.178, 1.243, 1.294, 1.349, 1.407, 1.469, 1.534, 1.603, 1.675, 1.751, 1.830, 1.913, 1.999, 2.089,
        2.182, 2.279, 2.379, 2.483, 2.591, 2.702, 2.817, 2.936, 3.058, 3.184, 3.314, 3.447, 3.584, 3.725,
        3.870, 4.018, 4.170, 4.327, 4.486, 4.650, 5.061, 5.688, 6.515, 7.590, 9.001, 10.940},
       1.7},
      {"B",
       ReferenceWheelB(),
       {0.005, 0.010, 0.015, 0.020, 0.025, 0.030, 0.035, 0.040, 0.045, 0.050, 0.055, 0.060, 0.065, 0.070,
        0.075, 0.080, 0.085, 0.090, 0.095, 0.100, 0.105, 0.110, 0.115, 0.120, 0.125, 0.130, 0.135, 0.140,
        0.145, 1.948, 2.001, 2.055, 2.110, 2.165, 2.222, 2.279, 2.336, 2.395, 2.454, 2.515, 2.576, 2.637,
        2.700, 2.763, 2.827, 2.892, 2.958, 3.025, 3.092, 3.160, 3.229, 3.299, 3.370, 3.441, 3.513, 3.586,
        3.660, 3.735, 3.810, 3.886, 3.963, 4.041, 4.120, 5.408, 6.132, 7.076, 8.304, 9.942, 12.319},
       0},
      // At 3.1 mm it has 1.514 on one side, 2.514 on the other.
      {"H",
       ReferenceWheelH(),
       {0.005, 0.010, 0.015, 0.020, 0.025, 0.030, 0.035, 0.040, 0.045, 0.050, 0.055, 0.060, 0.065, 0.070,
        0.075, 0.080, 0.085, 0.090, 0.095, 0.100, 0.105, 0.110, 0.115, 0.120, 0.125, 2.402, 2.424, 2.447,
        2.469, 2.492, 1.514, 2.537, 2.559, 2.582, 2.604, 2.627, 2.649, 2.672, 2.694, 2.717, 2.739, 2.762,
        2.784, 2.807, 2.829, 2.852, 2.874, 2.897, 2.919, 2.942, 2.964, 2.987, 3.009, 3.032, 3.054, 3.077,
        3.099, 3.122, 3.144, 3.167, 3.189, 3.212, 3.234, 3.257, 3.279, 3.302, 3.324, 11.199},
       3.1},
      {"I",
       ReferenceWheelI(),
       {0,     0,     0,     0,     0,     0,     0,     0,     0,     0,     0,     0,     0,     0,     0,
        0,     0,     2.353, 2.414, 2.475, 2.538, 2.601, 2.665, 2.729, 2.795, 2.861, 2.928, 2.996, 3.065, 3.134,
        3.205, 3.276, 3.348, 3.421, 3.494, 3.569, 3.644, 3.720, 3.797, 3.875, 3.953, 4.033, 4.113, 4.194, 4.276,
        4.358, 4.442, 4.526, 4.612, 4.696, 4.728, 4.761, 4.793, 4.826, 4.859, 4.892, 4.925, 4.958, 4.992, 5.025,
        5.059, 5.092, 5.126, 5.160, 5.194, 5.469, 6.075, 6.878, 7.922, 9.288, 11.150},
       0},
  };
}

}  // namespace uiclink::en15302
