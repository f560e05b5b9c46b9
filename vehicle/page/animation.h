#pragma once

#include <string>

#include "reports/html_page.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// The last seconds of a run seen from above, to play (wagon_view.js): body, wheelsets, links, guides and flanges, what
/// is touched lit up. Nothing where the run has too few samples.
/// @param id  of its element, as HtmlPage::Chart's.
void InsertAnimation(const SimulationResult& result, const Wagon& wagon, const WagonInputs& inputs,
                     const std::string& id, HtmlPage* page);

/// What it draws, as JSON: { "wagon", "hz", "begin", "frames": { "front_x": [...], ... }, "touches": [...] }. Motions
/// in steps of 1e-5 m and 1e-6 rad. Bits of a touch: 4 a corner for its guides to the left, to the right, ahead,
/// behind; from bit 16 on the flanges, by wheel. Empty where there are too few samples.
std::string FormatAnimation(const SimulationResult& result, const Wagon& wagon, const WagonInputs& inputs);

/// Lateral displacement at which the left flange meets its rail: where the contact angle passes 30 degrees [m]; 0 where
/// the table does not reach so far.
double FindFlangePlay(const ContactTable& table);

}  // namespace uiclink
