#pragma once

#include <exception>
#include <functional>
#include <optional>

#include "reports/figure.h"
#include "vehicle/hunting/trace.h"
#include "vehicle/reproduce/item.h"
#include "vehicle/reproduce/result.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink::reproduce {

/// What was being computed is given up: asked from outside.
class GivenUp : public std::exception {};

/// What a task is done with.
struct Bench {
  const WagonInputs& inputs;
  Wagon wagon;
  std::function<bool()> go_on;  ///< asked now and then; false: give up. May be null.

  bool GoOn() const { return !go_on || go_on(); }
};

/// Does a task. @throws GivenUp; what cannot be computed is ItemResult::failure.
ItemResult Measure(const Task& task, const Bench& bench);

// One file for each kind of task.
void Measure(const StabilityTask& task, const Bench& bench, ItemResult* result);
void Measure(const TraceTask& task, const Bench& bench, ItemResult* result);
void Measure(const RunTask& task, const Bench& bench, ItemResult* result);
void Measure(const GrowthTask& task, const Bench& bench, ItemResult* result);
void Measure(const DelayTask& task, const Bench& bench, ItemResult* result);
void Measure(const ToleranceTask& task, const Bench& bench, ItemResult* result);

/// Draws a figure into the result; where gnuplot is missing, a notice.
void Draw(const Figure& figure, const std::string& title, ItemResult* result);

/// A run that is given up when the bench says so. @throws GivenUp.
SimulationResult RunOn(const Bench& bench, Integrator* integrator, double V, const WagonState& start,
                       SimulationOptions options);
/// A trace, likewise; its end state is in Trace::end.
Trace TraceOn(const Bench& bench, const WagonState& start, const TraceOptions& options);

/// The linear critical speed; none: stable all over.
std::optional<double> FindCritical(const Wagon& wagon, double to = 60);

inline Value ToValue(const std::optional<double>& number) { return number ? Value(*number) : Value(); }

}  // namespace uiclink::reproduce
