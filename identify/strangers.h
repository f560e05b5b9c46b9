#pragma once

#include "identify/identification.h"

namespace uiclink {

/// Leaves out prepared records that belong to another link or direction: k + sum k_i, from the rolling frequency,
/// differs from the median of the records by more than a fifth and by far more than the others scatter among themselves
/// (re-seated links: 2-3 %). Takes three records that agree; where fewer do, a warning says that they differ.
void LeaveOutStrangers(Identification* result);

}  // namespace uiclink
