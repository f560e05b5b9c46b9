// What `wagon bifurcation` says of a diagram that is made by hand.

#include "vehicle/hunting/diagram_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "vehicle/hunting/attractor_report.h"

namespace uiclink {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// Seven motions; all of the half width given [m].
Cycle MakeCycle(double V, double half_width, int unstable = 0) {
  Cycle cycle;
  cycle.lambda = V;
  cycle.period = 1;
  cycle.unstable = unstable;
  cycle.multipliers = {1.0, {0.9, 0.1}, {0.9, -0.1}, 0.5};
  if (unstable > 0) cycle.multipliers[3] = 1.4;
  cycle.trivial_error = 1e-6 * V;
  cycle.passage.greatest = Eigen::VectorXd::Constant(kMotionCount, half_width);
  cycle.passage.least = -cycle.passage.greatest;
  cycle.passage.character = V < 11 ? "slips 8 lateral 4 longitudinal, guidance rear" : "slips 8 lateral 4 longitudinal";
  return cycle;
}

BranchEvent MakeEvent(BranchEventKind kind, std::size_t point, const Cycle& cycle, const std::string& text = "") {
  return {.kind = kind, .lambda = cycle.lambda, .period = cycle.period, .point = point, .text = text, .cycle = cycle};
}

/// Stable from 12 down to a fold at 9.25, unstable back to 11.
Branch FoldedBranch() {
  Branch branch;
  branch.points = {MakeCycle(12, 1e-3), MakeCycle(10, 2e-3), MakeCycle(9.5, 3e-3, 1), MakeCycle(11, 4e-3, 1)};
  branch.events = {
      MakeEvent(BranchEventKind::kCharacter, 0, MakeCycle(11, 1.5e-3),
                "slips 8 lateral 4 longitudinal -> slips 8 lateral 4 longitudinal, guidance rear"),
      MakeEvent(BranchEventKind::kCharacter, 1, MakeCycle(10, 2e-3), "slips 8 -> slips 9"),
      MakeEvent(BranchEventKind::kFold, 1, MakeCycle(9.25, 2.5e-3)),
  };
  return branch;
}

struct Made {
  WagonInputs inputs;
  BifurcationRun run{.inputs = inputs, .method = "continuation"};

