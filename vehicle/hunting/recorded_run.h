#pragma once

#include <cstddef>
#include <vector>

#include "vehicle/wagon.h"

namespace uiclink {

/// A run step by step, as its variations need it.
struct RecordedRun {
  struct Step {
    double t0 = 0, t1 = 0;
    StateVector<double> x0{}, x1{};
    std::size_t mode = 0;  ///< in which it was made
  };
  std::vector<Step> steps;
  /// Joints of the links between events; after the last event there is one more than steps have used, if it was at the
  /// very end.
  std::vector<LinkStates> modes;

  void Clear() {
    steps.clear();
    modes.clear();
  }
};

/// Where the sliders of all links are in the memory of a wagon: longitudinal links by corner, lateral links by corner.
struct SliderPlace {
  std::size_t link = 0;  ///< 0..3 longitudinal, 4..7 lateral, by corner
  std::size_t joint = 0;
};
inline constexpr std::size_t kLinks = 2 * kCorners;
std::vector<SliderPlace> ListSliders(const Wagon& wagon);

inline const Link& LinkAt(const Wagon& wagon, std::size_t link) {
  return link < kCorners ? wagon.longitudinal[link] : wagon.lateral[link - kCorners];
}
inline const LinkState& LinkAt(const LinkStates& links, std::size_t link) {
  return link < kCorners ? links.longitudinal[link] : links.lateral[link - kCorners];
}
inline LinkState& LinkAt(LinkStates& links, std::size_t link) {
  return link < kCorners ? links.longitudinal[link] : links.lateral[link - kCorners];
}

}  // namespace uiclink
