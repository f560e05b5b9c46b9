#pragma once

#include <span>
#include <string>

#include "model/effect.h"

namespace uiclink {

/// The catalogue of effects for a terminal of 100 columns: what each is, its equation and parameters, what to look for,
/// what it is taken for and what separates it, or why a displacement record cannot show it.
std::string FormatEffects(std::span<const Effect* const> effects);

/// The same as JSON of schema "identify-effects/1". A bound or a neutral value that is infinite is null.
std::string FormatEffectsJson(std::span<const Effect* const> effects);

}  // namespace uiclink
