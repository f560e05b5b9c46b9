// Pages of the wagon: what they say against the results that they are made of, and what the animation is given.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/cli/temporary_folder.h"
#include "tests/support/wagon_fixture.h"
#include "vehicle/page/animation.h"
#include "vehicle/page/pages.h"
#include "vehicle/page/sweep_page.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

const PageOrigin& Origin() {
  static const PageOrigin origin{.command = "wagon x --set 'a b'", .written = "now", .files = {"histories.svg"}};
  return origin;
}

/// A run of 12 s at 100 samples a second: every wheelset swings by `amplitude` at 1 Hz, the body rests.
struct MadeRun {
  Wagon wagon = WagonFixture{}.Make();
  WagonInputs inputs;
  SimulationResult result;

  explicit MadeRun(double amplitude, double growth = 0) {
    inputs.data = WagonFixture{}.ReadData();
    inputs.body = WagonFixture{}.ReadBody();
    inputs.freight.name = "empty";
    inputs.table = MakeHandMadeTable();
    inputs.files = {{.role = "wagon", .name = "hbbills", .path = "w.toml", .sha256 = "0123abcd"}};
    result.V = 24;
    result.simulated = 12;
    result.minimum_wheel_load = 20e3;
    for (std::size_t m :
         {TrackedMotionIndex(TrackedMotion::kFrontLateral), TrackedMotionIndex(TrackedMotion::kRearLateral)}) {
      result.motions[m].amplitude = amplitude;
      result.motions[m].frequencies = {1.0};
    }
    for (int i = 0; i <= 1200; ++i) {
      SimulationSample sample{.t = 0.01 * i, .x = {}};
      const double y = amplitude * std::exp(growth * (sample.t - 12)) * std::sin(2 * std::numbers::pi * sample.t);
      sample.x[wheelset::kY] = sample.x[kRearWheelset + wheelset::kY] = y;
      result.samples.push_back(sample);
    }
  }
  static std::size_t TrackedMotionIndex(TrackedMotion motion) { return static_cast<std::size_t>(motion); }
  SimulationRun Run() const { return {.inputs = inputs, .result = result, .start = "a push"}; }
  std::string Page() const { return ComposeSimulationPage(Run(), wagon, {}, Origin()); }
};

TEST(SimulationPage, BeginsWithWhatTheWagonDoes) {
  const std::string page = MadeRun(3e-3).Page();
  EXPECT_THAT(page,
              HasSubstr("<p class=\"lead\">At 24 m/s (86.4 km/h) the empty wagon hunts. In the last 10 s the front "
                        "wheelset goes 3.00 mm to either side, the rear one 3.00 mm"));
  EXPECT_THAT(page, HasSubstr("1.00 times a second. No axle box touched its guides"));
  EXPECT_THAT(page, HasSubstr("The least load of a wheel was 20.0 kN (front left)"));
}

TEST(SimulationPage, TellsHuntingFromRestAndFromWhatGrowsOrDies) {
  EXPECT_THAT(MadeRun(4e-5).Page(), HasSubstr("runs quietly: no wheelset moves sideways by more than 0.05 mm"));
  EXPECT_THAT(MadeRun(3e-3, 0.1).Page(), HasSubstr("the empty wagon hunts, more and more."));
  EXPECT_THAT(MadeRun(3e-3, -0.1).Page(), HasSubstr("swings from side to side, less and less."));
}

TEST(SimulationPage, SaysImpactsAndAnEarlyEndFirst) {
  MadeRun made(3e-3);
  made.result.lateral[1].impacts = {.count = 7, .peak_N = 1340};
  made.result.end = SimulationEnd::kWheelLift;
  made.result.end_reason = "the front left wheel lifted at 12 s";
  const std::string page = made.Page();
  EXPECT_THAT(page, HasSubstr("<p class=\"lead\">The run ended early: the front left wheel lifted at 12 s. At 24"));
  EXPECT_THAT(page, HasSubstr("The axle boxes struck their guides 7 times, with up to 1.34 kN."));
}

TEST(SimulationPage, HasItsSectionsAndHowToRepeatIt) {
  const std::string page = MadeRun(3e-3).Page();
  for (const char* id : {"from-above", "motions", "guidance", "spectra", "phases", "repeat"})
    EXPECT_THAT(page, HasSubstr(std::string("<h2 id=\"") + id));
  EXPECT_THAT(page, AllOf(HasSubstr("wagon x --set &#39;a b&#39;"), HasSubstr("w.toml"), HasSubstr("0123abcd"),
                          HasSubstr("href=\"histories.svg\"")));
}

