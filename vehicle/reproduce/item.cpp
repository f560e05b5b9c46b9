#include "vehicle/reproduce/item.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/reproduce/item_lists.h"

namespace uiclink::reproduce {
namespace {

void Append(std::vector<Item> more, std::vector<Item>* items) {
  for (Item& item : more) items->push_back(std::move(item));
}

std::string Words(const StabilityTask& task) {
  return fmt::format("eigenvalues from {:g} to {:g} m/s in steps of {:g} m/s", task.from, task.to, task.step);
}

std::string Words(const TraceTask& task) {
  std::string text = fmt::format("trace from {:g}", task.from);
  for (const TraceLeg& leg : task.legs) text += fmt::format(" to {:g}", leg.to);
  text += fmt::format(" m/s in steps of {:g} m/s, {:g} s each, figures of the last 3 s", task.legs[0].step, task.hold);
  if (task.continuation)
    text += fmt::format("; branches of cycles from {:g} to {:g} m/s", task.branch_from, task.branch_to);
  return text;
}

std::string Words(const RunTask& task) {
  std::string text = "from the running equilibrium with " + task.start;
  if (task.descend_from > 0) {
    text += fmt::format(", {:g} s at {:g} m/s, down in steps of {:g} m/s and {:g} s to {:g} m/s, {:g} s there",
                        task.settle, task.descend_from, task.step, task.hold, task.V, task.duration);
  } else {
    text += fmt::format(", {:g} s at {:g} m/s", task.duration, task.V);
  }
  text += fmt::format("; figures of the last {:g} s", task.window);
  if (!task.guidance) text += "; without guidance";
  if (!task.end_at_wheel_lift) text += "; through wheel lift";
  if (task.kind) text += "; then until its section says what kind of motion it is";
  if (task.spectra) text += "; spectra";
  return text;
}

std::string Words(const GrowthTask& task) {
  const std::string speed =
      task.V > 0 ? fmt::format("{:g} m/s", task.V) : fmt::format("{:g} m/s above the critical speed", task.above_hopf);
  return fmt::format("from the running equilibrium with {}, {:g} s at {}", task.start, task.duration, speed);
}

std::string Words(const DelayTask& task) {
  return fmt::format("traces from {:g} to {:g} m/s in steps of 0.05 m/s, {} s each", task.from, task.to,
                     fmt::join(task.holds, ", "));
}

std::string Words(const ToleranceTask& task) {
  return fmt::format("from the running equilibrium with {}, {:g} s at {:g} m/s, tolerances {}", task.start,
                     task.duration, task.V, fmt::join(task.tolerances, ", "));
}

std::string WagonWords(const Item& item, const std::string& geometry) {
  return fmt::format("--set {} --cargo {} --geometry {} --com printed", item.set, item.cargo, geometry);
}

double TraceSeconds(double from, const std::vector<TraceLeg>& legs, double hold) {
  double seconds = 0;
  for (const TraceLeg& leg : legs) {
    seconds += std::abs(leg.to - from) / leg.step * hold;
    from = leg.to;
  }
  return seconds;
}

double Cost(const StabilityTask& /*task*/) { return 1000; }
double Cost(const TraceTask& task) {
  // Following all branches of a wagon takes as long as so much simulated time, by measurement.
  constexpr double kBranches = 40e3;
  return TraceSeconds(task.from, task.legs, task.hold) + (task.continuation ? kBranches : 0);
}
double Cost(const RunTask& task) {
  constexpr double kKind = 200;
  const double down = task.descend_from > 0 ? task.settle + (task.descend_from - task.V) / task.step * task.hold : 0;
  return down + task.duration + (task.kind ? kKind : 0);
}
double Cost(const GrowthTask& task) { return task.duration; }
double Cost(const DelayTask& task) {
  double seconds = 0;
  for (const double hold : task.holds) seconds += TraceSeconds(task.from, {{task.to}}, hold);
  return seconds;
}
double Cost(const ToleranceTask& task) { return task.duration * static_cast<double>(task.tolerances.size()); }

void Shorten(StabilityTask* task) { task->step = 1; }
void Shorten(TraceTask* task) {
  for (TraceLeg& leg : task->legs) leg.step = 0.5;
  task->hold = 5;
  task->continuation = false;
}
void Shorten(RunTask* task) {
  task->duration = std::min(task->duration, 30.0);
  task->window = std::min(task->window, 10.0);
  task->settle = std::min(task->settle, 30.0);
  task->step = 0.5;
  task->kind = false;
}
void Shorten(GrowthTask* task) { task->duration = 100; }
void Shorten(DelayTask* task) { task->holds = {5}; }
void Shorten(ToleranceTask* task) { task->duration = 30; }

}  // namespace

const std::vector<Item>& Items() {
  static const std::vector<Item> items = [] {
    std::vector<Item> all = ListMethodItems();
    Append(ListSetOneSpeedItems(), &all);
    Append(ListSetOneImpactItems(), &all);
    Append(ListSetTwoItems(), &all);
    Append(ListSpectrumItems(), &all);
    return all;
  }();
  return items;
}

std::vector<std::string> ListPublished() {
  std::vector<std::string> all;
  for (int number = 1; number <= 30; ++number) all.push_back(fmt::format("figure 10.{}", number));
  all.insert(all.end(), {"table 10.1", "table 10.2"});
  return all;
}

bool IsNominal(const std::string& geometry) { return geometry.starts_with("nominal"); }

const Task& TaskOn(const Item& item, const std::string& geometry) {
  return IsNominal(geometry) && item.nominal_task ? *item.nominal_task : item.task;
}

WagonChoice ChoiceOf(const Item& item, const std::string& geometry) {
  WagonChoice choice;
  choice.sets = {item.set};
  choice.cargo = item.cargo;
  choice.geometry = geometry;
  choice.inertia = InertiaOptions::Printed();
  if (const auto* run = std::get_if<RunTask>(&item.task)) choice.options.guidance = run->guidance;
  return choice;
}

std::string Describe(const Task& task) {
  return std::visit([](const auto& one) { return Words(one); }, task);
}

std::string CommandOf(const Item& item, const std::string& geometry) {
  const Task& task = TaskOn(item, geometry);
  const std::string wagon = WagonWords(item, geometry);
  if (const auto* stability = std::get_if<StabilityTask>(&task)) {
    return fmt::format("wagon stability {} --from {:g} --to {:g} --step {:g}", wagon, stability->from, stability->to,
                       stability->step);
  }
  const auto* run = std::get_if<RunTask>(&task);
  if (run == nullptr || run->descend_from > 0) return {};
  return fmt::format("wagon simulate {}{} --speed {:g} --start '{}' --time {:g} --window {:g}", wagon,
                     run->guidance ? "" : " --no-guidance", run->V, run->start, run->duration, run->window);
}

Task Quicken(Task task) {
  std::visit([](auto& one) { Shorten(&one); }, task);
  return task;
}

double EstimateCost(const Task& task) {
  return std::visit([](const auto& one) { return Cost(one); }, task);
}

}  // namespace uiclink::reproduce
