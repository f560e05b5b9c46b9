#pragma once

#include <array>
#include <cstddef>
#include <iosfwd>
#include <random>
#include <string>
#include <vector>

#include "vehicle/contact/contact_table.h"
#include "vehicle/wagon.h"

namespace uiclink {

// Wagons, contact tables and states for tests. Made by hand and by formulas: no file is read.

/// A contact table from smooth formulas: worn tread, flange from 6.5 mm on, rows of 0.1 mm from -10 to 10 mm; z_lift is
/// even, phi_roll odd. With jumps the contact moves 8 mm to the flange side at 0.23 mm and 3 mm more at 5.04 mm, with
/// new radius, angle and ellipse; z_lift and phi_roll pass both places smoothly.
ContactTable MakeSampleTable(bool jumps);

/// Cylinders on level rails: contact angle, lift and roll are zero, everything else is constant, c11 = 4.2, c22 = 3.7,
/// c23 = 1.5, a_e = 6 mm, b_e = 4 mm and q0 = 70 um under n0 = 40 kN.
ContactTable MakeCylinderTable();

/// How links of a sample are made.
enum class SampleLinks {
  kPlain,     ///< one slider lateral, four longitudinal, different at each corner
  kAlike,     ///< the same at all corners: the wagon is its own mirror image
  kExtended,  ///< with viscous damping, quadratic drag and cubic stiffness: force not affine between events
};

struct WagonSample {
  std::string name;
  bool jumps = false;
  bool loaded = false;
  bool off_centre = false;  ///< the freight lies ahead and to the left
  SampleLinks links = SampleLinks::kPlain;
  WagonOptions options;
};
void PrintTo(const WagonSample& sample, std::ostream* out);  ///< its name, for GoogleTest

/// Every option at least twice, in different company.
std::vector<WagonSample> WagonSamples();
Wagon MakeWagon(const WagonSample& sample);
Wagon MakeWagon(const WagonSample& sample, const ContactTable& table);

/// Where a random state lies.
enum class Region {
  kTread,   ///< both wheelsets within 5 mm, guides free
  kFlange,  ///< 5 to 9.5 mm to either side
  kJump,    ///< where the contact of a wheel jumps; on the tread if it never does
  kLifted,  ///< up to 0.3 mm above the touching height, rolled: none, one or both wheels in the air
  kGuides,  ///< wheelsets against guides in both directions
};
inline constexpr std::array kRegions{Region::kTread, Region::kFlange, Region::kJump, Region::kLifted, Region::kGuides};

/// Random states of a wagon, joints sticking anywhere and sliding. The same seed gives the same states.
class RandomStates {
 public:
  explicit RandomStates(unsigned seed) : random_(seed) {}

  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  /// +-size, with a size spread evenly over three powers of ten: creep from its linear range to full sliding.
  double Spread(double size);

  WagonState Draw(const Wagon& wagon, double V, Region region);

 private:
  void DrawWheelset(const Wagon& wagon, double V, Region region, std::size_t axle, StateVector<double>* x);
  double DrawDisplacement(const ContactCurve& curve, Region region);
  void DrawBody(Region region, StateVector<double>* x);
  LinkState DrawLink(const Link& link, double d, double v);

  std::mt19937 random_;
};

/// Whether motion i of a state is to the left, or a roll or yaw: it changes its sign in a mirror at the wagon's middle
/// plane.
bool ChangesSignInMirror(std::size_t i);

/// The state as a mirror at the wagon's vertical middle plane shows it, of a wagon whose left corners are made like its
/// right ones. Forces of joints are taken over: the modes of the links follow.
WagonState Mirror(const Wagon& wagon, const WagonState& state);
StateVector<double> Mirror(const StateVector<double>& x);

}  // namespace uiclink
