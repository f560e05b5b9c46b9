#include "vehicle/hunting/section_watch.h"

#include <algorithm>

#include "vehicle/wagon_state.h"

namespace uiclink {

const std::array<std::size_t, SectionWatch::kCoordinates> kSectionPlaces{
    wheelset::kY,      kRearWheelset + wheelset::kY, wheelset::kPsi, kRearWheelset + wheelset::kPsi, kBody + body::kPsi,
    kBody + body::kPhi};

void SectionWatch::Add(const Integrator& integrator) {
  for (std::size_t i = 0; i < kCoordinates; ++i) {
    const double at = integrator.state().x[kSectionPlaces[i]];
    least_[i] = begun_ ? std::min(least_[i], at) : at;
    greatest_[i] = begun_ ? std::max(greatest_[i], at) : at;
  }
  begun_ = true;
  const double value = integrator.state().x[place_] - middle_;
  if (value < -band_) armed_ = true;
  if (!armed_ || value < 0) return;
  armed_ = false;
  AddPassage(integrator);
}

void SectionWatch::AddPassage(const Integrator& integrator) {
  double low = integrator.step_begin(), high = integrator.state().t;
  StateVector<double> x;
  for (int i = 0; i < 60 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    integrator.Interpolate(middle, &x);
    (x[place_] < middle_ ? low : high) = middle;
  }
  integrator.Interpolate(high, &x);
  times_.push_back(high);
  Point& point = points_.emplace_back();
  for (std::size_t i = 0; i < kCoordinates; ++i) point[i] = x[kSectionPlaces[i]];
}

Eigen::MatrixXd SectionWatch::Points() const {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(kCoordinates), static_cast<Eigen::Index>(points_.size()));
  for (std::size_t i = 0; i < points_.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::VectorXd>(points_[i].data(), static_cast<Eigen::Index>(kCoordinates));
  return points;
}

Eigen::VectorXd SectionWatch::CalcHalfWidths() const {
  Eigen::VectorXd widths(static_cast<Eigen::Index>(kCoordinates));
  for (std::size_t i = 0; i < kCoordinates; ++i)
    widths[static_cast<Eigen::Index>(i)] = 0.5 * (greatest_[i] - least_[i]);
  return widths;
}

}  // namespace uiclink
