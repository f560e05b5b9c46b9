#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "vehicle/command_bounds.h"
#include "vehicle/commands.h"
#include "vehicle/hunting/diagram_report.h"
#include "vehicle/hunting/wagon_parameter.h"

namespace uiclink {

/// What `wagon bifurcation` was asked for.
struct BifurcationArguments {
  WagonChoice choice;
  Output output;
  std::string method = "continuation";
  DiagramOptions diagram;
  TraceOptions trace;
  double trace_step = TraceLeg{}.step;
  std::string legs;
  AttractorOptions attractors;
  std::optional<std::size_t> starts;
  std::optional<double> speed;  // of --method attractors, and of --parameter [m/s]
  std::string parameter;        // empty: the speed
  std::string range;            // of it, "LOW,HIGH"
  BoundsArguments bounds;
  bool restart = false;
  int threads = 0;

  bool continues() const { return method == "continuation" || method == "both"; }
  bool traces() const { return method == "trace" || method == "both"; }
  bool surveys() const { return method == "attractors"; }
  bool by_parameter() const { return !parameter.empty(); }
};

/// The parameter that was chosen, with its value in these inputs, and the wagons over its range.
struct ChosenParameter {
  WagonParameter parameter;
  WagonFamily family;
};
/// @throws UsageError for a name or range that does not fit.
ChosenParameter FindChosenParameter(const BifurcationArguments& arguments, const WagonInputs& inputs);

/// Does all of it, with progress on the terminal. A trace or a survey goes on from what an interrupted one has left in
/// the folder of the results, and leaves what it has done when it is interrupted itself (InterruptGuard).
/// @throws InputError for a file of progress that is none; what the methods throw.
BifurcationRun ComputeBifurcation(const BifurcationArguments& arguments, const WagonInputs& inputs);

/// There is something that the same command goes on with.
bool HasProgress(const BifurcationArguments& arguments);

}  // namespace uiclink
