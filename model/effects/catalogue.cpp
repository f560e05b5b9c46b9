#include "model/effects/catalogue.h"

#include <array>

namespace uiclink {

std::string_view Name(ActsOn acts_on) {
  switch (acts_on) {
    case ActsOn::kForce:
      return "force";
    case ActsOn::kFrictionLaw:
      return "friction law";
    case ActsOn::kStiffness:
      return "stiffness";
    case ActsOn::kMeasurement:
      return "measurement";
  }
  return "";
}

std::span<const Effect* const> Effects() {
  static const std::array effects = {
#define UICLINK_EFFECT(name) &name##Effect(),
#include "model/effects/catalogue.def"
#undef UICLINK_EFFECT
  };
  return effects;
}

const Effect* FindEffect(std::string_view id) {
  for (const Effect* effect : Effects())
    if (effect->id == id) return effect;
  return nullptr;
}

}  // namespace uiclink
