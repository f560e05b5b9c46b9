#pragma once

#include <vector>

#include "vehicle/reproduce/item.h"

namespace uiclink::reproduce {

// Parts of Items(), in the order of the chapter.
std::vector<Item> ListMethodItems();        ///< 10.1
std::vector<Item> ListSetOneSpeedItems();   ///< 10.2.1
std::vector<Item> ListSetOneImpactItems();  ///< 10.2.2
std::vector<Item> ListSetTwoItems();        ///< 10.3
std::vector<Item> ListSpectrumItems();      ///< 10.4

/// Both wheelsets beside the running equilibrium, to the left.
inline constexpr const char* kSmallPush = "front_lateral=0.1mm, rear_lateral=0.1mm";
inline constexpr const char* kLargePush = "front_lateral=5mm, rear_lateral=5mm";

}  // namespace uiclink::reproduce
