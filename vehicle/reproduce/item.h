#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "vehicle/hunting/trace.h"
#include "vehicle/wagon_inputs.h"

/// Chapter 10 of the thesis, item by item: what is asked of the wagon, what the thesis says about it, and why ours
/// differs.
namespace uiclink::reproduce {

/// Eigenvalues against speed, crossings and what is born there.
struct StabilityTask {
  double from = 1, to = 50, step = 0.25;  ///< [m/s]
  double picture_around = 2;              ///< the root locus is drawn this far to both sides of the critical speed
};

/// The thesis's bifurcation trace, and beside it the branches of cycles.
struct TraceTask {
  double from = 15;  ///< [m/s]
  std::vector<TraceLeg> legs = {{23}, {8}};
  double hold = 10;  ///< [s]
  bool continuation = true;
  double branch_from = 5;  ///< range of the branches, not below the trace's own [m/s]
  double branch_to = 25;
};

/// A run at one speed. Either from `start` at once, or handed down to it from a higher speed as a trace does.
struct RunTask {
  double V = 0;             ///< [m/s]
  std::string start;        ///< as `wagon simulate --start`
  double duration = 60;     ///< at V [s]
  double window = 20;       ///< figures are of the last so many seconds
  double descend_from = 0;  ///< [m/s]; 0: at once
  double settle = 60;       ///< at descend_from [s]
  double step = 0.05;       ///< of the way down [m/s]
  double hold = 5;          ///< at each speed on it [s]
  bool guidance = true;
  bool end_at_wheel_lift = true;
  bool spectra = false;  ///< pictures of spectra instead of those of impacts
  bool kind = false;     ///< how the motion repeats: with a Poincare section
};

/// Growth out of the centre of the track.
struct GrowthTask {
  double V = 0;           ///< [m/s], or
  double above_hopf = 0;  ///< with V = 0: this far above the linear critical speed [m/s]
  std::string start = "front_lateral=0.01mm, rear_lateral=0.01mm";
  double duration = 800;  ///< [s]
};

/// Onset of hunting on the way up, by the time that each speed is held.
struct DelayTask {
  double from = 15, to = 25;                ///< [m/s]
  std::vector<double> holds = {5, 10, 40};  ///< [s]
};

/// What the tolerance of the solver does to a hunting motion.
struct ToleranceTask {
  double V = 24;
  std::string start;
  double duration = 150;
  std::vector<double> tolerances = {1e-5, 1e-6, 1e-8};
};

using Task = std::variant<StabilityTask, TraceTask, RunTask, GrowthTask, DelayTask, ToleranceTask>;

/// A figure that the thesis publishes.
struct Row {
  std::string what;                                     ///< with its unit
  std::string theirs;                                   ///< as read from the text; "-": nothing printed
  std::string place;                                    ///< where: "10.2.1", "table 10.1", "caption of figure 10.6"
  std::string value;                                    ///< ours: a key of ItemResult::values
  int digits = 2;                                       ///< of ours
  std::optional<double> published = {};                 ///< theirs as a number, to subtract
  double met_within = 0;                                ///< which their digits allow
  std::optional<std::array<double, 2>> met_range = {};  ///< ours agrees within: "above 20"
  std::vector<std::string> met_words = {};              ///< ours agrees if it says one of these
  /// On the geometries that have the published critical speed: the reason of a difference; empty: unexplained.
  std::string why = {};
  /// Said of a difference without a reason: what was tried.
  std::string tried = {};
};

struct Item {
  std::string id;                   ///< "fig-10.8"
  std::vector<std::string> covers;  ///< "figure 10.8", "table 10.1": all of chapter 10 that it regenerates
  std::string section;              ///< "10.2.1"
  std::string title;
  std::string set = "set1", cargo = "empty";
  Task task;
  std::vector<Row> rows;
  std::string note = {};  ///< said below the table
  /// Asked instead of `task` on nominal-1435, whose critical speeds are a third of the published ones.
  std::optional<Task> nominal_task = {};
};

/// All of chapter 10, in its order.
const std::vector<Item>& Items();

/// What the summary (10.5) says in words, and the value of another item that stands beside it.
struct Statement {
  Row row;
  std::string item;
  std::string than = {};  ///< an item by whose value it is divided; empty: none
};
const std::vector<Statement>& Statements();

/// Sections that get a page: number and title.
struct Section {
  std::string number, title, text;
};
const std::vector<Section>& Sections();

/// Figures and tables that chapter 10 has: "figure 10.1", ..., "table 10.2".
std::vector<std::string> ListPublished();

bool IsNominal(const std::string& geometry);
const Task& TaskOn(const Item& item, const std::string& geometry);
/// The wagon as the thesis computes it: inertias and centre of mass as printed.
WagonChoice ChoiceOf(const Item& item, const std::string& geometry);

/// What is run, in words with every number.
std::string Describe(const Task& task);
/// A command line that does the same; empty where none does.
std::string CommandOf(const Item& item, const std::string& geometry);
/// Fewer and shorter parts, to look at pages and for tests: nothing of it is a result.
Task Quicken(Task task);
/// Simulated time that it takes, roughly [s]: by which the time left is told.
double EstimateCost(const Task& task);

}  // namespace uiclink::reproduce