TEST(SimulationPage, WithoutSamplesHasTablesAndNoFigures) {
  MadeRun made(3e-3);
  made.result.samples.clear();
  const std::string page = made.Page();
  EXPECT_THAT(page, HasSubstr("3.0000"));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<figure")), Not(HasSubstr("class=\"wagon-view\""))));
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(Animation, HasTheLastTenSecondsAtFiftyFramesASecond) {
  const MadeRun made(3e-3);
  const json data = json::parse(FormatAnimation(made.result, made.wagon, made.inputs));
  EXPECT_NEAR(data["begin"].get<double>(), 2, 1e-9);
  EXPECT_NEAR(data["hz"].get<double>(), 50, 1e-9);
  ASSERT_THAT(data["frames"]["front_y"], SizeIs(501));
  ASSERT_THAT(data["touches"], SizeIs(501));
  for (std::size_t i = 0; i < 501; ++i)  // rounded to 1e-5 m
    EXPECT_NEAR(1e-5 * data["frames"]["front_y"][i].get<double>(), made.result.samples[200 + 2 * i].x[wheelset::kY],
                0.51e-5);
  EXPECT_THAT(data["touches"], Each(0));
  EXPECT_EQ(data["wagon"]["lateral"], made.wagon.guidance.lateral.clearance);
}

TEST(Animation, LightsUpWhatIsTouchedAlsoBetweenFrames) {
  MadeRun made(0);
  const double lateral = made.wagon.guidance.lateral.clearance, along = made.wagon.guidance.longitudinal.clearance;
  made.result.samples[301].x[wheelset::kY] = lateral + 1e-4;  // between two frames
  made.result.samples[402].x[kRearWheelset + wheelset::kY] = -lateral - 1e-4;
  made.result.samples[502].x[wheelset::kX] = along + 1e-4;
  const json touches = json::parse(FormatAnimation(made.result, made.wagon, made.inputs))["touches"];
  const unsigned front_left_flange = 1U << 16, rear_right_flange = 1U << 19;
  EXPECT_EQ(touches[50], (1U << 0) + (1U << 4) + front_left_flange);    // front boxes to the left
  EXPECT_EQ(touches[101], (1U << 9) + (1U << 13) + rear_right_flange);  // rear boxes to the right
  EXPECT_EQ(touches[151], (1U << 2) + (1U << 6));                       // front boxes ahead
  EXPECT_EQ(touches[51], 0);
}

TEST(Animation, IsNotMadeOfTooFewSamples) {
  MadeRun made(3e-3);
  made.result.samples.resize(15);
  EXPECT_EQ(FormatAnimation(made.result, made.wagon, made.inputs), "");
  MadeRun slow(3e-3);
  for (SimulationSample& sample : slow.result.samples) sample.t *= 20;  // five a second
  EXPECT_EQ(FormatAnimation(slow.result, slow.wagon, slow.inputs), "");
}

TEST(Animation, FindsTheFlange) {
  // tan 30 degrees = 0.03 + 2.7 s,  s = t^2 (3 - 2 t) = 0.2027  at  t = 0.2836;  with roll left out of u ~ y.
  EXPECT_NEAR(FindFlangePlay(MakeHandMadeTable()), 5.5e-3 + 0.2836 * 2e-3, 1.5e-4);  // rows are 0.1 mm apart
  EXPECT_EQ(FindFlangePlay(MakeHandMadeTable({.flange_slope = 0})), 0);
}

// ---------------------------------------------------------------------------------------------------------------------

struct MadeStability {
  WagonInputs inputs;
  StabilityResult result;
  std::vector<RootsAtSpeed> roots{{10, {{-0.5, 6}}}, {20, {{0.5, 6}}}};

  MadeStability() {
    inputs.data = WagonFixture{}.ReadData();
    inputs.freight.name = "empty";
    inputs.table.name = "table";
    result.searched_to = 50;
  }
  std::string Page(const std::string& type = "") const {
    LinearMode mode{.lambda = {-0.5, 2 * std::numbers::pi}};
    mode.shape[kBody + body::kY] = 1;
    mode.shape[wheelset::kY] = {0, -0.25};
    StabilityRun run{.inputs = inputs, .result = result, .roots = roots, .options = {}};
    if (!type.empty()) run.types = {{.type = type}};
    return ComposeStabilityPage(run, {mode}, 10, {}, Origin());
  }
};

