#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/integrator.h"

namespace uiclink {

/// Points of a run on the section  x[place] = middle, rising: times, and what the wagon looks like there.
///
/// A passage counts once the motion has been `band` below the middle since the last one, so that a ripple on the middle
/// is not taken for a cycle. The moment is found on the integrator's own interpolation between steps, to rounding.
class SectionWatch {
 public:
  /// Coordinates of a point: lateral displacement and yaw of both wheelsets, yaw and roll of the body.
  static constexpr std::size_t kCoordinates = 6;

  SectionWatch(std::size_t place, double middle, double band) : place_(place), middle_(middle), band_(band) {}

  /// After every step.
  void Add(const Integrator& integrator);

  const std::vector<double>& times() const { return times_; }
  Eigen::MatrixXd Points() const;  ///< a column a passage
  /// Half of peak to peak of the coordinates, at the ends of steps.
  Eigen::VectorXd CalcHalfWidths() const;

 private:
  using Point = std::array<double, kCoordinates>;

  void AddPassage(const Integrator& integrator);

  std::size_t place_;
  double middle_, band_;
  bool armed_ = false;
  std::vector<double> times_;
  std::vector<Point> points_;
  Point least_{}, greatest_{};
  bool begun_ = false;
};

/// Places of the coordinates in the state vector.
extern const std::array<std::size_t, SectionWatch::kCoordinates> kSectionPlaces;

}  // namespace uiclink
