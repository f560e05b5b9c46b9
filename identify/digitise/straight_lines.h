#pragma once

#include "identify/digitise/inks.h"

namespace uiclink::digitise {

/// Fills inks->level_lines and upright_lines: rows and columns that hold more ink than their neighbours in at least
/// four of five parts of the frame's width or height (half of them without a frame). So a dotted grid counts, and a
/// curve that has come to rest in the last part of the record does not.
void FindStraightLines(const Page& page, Inks* inks);

}  // namespace uiclink::digitise
