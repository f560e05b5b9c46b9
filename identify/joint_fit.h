#pragma once

#include "identify/identification.h"

namespace uiclink {

/// Do the records share k, sum k_i and sum T0i?  Needs the records' own fits.
///
/// Weighted sum of squares of their distances from the common value, chi-square with 3 (R - 1) degrees of freedom if
/// they do. The weights are those of the noise, also where the model lacks something: what it lacks is much the same in
/// every record and would otherwise hide the scatter.
SharingTest TestSharing(const Identification& result);

/// Fits all used records of a direction together and fills in everything of `result` that belongs to all of them: link,
/// quantities with bounds, covariance, what is not determined, rms. One link for all where `result->shared`; otherwise
/// the links of the records' own fits, described by mean and spread. With several sliders a narrow rejection of the
/// shared link is checked by the likelihood ratio of both, and taken back where that has no objection.
void FitJointly(int threads, Identification* result);

}  // namespace uiclink
