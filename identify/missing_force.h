#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/force_dependence.h"
#include "identify/force_series.h"

namespace uiclink {

/// The force that a link lacks, seen along measured motions, and what it depends on.
///
///   f(t) = y''/g + k y - sum T_i  [-],  per unit load M g, positive towards positive y; see ForceSeries.
///
/// Fitted values of k, k_i, T0i and the sensor's zero have already taken up what they can of any missing force, so it
/// is never seen whole: a constant, a straight line over displacement and a change of the sliders' own forces are not
/// there to be found. Everything that is judged here is freed from these directions, record by record.
///
/// Forces only: a disturbance of the reading (hum, drift, a second mode) appears as the force that would have moved the
/// mass like that.
struct MissingForce {
  struct Sample {
    double t, y, v;  ///< since the first free extremum [s], displacement [m], velocity [m/s]; smoothed
    double f;        ///< missing force, mean of about a tenth of a second [-]
    double left;     ///< f less what the link's parameters can absorb [-]
    double error;    ///< standard deviation of f [-]
  };
  std::vector<std::vector<Sample>> records;  ///< half a window apart and more: nearly independent; empty: not usable

  /// Links along whose sliders' forces f is seen, one per record: those given, or where something is missing those that
  /// fit the forces best beside what is named (see AnalyseForce).
  std::vector<Oscillator<double>> links;

  struct Cell {
    double y, v;      ///< middle [m], [m/s]
    double f, error;  ///< mean of `left` over the windows, and its error with their correlation [-]
    int count;        ///< windows
  };
  std::vector<Cell> map;  ///< over displacement and velocity; cells that the motion never meets are left out

  struct Bin {
    double at;     ///< [m], [m/s] or [s]
    double f;      ///< value of a piecewise linear function fitted to all windows, not blurred by them [-]
    double error;  ///< its standard deviation, times the root of DependenceSearch::dispersion [-]
    int count;     ///< windows nearer to this bin than to its neighbours
  };
  /// Beside the named dependences of another kind. over_y is known up to a
  /// straight line and over_v, over_t up to a constant: chosen so that over_y is zero at as many places as can be and
  /// the others have the smallest values.
  std::vector<Bin> over_y, over_v, over_t;
  std::vector<Bin> stiffness_over_t;  ///< change of k that y h(t) would be [1/m], up to a constant

  /// Shares of the weighted variance of f beyond noise that a function of one thing alone explains, 0..1. They overlap:
  /// a dry friction is also a function of velocity. 0 where there is nothing beyond noise.
  double share_of_y = 0, share_of_v = 0, share_of_sign_v = 0, share_of_t = 0, share_of_stiffness_in_t = 0,
         share_of_modulated_stiffness = 0;
  DependenceSearch search;
  int dof = 0;              ///< windows less what the links absorb
  double p_value = 1;       ///< of there being nothing but noise
  double dry_friction = 0;  ///< T_r when all of it were -T_r sign(y'), and its error [-]
  double dry_friction_error = 0;
  double viscous = 0;  ///< c when all of it were -c y', and its error [s/m]
  double viscous_error = 0;
  double smallest_seen =
      0;  ///< force at one displacement that stands out by three errors; median over displacement [-]

  /// For the report: "depends on displacement: a force of up to 0.0007 M g, largest between 9 and 13 mm, on both sides
  /// of zero; not on velocity or time".
  std::string words;

  bool IsSignificant() const { return !search.named.empty() || p_value < kFalseAlarm; }
};

/// Never throws for what is in the records; a record that is too short is left out of everything.
MissingForce FindMissingForce(std::span<const MissingForceInput> records);

/// What a missing force depends on, as MissingForce::words. @param k  mean stiffness of the links [1/m].
std::string DescribeMissingForce(const MissingForce& force, double k);

}  // namespace uiclink
