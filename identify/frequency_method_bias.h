#pragma once

#include <span>

#include "identify/symptoms.h"

namespace uiclink {

/// The published frequency method against the fit: "frequency_method_bias", a bias of the method (of_model is false).
/// The mean of k over all arcs of all records beside what the fitted link has; its error is the scatter of the arcs
/// about the closed form of the bias (CalcPublishedBias).
void FindFrequencyMethodBias(std::span<const SymptomInput> records, Symptoms* symptoms);

}  // namespace uiclink
