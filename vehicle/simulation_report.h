#pragma once

#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// A run with what it stands on.
struct SimulationRun {
  const WagonInputs& inputs;
  const SimulationResult& result;
  std::string start;   ///< what the run started from, in words
  double start_s = 0;  ///< time of the start state; > 0 where a run was resumed
  double window = 10;  ///< [s]
};

/// Schema "wagon-simulate/1".
std::string FormatSimulationJson(const SimulationRun& run);

/// Summary for a terminal, and its tables: the motions in the window, and what the clearances were used for.
std::string FormatSimulation(const SimulationRun& run);
TextTable MakeMotionTable(const SimulationResult& result);
TextTable MakeGuidanceTable(const SimulationRun& run);

/// Time, every motion and, where the result has them, forces; SI units. One row for each sample.
std::vector<DataColumn> HistoryColumns(const SimulationRun& run);

/// Motions and wheel loads over the run, and beside them its last seconds.
Figure HistoryFigure(const SimulationRun& run);

}  // namespace uiclink