TEST(StabilityPage, SaysHowFastItRunsStraight) {
  MadeStability made;
  EXPECT_THAT(made.Page(), HasSubstr("From 1 m/s to 50 m/s (180.0 km/h) the empty wagon runs straight by itself"));
  made.result.unstable_at_start = 2;
  EXPECT_THAT(made.Page(), HasSubstr("The empty wagon does not run straight by itself even at 1 m/s"));
  made.result.unstable_at_start = 0;
  made.result.crossings = {{.V = 18.4, .frequency_hz = 0.87, .to_unstable = true, .mode = {}}};
  made.result.linear_critical_speed = 18.4;
  EXPECT_THAT(made.Page("subcritical"), AllOf(HasSubstr("Up to 18.4 m/s (66.2 km/h) the empty wagon runs straight"),
                                              HasSubstr("at first 0.87 times a second. It sets in with a jump")));
  EXPECT_THAT(made.Page("supercritical"), HasSubstr("It sets in gently"));
}

TEST(StabilityPage, TellsAmplitudesAndPhasesOfModes) {
  const std::string page = MadeStability().Page();
  EXPECT_THAT(page, AllOf(HasSubstr(">1.0000<"), HasSubstr("0.25 at -90°"), HasSubstr("1.00 at 0°")));
}

// ---------------------------------------------------------------------------------------------------------------------

struct MadeDiagram {
  WagonInputs inputs;
  BifurcationRun run{.inputs = inputs, .method = "continuation"};

  MadeDiagram() {
    inputs.freight.name = "empty";
    run.options.from = 8;
    run.options.to = 30;
    run.continued = true;
    run.diagram.linear.linear_critical_speed = 18.4;
    HuntingBranch hunting{.origin = "traced at 12 m/s", .branch = {}};
    for (const double V : {12.0, 10.0}) {
      Cycle cycle;
      cycle.lambda = V;
      cycle.period = 1;
      cycle.multipliers = {1.0, 0.5};
      cycle.passage.greatest = Eigen::VectorXd::Constant(kMotionCount, 1e-3 * V / 2);
      cycle.passage.least = -cycle.passage.greatest;
      hunting.branch.points.push_back(cycle);
    }
    run.diagram.branches = {hunting};
    run.diagram.nonlinear = NonlinearCritical{.speed = 9.25, .by = "fold", .branch = 0};
  }
};

TEST(BifurcationPage, SaysUpToWhereItIsQuietAndFromWhereOnItHunts) {
  MadeDiagram made;
  std::string page = ComposeBifurcationPage(made.run, {}, Origin());
  EXPECT_THAT(page, HasSubstr("Up to 9.25 m/s (33.3 km/h) every motion dies out. From there on hunting can last"));
  EXPECT_THAT(page, HasSubstr("from 18.4 m/s (66.2 km/h) on the empty wagon hunts by itself"));
  EXPECT_THAT(page, HasSubstr("moves the front wheelset 6.0 mm to either side, at 12 m/s (43.2 km/h)"));
  made.run.diagram.nonlinear.reset();
  made.run.diagram.branches.clear();
  page = ComposeBifurcationPage(made.run, {}, Origin());
  EXPECT_THAT(page,
              HasSubstr("Above 18.4 m/s (66.2 km/h) the empty wagon no longer runs straight by itself; no lasting "
                        "hunting was found from 8 to 30 m/s."));
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(SweepPage, DrawsResultsOverTheAxisWithTheMostValues) {
  const TemporaryFolder folder;
  const SweepPlan plan(
      ParseCampaign("name = \"test\"\n[grid]\ncargo = [\"empty\", \"water\"]\nspeed = [10, 20, 30]\n"
                    "[run]\nkind = \"modes\"\n",
                    "c.toml"));
  const std::filesystem::path file = folder.path() / "a.sqlite";
  std::vector<FinishedRun> runs;
  for (std::size_t run = 0; run < 5; ++run)
    runs.push_back({.run = run, .outcome = {.values = {static_cast<double>(run) - 2, 1, 2}}, .wall_s = 1});
  runs.push_back({.run = 5, .outcome = {.status = RunStatus::kFailed, .reason = "no <luck>"}, .wall_s = 1});
  SweepStore(file, plan, "1", SweepStore::Existing::kGoOn).Write(runs);
  const std::string page = ComposeSweepPage(plan, "c.toml", file, Origin());
  EXPECT_THAT(page, HasSubstr("5 of the 6 runs of &quot;test&quot; are done, 1 failed."));
  EXPECT_THAT(
      page, HasSubstr("Over the 5 runs that have one, the growth is between -2 and 2 1/s; half of them are above 0."));
  EXPECT_THAT(page, AllOf(HasSubstr("cargo empty"), HasSubstr("cargo water"), HasSubstr("\"x\":[10.0,20.0,30.0]"),
                          HasSubstr("\"y\":[-2.0,-1.0,0.0]"), HasSubstr("no &lt;luck&gt;")));
}

}  // namespace
}  // namespace uiclink
