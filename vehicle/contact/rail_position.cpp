#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "vehicle/contact/contact_search.h"
#include "vehicle/contact/profile_file.h"

namespace uiclink {
namespace {

constexpr double kStep = 0.1e-3;               // [m] of the coarse search for top and gauge face
constexpr double kFartherThanPoints = 0.1e-3;  // [m] a file of points may end this little above the gauge face

/// Where `value(y)` turns from negative (at `low`) to not negative (at `high`): bisection to rounding.
template <typename Function>
double FindSignChange(const Function& value, double low, double high) {
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (value(middle) < 0 ? low : high) = middle;
  }
  return high;
}

double FindHighestPoint(const Profile& rail) {
  double highest = rail.y_min();
  for (double y = rail.y_min(); y <= rail.y_max(); y += kStep) {
    if (rail.Eval(y).z > rail.Eval(highest).z) highest = y;
  }
  const double low = std::max(highest - kStep, rail.y_min());
  const double high = std::min(highest + kStep, rail.y_max());
  return FindSignChange([&](double y) { return -rail.Eval(y).slope; }, low, high);
}

double FindGaugeFace(const Profile& rail, double y_top, double depth) {
  const double z_gauge = rail.Eval(y_top).z - depth;
  double y = y_top;
  while (y > rail.y_min() && rail.Eval(y).z > z_gauge) y = std::max(y - kStep, rail.y_min());
  const ProfilePoint last = rail.Eval(y);
  if (last.z > z_gauge) {
    if (last.z - z_gauge > kFartherThanPoints) {
      throw std::invalid_argument("rail " + rail.name() + ": the profile ends " +
                                  std::to_string(1e3 * (last.z - z_gauge)) + " mm above the gauge face");
    }
    return y - (last.z - z_gauge) / last.slope;
  }
  return FindSignChange([&](double at) { return rail.Eval(at).z - z_gauge; }, y, std::min(y + kStep, y_top));
}

Profile LoadProfile(const std::string& name, ProfileKind kind, const ProfileAxes& axes, double smoothing) {
  if (const Profile* standard = FindStandardProfile(name)) return *standard;
  return ReadProfile(name, kind, smoothing, axes);
}

}  // namespace

Profile PlaceRail(const Profile& rail, const TrackGeometry& geometry) {
  const double angle = std::atan(geometry.cant);
  const Profile canted = rail.Moved(angle, 0, 0);
  const double y_top = FindHighestPoint(canted);
  const double y_gauge = FindGaugeFace(canted, y_top, geometry.gauge_depth);
  return rail.Moved(angle, geometry.gauge / 2 + geometry.rail_offset - y_gauge, -canted.Eval(y_top).z);
}

Profile LoadWheelProfile(const TrackGeometry& geometry) {
  return LoadProfile(geometry.wheel, ProfileKind::kWheel, geometry.wheel_axes, geometry.profile_smoothing);
}

Profile LoadRailProfile(const TrackGeometry& geometry) {
  return LoadProfile(geometry.rail, ProfileKind::kRail, geometry.rail_axes, geometry.profile_smoothing);
}

}  // namespace uiclink