  Made() {
    inputs.data.name = "wagon";
    inputs.freight.name = "empty";
    inputs.table.name = "table";
    run.options.from = 8;
    run.options.to = 30;
    run.continued = true;
    Crossing crossing;
    crossing.V = 18.4;
    crossing.frequency_hz = 0.875;
    crossing.to_unstable = true;
    run.diagram.linear.crossings = {crossing};
    run.diagram.linear.linear_critical_speed = 18.4;
    HopfPoint hopf;
    hopf.crossing = crossing;
    hopf.type = HopfType::kSubcritical;
    hopf.other_below = 1e-5;
    run.diagram.hopfs = {hopf};
    run.diagram.branches = {{"traced at 12 m/s", FoldedBranch()}};
    run.diagram.nonlinear = NonlinearCritical{.speed = 9.25, .by = "fold", .branch = 0};
  }
};

TEST(BranchStretches, AFoldBelongsToBothSides) {
  const Branch branch = FoldedBranch();
  const std::vector<BranchStretch> stretches = ListStretches(branch);
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_TRUE(stretches[0].stable);
  EXPECT_THAT(stretches[0].cycles, ElementsAre(&branch.points[0], &branch.points[1], &branch.events[2].cycle));
  EXPECT_EQ(stretches[0].end, &branch.events[2]);
  EXPECT_FALSE(stretches[1].stable);
  EXPECT_THAT(stretches[1].cycles, ElementsAre(&branch.events[2].cycle, &branch.points[2], &branch.points[3]));
  EXPECT_EQ(stretches[1].begin, &branch.events[2]);
  EXPECT_EQ(stretches[1].end, nullptr);
  EXPECT_EQ(stretches[1].unstable, 1);
}

TEST(BranchStretches, StabilityThatChangesWithoutAnEventPartsThemToo) {
  Branch branch = FoldedBranch();
  branch.events.clear();
  const std::vector<BranchStretch> stretches = ListStretches(branch);
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_EQ(stretches[0].cycles.size(), 2u);
  EXPECT_EQ(stretches[1].cycles.size(), 2u);
  EXPECT_TRUE(ListStretches({}).empty());
}

TEST(DiagramPage, NamesCriticalSpeedsTypeAndAccuracy) {
  const Made made;
  const std::string text = FormatBifurcation(made.run);
  EXPECT_THAT(text, HasSubstr("Linear critical speed     18.400000 m/s (66.2 km/h), 0.875 Hz\n"));
  EXPECT_THAT(text, HasSubstr("subcritical, decided by the cycle of 0.1 mm; supercritical at 0.01 mm\n"));
  EXPECT_THAT(text, HasSubstr("Nonlinear critical speed  9.250000 m/s (33.3 km/h), fold, branch 1\n"));
  EXPECT_THAT(text, HasSubstr("every trivial multiplier is within 1.2e-05 of 1"));
  EXPECT_THAT(text, HasSubstr("fold       9.250000"));
  EXPECT_THAT(text, HasSubstr("none -> rear")) << "guidance is an event";
  EXPECT_THAT(text, Not(HasSubstr("slips 9"))) << "other changes of character are not";
}

TEST(DiagramPage, AStableEndOfTheRangeIsABound) {
  Made made;
  made.run.diagram.nonlinear = NonlinearCritical{.speed = 8, .by = "end of a branch", .branch = 0};
  EXPECT_THAT(FormatBifurcation(made.run), HasSubstr("Nonlinear critical speed  at most 8.000000 m/s"));
  EXPECT_EQ(json::parse(FormatBifurcationJson(made.run))["nonlinear_critical_speed"]["is_upper_bound"], true);
  made.run.diagram.nonlinear.reset();
  EXPECT_THAT(FormatBifurcation(made.run), HasSubstr("no lasting hunting was found from 8 to 30 m/s"));
}

TEST(DiagramPage, ATorusSaysThePeriodOfItsModulation) {
  Made made;
  Cycle cycle = MakeCycle(10, 2e-3);
  cycle.multipliers = {1.0, std::polar(1.0, 0.25), std::polar(1.0, -0.25), {0.3, 0.4}};
  made.run.diagram.branches[0].branch.events = {MakeEvent(BranchEventKind::kTorus, 1, cycle)};
  EXPECT_THAT(FormatBifurcation(made.run), HasSubstr("modulation of 25.1 s")) << "2 pi 1 s/0.25";
}

TEST(DiagramJson, HasTheKeysOfTheSchema) {
  const Made made;
  const json result = json::parse(FormatBifurcationJson(made.run));
  EXPECT_EQ(result["schema"], "wagon-bifurcation/1");
  EXPECT_EQ(result["method"], "continuation");
  EXPECT_EQ(result["linear_critical_speed"]["value"], 18.4);
  EXPECT_EQ(result["linear_critical_speed"]["type"], "subcritical");
  EXPECT_DOUBLE_EQ(result["linear_critical_speed"]["other_type_below_mm"], 0.01);
  EXPECT_EQ(result["nonlinear_critical_speed"]["value"], 9.25);
  EXPECT_EQ(result["nonlinear_critical_speed"]["by"], "fold");
  ASSERT_EQ(result["branches"].size(), 2u) << "an element for every stretch of equal stability";
  EXPECT_EQ(result["branches"][0]["stable"], true);
  EXPECT_EQ(result["branches"][1]["stable"], false);
  const json& point = result["branches"][0]["points"][1];
  EXPECT_EQ(point["speed"], 10);
  EXPECT_DOUBLE_EQ(point["amplitude_mm"]["front_lateral"], 2);
  EXPECT_EQ(point["period_s"], 1);
  EXPECT_EQ(point["multipliers"][1], json({0.9, 0.1}));
  EXPECT_EQ(result["folds"].size(), 1u);
  EXPECT_EQ(result["folds"][0]["speed"], 9.25);
  EXPECT_EQ(result["events"].size(), 3u);
}

TEST(DiagramColumns, HaveARowForEveryPoint) {
  const Made made;
  const std::vector<DataColumn> columns = BranchColumns(made.run);
  EXPECT_EQ(columns[1].name, "speed");
  EXPECT_THAT(columns[1].values, ElementsAre(12, 10, 9.5, 11));
  for (const DataColumn& column : columns) EXPECT_EQ(column.values.size(), 4u) << column.name;
  EXPECT_NO_THROW(FormatCsv(columns));
}

TEST(DiagramFigures, DrawStableAndUnstableApartAndJoinThemAtTheFold) {
  const Made made;
  const Figure figure = DiagramFigure(made.run);
  ASSERT_EQ(figure.panels.size(), 3u);
  const auto find = [&](const std::string& name) -> const FigureSeries& {
    for (const FigureSeries& series : figure.panels[0].series)
      if (series.name == name) return series;
    throw std::runtime_error("no series " + name);
  };
  EXPECT_EQ(find("stable hunting").line, FigureLine::kSolid);
  EXPECT_EQ(find("unstable").line, FigureLine::kDashed);
  EXPECT_EQ(find("stable hunting").x[2], 9.25);
  EXPECT_EQ(find("unstable").x[0], 9.25);
  EXPECT_THAT(find("fold").y, ElementsAre(2.5));
  EXPECT_THAT(find("Hopf").x, ElementsAre(18.4));
  EXPECT_EQ(MultiplierFigure(made.run).panels.size(), 1u);
}

TraceRun MadeTrace() {
  TraceRun run;
  run.options = {.from = 15, .legs = {{17, 1}, {15, 1}}, .integrator = {}};
  run.complete = true;
  const std::vector<std::pair<double, double>> rows{{15, 1e-6}, {16, 1e-6}, {17, 3e-3}, {16, 3.5e-3}, {15, 1e-6}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    TraceRow row{.V = rows[i].first, .leg = i < 3 ? 0u : 1u};
    row.half_width.fill(rows[i].second);
    run.rows.push_back(row);
  }
  return run;
}

TEST(TraceReport, SaysWhereHuntingSetsInAndDiesOnEachLegAndByHowMuchThatIsLate) {
  const TraceRun trace = MadeTrace();
  const std::vector<LegFigures> legs = CalcLegFigures(trace);
  ASSERT_EQ(legs.size(), 2u);
  EXPECT_EQ(legs[0].onset, 17);
  EXPECT_EQ(legs[0].death, std::nullopt);
  EXPECT_EQ(legs[1].from, 17);
  EXPECT_EQ(legs[1].death, 15);
  EXPECT_DOUBLE_EQ(legs[1].largest, 3.5e-3);
  EXPECT_EQ(legs[1].at, 16);
  const TraceDelay delay = CalcTraceDelay(legs, 16.25, 15.5);
  EXPECT_DOUBLE_EQ(*delay.onset, 0.75);
  EXPECT_DOUBLE_EQ(*delay.death, -0.5);
  EXPECT_FALSE(CalcTraceDelay(legs, std::nullopt, std::nullopt).onset);
}

TEST(TraceReport, IsPartOfThePageAndOfTheJson) {
  Made made;
  made.run.method = "both";
  made.run.trace = MadeTrace();
  const std::string text = FormatBifurcation(made.run);
  EXPECT_THAT(text, HasSubstr("Onset on the way up less the linear critical speed: -1.40 m/s"));
  const json result = json::parse(FormatBifurcationJson(made.run));
  EXPECT_EQ(result["trace"]["points"].size(), 5u);
  EXPECT_EQ(result["trace"]["legs"][0]["onset"], 17);
  EXPECT_EQ(result["trace_delay"]["death_m_per_s"], 5.75);
}

TEST(SurveyReport, HasSharesWithBoundsAndARowForEveryStart) {
  Made made;
  AttractorSurvey survey;
  survey.V = 24;
  survey.runs.resize(4);
  Attractor hunting;
  hunting.runs = {0, 2, 3};
  hunting.share = 0.75;
  hunting.low = 0.3;
  hunting.high = 0.95;
  hunting.typical.motion.kind = MotionKind::kModulated;
  hunting.typical.motion.modulation_period = 8.1;
  hunting.lyapunov = LyapunovResult{.exponent = 0.01, .error = 0.002, .duration = 400, .end = {}};
  survey.attractors = {hunting};
  made.run.survey = survey;
  const std::string text = FormatBifurcation(made.run);
  EXPECT_THAT(text, AllOf(HasSubstr("75.0"), HasSubstr("30 to 95"), HasSubstr("modulated, 8.1 s"),
                          HasSubstr("0.0100 +- 0.0020")));
  EXPECT_THAT(SurveyColumns(survey)[0].values, ElementsAre(1, 0, 1, 1));
  EXPECT_EQ(json::parse(FormatBifurcationJson(made.run))["survey"]["attractors"][0]["share"], 0.75);
}

}  // namespace
}  // namespace uiclink
