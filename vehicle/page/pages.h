#pragma once

#include <complex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vehicle/contact_report.h"
#include "vehicle/element_report.h"
#include "vehicle/freight.h"
#include "vehicle/hunting/diagram_report.h"
#include "vehicle/hunting/running_spectrum_report.h"
#include "vehicle/page/wagon_book.h"
#include "vehicle/simulation_report.h"
#include "vehicle/stability_report.h"

namespace uiclink {

// The page of each command of `wagon`: the answer in a paragraph, figures, tables, and what it takes to repeat the run.
// All numbers are those of the command's JSON; nothing is computed anew but what a figure shows.

std::string ComposeSimulationPage(const SimulationRun& run, const Wagon& wagon, const PageBounds& bounds,
                                  const PageOrigin& origin);
/// @param modes  shown ones (ChooseShownModes) at speed V.
std::string ComposeStabilityPage(const StabilityRun& run, const std::vector<LinearMode>& modes, double V,
                                 const PageBounds& bounds, const PageOrigin& origin);
std::string ComposeBifurcationPage(const BifurcationRun& run, const PageBounds& bounds, const PageOrigin& origin);
std::string ComposeSpectrumPage(const SpectrumRun& run, const PageOrigin& origin);
/// @param prefix  of the names of the command's figures.
std::string ComposeContactPage(const WagonInputs& inputs, const ContactAnalysis& analysis, const std::string& prefix,
                               const PageOrigin& origin);
std::string ComposeInertiaPage(const WagonInputs& inputs, std::span<const Freight> freights, const PageOrigin& origin);
std::string ComposeElementPage(const ElementReport& report, const WagonInputs& inputs, const PageOrigin& origin);

}  // namespace uiclink
