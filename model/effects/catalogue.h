#pragma once

#include "model/effect.h"

namespace uiclink {

// The effects of the catalogue, one file each. A new one is its file and a line in catalogue.def.
#define UICLINK_EFFECT(name) const Effect& name##Effect();
#include "model/effects/catalogue.def"
#undef UICLINK_EFFECT

}  // namespace uiclink
