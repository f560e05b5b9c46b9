// The missing force: is it nothing where nothing is missing, and is it the right one where something is?

#include "identify/missing_force.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "identify/identification.h"
#include "measurements/rig/rig.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

constexpr double kK = 3.41, kK1 = 2.21, kT01 = 0.018;
// Noise and rounding of the rig's sensor (rig.h: 0.013 mm with the quantisation).
constexpr double kSigma = 1.3e-5;

Oscillator<double> LateralLink() {
  Oscillator<double> link;
  link.k = kK;
  link.Add({.k = kK1, .T0 = kT01});
  return link;
}

rig::Settings Lateral(std::uint64_t seed) {
  rig::Settings settings;
  settings.name = "missing_force";
  settings.direction = "lateral";
  settings.link.k = kK;
  settings.link.joints = {{.k = kK1, .T0 = kT01}};
  settings.sensor.zero_scatter = 0.0003;
  settings.seed = seed;
  return settings;
}

std::size_t FirstAfter(const Record& record, double t0) {
  std::size_t first = 0;
  while (record.t[first] < t0) ++first;
  return first;
}

/// Records and the inputs that look at them; not to be copied.
struct Study {
  std::vector<Record> records;
  std::vector<RecordResult> fitted;
  std::vector<MissingForceInput> inputs;
};

/// Records of the rig beside the link and start that they were made with.
void MakeTrue(const rig::Settings& settings, int count, const Oscillator<double>& link, Study* study) {
  std::vector<rig::Truth> truths;
  for (int i = 1; i <= count; ++i) {
    const rig::RigRecord made = rig::MakeRecord(settings, i);
    truths.push_back(made.truth);
    study->records.push_back(ToRecord(made, Direction::kLateral));
  }
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const Record& record = study->records[i];
    const std::size_t first = FirstAfter(record, truths[i].first_extremum_s);
    study->inputs.push_back({.record = &record,
                             .first = first,
                             .size = record.t.size() - first,
                             .sigma = kSigma,
                             .offset = truths[i].zero_offset,
                             .link = link,
                             .y0 = truths[i].first_extremum,
                             .t0 = truths[i].first_extremum_s});
  }
}

/// Records of the rig beside the plain link that `identify` fits to them.
void MakeFitted(const rig::Settings& settings, int count, Study* study) {
  IdentifyOptions options;
  options.starts.count = 0;
  options.threads = 1;
  study->fitted = Identify(Direction::kLateral, MakeRecords(settings, count, Direction::kLateral), options).records;
  for (const RecordResult& result : study->fitted) {
    if (!result.used) continue;
    const FitData data = result.Data();
    study->inputs.push_back({.record = data.record,
                             .first = data.first,
                             .size = data.size,
                             .sigma = data.sigma,
                             .offset = result.start[2],
                             .link = result.link,
                             .y0 = result.start[0],
                             .t0 = result.start[1]});
  }
}

MissingForce FindTrue(const rig::Settings& settings, int count = 3) {
  Study study;
  MakeTrue(settings, count, LateralLink(), &study);
  return FindMissingForce(study.inputs);
}

MissingForce FindFitted(const rig::Settings& settings, int count = 3) {
  Study study;
  MakeFitted(settings, count, &study);
  EXPECT_EQ(study.inputs.size(), static_cast<std::size_t>(count));
  return FindMissingForce(study.inputs);
}

/// A free decay from y0 with a force of one's own, recorded from the extremum on: what the rig has no switch for.
/// Velocity Verlet in steps of 0.1 ms, as the rig has it; 200 Hz, normal noise.
Record SimulateWith(const AlongMotion& force, double y0, unsigned seed, double duration = 12) {
  constexpr int kSteps = 50;
  constexpr double kH = 1e-4, kG = kThesisGravity;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  Record record;
  record.sampling_hz = 200;
  Moment m{.t = 0, .y = y0, .v = 0};
  double T = y0 > 0 ? -kT01 : kT01;
  const auto acceleration = [&] { return kG * (-kK * m.y + T + force(m)); };
  double a = acceleration();
  for (int i = 0; m.t < duration; ++i) {
    if (i % kSteps == 0) record.t.push_back(m.t), record.y.push_back(m.y + noise(random));
    const double dy = kH * (m.v + 0.5 * kH * a);
    m.y += dy, m.t = (i + 1) * kH, m.v += kH * a;
    T = std::clamp(T - kK1 * dy, -kT01, kT01);
    const double after = acceleration();
    m.v += 0.5 * kH * (after - a);
    a = after;
  }
  return record;
}

MissingForce FindSimulated(const AlongMotion& force, unsigned seed,
                           std::initializer_list<double> starts = {0.025, -0.024, 0.026}) {
  std::vector<Record> records;
  for (const double y0 : starts) records.push_back(SimulateWith(force, y0, seed++));
  std::vector<MissingForceInput> inputs;
  auto y0 = starts.begin();
  for (const Record& record : records) {
    inputs.push_back(
        {.record = &record, .first = 0, .size = record.t.size(), .sigma = kSigma, .link = LateralLink(), .y0 = *y0++});
  }
  return FindMissingForce(inputs);
}

bool Names(const MissingForce& force, DependsOn on) { return force.search.all[static_cast<std::size_t>(on)].named; }
bool NamesOnly(const MissingForce& force, DependsOn on) { return Names(force, on) && force.search.named.size() == 1; }

/// Distances of a curve from a function, in errors, after the straight line between them that cannot be seen.
std::vector<double> CompareUpToLine(const std::vector<MissingForce::Bin>& bins,
                                    const std::function<double(double)>& truth) {
  Eigen::MatrixXd line(static_cast<Eigen::Index>(bins.size()), 2);
  Eigen::VectorXd distance(line.rows());
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    line(row, 0) = 1 / bins[i].error, line(row, 1) = bins[i].at / bins[i].error;
    distance[row] = (bins[i].f - truth(bins[i].at)) / bins[i].error;
  }
  const Eigen::VectorXd left = distance - line * (line.transpose() * line).inverse() * (line.transpose() * distance);
  return {left.begin(), left.end()};
}

TEST(ForceSeries, PlainMotionWithoutNoiseLacksNothing) {
  rig::Settings settings = Lateral(1);
  settings.sensor.noise = 0;
  settings.sensor.bits = 30;
  const rig::RigRecord made = rig::MakeRecord(settings, 1);
  Record record = ToRecord(made, Direction::kLateral);
  for (std::size_t i = 0; i < record.y.size(); ++i) record.y[i] = 1e-3 * made.y_mm[i];  // unrounded
  const std::size_t first = FirstAfter(record, made.truth.first_extremum_s);
  const auto series = ForceSeries::Make({.record = &record,
                                         .first = first,
                                         .size = record.t.size() - first,
                                         .sigma = kSigma,
                                         .offset = made.truth.zero_offset,
                                         .link = LateralLink(),
                                         .y0 = made.truth.first_extremum,
                                         .t0 = made.truth.first_extremum_s});
  ASSERT_TRUE(series);
  // Breakouts and turns included. What is left is the smoothed motion that the sliders follow: its fourth derivative
  // jumps by g k1 y'' = 24 m/s^4 where they turn, which moves a level by 0.5 um at 47 ms half width, and k1 by that is
  // 1e-6.
  for (const ForceSeries::Window& w : series->windows()) EXPECT_LT(std::abs(w.f), 3e-6) << w.at.t;
}

TEST(ForceSeries, StatedErrorsAreTrue) {
  // Windows of 40 records in their own units: variance 1. 600 windows each, 40 records: standard deviation of the mean
  // sqrt(2/24000) = 0.009. The sensor's noise and rounding together are 0.0125 to 0.0133 mm, 4 % to either side of
  // kSigma, so 8 % of the variance.
  double chi2 = 0;
  int dof = 0;
  Study study;
  MakeTrue(Lateral(11), 40, LateralLink(), &study);
  for (const MissingForceInput& input : study.inputs) {
    const auto series = ForceSeries::Make(input);
    ASSERT_TRUE(series);
    chi2 += series->JudgeForce().squaredNorm();
    dof += static_cast<int>(series->size()) - series->absorbed();
  }
  std::printf("chi-square of windows with nothing missing: %.3f per degree of freedom\n", chi2 / dof);
  EXPECT_NEAR(chi2 / dof, 1, 0.08 + 4 * 0.009);
}

TEST(ForceSeries, UnusableInput) {
  EXPECT_FALSE(ForceSeries::Make({}));
  Record record = SimulateWith([](const Moment&) { return 0.0; }, 0.025, 1, 0.2);
  EXPECT_FALSE(ForceSeries::Make(
      {.record = &record, .size = record.t.size(), .sigma = kSigma, .link = LateralLink(), .y0 = 0.025}));
  EXPECT_FALSE(ForceSeries::Make(
      {.record = &record, .size = 2 * record.t.size(), .sigma = kSigma, .link = LateralLink(), .y0 = 0.025}));
  EXPECT_FALSE(FindMissingForce({}).IsSignificant());
}

TEST(MissingForce, PlainRecordsLackNothing) {
  // The search has a false-alarm rate of kFalseAlarm: 20 seeds of true links and 20 of fitted ones, one alarm in 25
  // runs.
  double smallest = 0, friction = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const MissingForce at_truth = FindTrue(Lateral(seed), 1), fitted = FindFitted(Lateral(100 + seed), 3);
    EXPECT_FALSE(at_truth.IsSignificant()) << seed << ": " << at_truth.words;
    EXPECT_FALSE(fitted.IsSignificant()) << seed << ": " << fitted.words;
    EXPECT_EQ(fitted.words.rfind("no missing force above", 0), 0U) << fitted.words;
    smallest += at_truth.smallest_seen / 20, friction += 3 * at_truth.dry_friction_error / 20;
  }
  std::printf("one record: three errors are %.2g M g at one displacement, %.2g M g of dry friction\n", smallest,
              friction);
}

TEST(MissingForce, PlainRecordsOfFourSlidersLackNothing) {
  // Longitudinal link of set 1 (DESIGN, section 4).
  rig::Settings settings = Lateral(5);
  settings.direction = "longitudinal";
  settings.link.k = 6.4763;
  settings.link.joints = {
      {.k = 2.0, .T0 = 6e-3}, {.k = 0.5, .T0 = 3e-3}, {.k = 0.37, .T0 = 2e-3}, {.k = 0.5, .T0 = 2e-3}};
  Oscillator<double> link;
  link.k = settings.link.k;
  for (const rig::Joint& joint : settings.link.joints) link.Add({.k = joint.k, .T0 = joint.T0});
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    settings.seed = seed;
    Study study;
    MakeTrue(settings, 2, link, &study);
    const MissingForce force = FindMissingForce(study.inputs);
    EXPECT_FALSE(force.IsSignificant()) << seed << ": " << force.words;
  }
}

TEST(MissingForce, CubicStiffnessIsACurveOverDisplacement) {
  rig::Settings settings = Lateral(2);
  settings.link.effects.cubic_k3 = 400;
  for (const MissingForce& force : {FindTrue(settings), FindFitted(settings)}) {
    EXPECT_TRUE(NamesOnly(force, DependsOn::kDisplacement)) << force.words;
    EXPECT_GT(force.share_of_y, 0.95);
    // 4 errors: 21 correlated bins of two studies. The prior draws the ends towards a straight line, which its error
    // holds.
    for (const double z : CompareUpToLine(force.over_y, [](double y) { return -400 * y * y * y; }))
      EXPECT_LT(std::abs(z), 4);
    // The curve says something: at half swing and beyond it is known to a tenth of the truth's 6e-3.
    EXPECT_LT(force.over_y.front().error, 6e-4);
  }
}

TEST(MissingForce, ViscousDampingIsProportionalToVelocity) {
  rig::Settings settings = Lateral(3);
  settings.link.effects.viscous_c = 0.015;
  for (const MissingForce& force : {FindTrue(settings), FindFitted(settings)}) {
    EXPECT_TRUE(NamesOnly(force, DependsOn::kViscous)) << force.words;
    EXPECT_NEAR(force.viscous, 0.015, 4 * force.viscous_error);
    EXPECT_LT(force.viscous_error, 1.5e-4);  // a hundredth of it
    EXPECT_GT(force.share_of_v, 0.95);
    for (const MissingForce::Bin& bin : force.over_v) EXPECT_NEAR(bin.f, -0.015 * bin.at, 4 * bin.error) << bin.at;
    // The links find back to the truth: they had been fitted without the damping.
    for (const Oscillator<double>& link : force.links) {
      EXPECT_NEAR(link.k, kK, 0.02 * kK);  // about three standard deviations of one record's k in this fit
      EXPECT_NEAR(link.sliders()[0].T0, kT01, 0.02 * kT01);
    }
  }
}

TEST(MissingForce, RollingFrictionIsASignOfVelocity) {
  rig::Settings settings = Lateral(4);
  settings.link.effects.rolling_T_r = 5e-4;
  for (const MissingForce& force : {FindTrue(settings), FindFitted(settings)}) {
    EXPECT_TRUE(NamesOnly(force, DependsOn::kDryFriction)) << force.words;
    EXPECT_NEAR(force.dry_friction, 5e-4, 4 * force.dry_friction_error);
    EXPECT_LT(force.dry_friction_error, 1e-5);
    EXPECT_GT(force.share_of_sign_v, 0.95);
    EXPECT_NE(force.words.find("sign of velocity"), std::string::npos) << force.words;
  }
}

TEST(MissingForce, EndStopIsBeyondItsPosition) {
  rig::Settings settings = Lateral(5);
  settings.link.effects.stop_k = 50;
  settings.link.effects.stop_position = 0.018;
  const MissingForce force = FindTrue(settings);
  EXPECT_TRUE(NamesOnly(force, DependsOn::kDisplacement)) << force.words;
  EXPECT_NE(force.words.find("on one side of zero only"), std::string::npos) << force.words;
  for (const MissingForce::Bin& bin : force.over_y) {
    // Knots 2.5 mm apart join the corner at 18 mm by a straight line; a stop of 0.05 per millimetre reaches 0.1 M g 2
    // mm on.
    if (bin.at < 0.015) {
      EXPECT_LT(std::abs(bin.f), 0.01) << bin.at;
    }
    if (bin.at > 0.0205 && bin.at < 0.0245) {
      EXPECT_NEAR(bin.f, -50 * (bin.at - 0.018), 0.03) << bin.at;
    }
  }
}

TEST(MissingForce, LocalForceOnBothSides) {
  const auto bump = [](const Moment& m) {
    const double distance = std::abs(m.y);
    return distance > 0.009 && distance < 0.013 ? (m.y > 0 ? -7e-4 : 7e-4) : 0.0;
  };
  int seen = 0, both = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const MissingForce force = FindSimulated(bump, 10 * seed);
    if (NamesOnly(force, DependsOn::kDisplacement)) ++seen;
    if (force.words.find("on both sides of zero") != std::string::npos) ++both;
    if (seed == 1) std::printf("bump: %s\n", force.words.c_str());
  }
  EXPECT_EQ(seen, 10);
  EXPECT_GE(both, 9);  // the mirrored side is a threshold on a noisy curve
}

TEST(MissingForce, StiffnessThatIsModulated) {
  for (const double hz : {0.4, 1.7}) {
    const double w = 2 * std::numbers::pi * hz;
    const MissingForce force =
        FindSimulated([w](const Moment& m) { return -0.03 * kK * m.y * std::cos(w * m.t + 0.7); }, 7);
    EXPECT_TRUE(Names(force, DependsOn::kStiffnessOscillating)) << hz << ": " << force.words;
    // A twelfth of a hertz is the resolution of 12 s; half of it is the step of the search.
    EXPECT_NEAR(force.search.all[static_cast<std::size_t>(DependsOn::kStiffnessOscillating)].frequency, hz, 1.0 / 24);
  }
}

TEST(MissingForce, StiffnessThatChangesSlowly) {
  const MissingForce force = FindSimulated([](const Moment& m) { return -0.04 * kK * m.y * m.t / 12; }, 3);
  EXPECT_TRUE(NamesOnly(force, DependsOn::kStiffnessInTime)) << force.words;
  ASSERT_FALSE(force.stiffness_over_t.empty());
  const MissingForce::Bin &first = force.stiffness_over_t.front(), &last = force.stiffness_over_t.back();
  EXPECT_NEAR(last.f - first.f, 0.04 * kK * (last.at - first.at) / 12, 4 * std::hypot(first.error, last.error));
}

TEST(MissingForce, ForceThatDriftsInTime) {
  const MissingForce force = FindSimulated([](const Moment& m) { return 1e-4 * m.t; }, 3);
  EXPECT_TRUE(NamesOnly(force, DependsOn::kTime)) << force.words;
  for (std::size_t i = 1; i < force.over_t.size(); ++i) {
    const MissingForce::Bin &a = force.over_t[i - 1], &b = force.over_t[i];
    EXPECT_NEAR(b.f - a.f, 1e-4 * (b.at - a.at), 4 * std::hypot(a.error, b.error));
  }
}

TEST(MissingForce, MapAndSamples) {
  const MissingForce plain = FindTrue(Lateral(6));
  ASSERT_EQ(plain.records.size(), 3U);
  EXPECT_GT(plain.records[0].size(), 90U);  // 12 s, a window every 0.1 s
  double squares = 0;
  int count = 0;
  for (const MissingForce::Cell& cell : plain.map) {
    squares += cell.f * cell.f / (cell.error * cell.error);
    count += cell.count;
  }
  EXPECT_GT(count, 1500);  // four windows within each half width, 12 s, 3 records
  // Some 50 cells: one per cell with a standard deviation of sqrt(2/50), less the five directions in each of three
  // records that the links absorb. Three deviations above, and below with that loss of 0.3 at most.
  const double per_cell = squares / static_cast<double>(plain.map.size());
  EXPECT_GT(per_cell, 0.1);
  EXPECT_LT(per_cell, 1.6);

  rig::Settings settings = Lateral(6);
  settings.link.effects.viscous_c = 0.015;
  const MissingForce damped = FindTrue(settings);
  double along = 0, square = 0;
  for (const MissingForce::Cell& cell : damped.map) {
    along += cell.f * cell.v / (cell.error * cell.error), square += cell.v * cell.v / (cell.error * cell.error);
  }
  // What the links absorb (T0i beside a damping) makes the slope of the map smaller than c, never larger.
  EXPECT_LT(along / square, -5 / std::sqrt(square));
  EXPECT_GT(along / square, -0.0155);
}

TEST(MissingForce, CoarseAndUnevenRecordsLackNothing) {
  // 100, 50, 40 Hz and two thirds of the samples at 200 Hz: sliders follow a motion that is less well known.
  for (const std::size_t every : {2U, 4U, 5U, 1U}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Record fine = SimulateWith([](const Moment&) { return 0.0; }, 0.025, seed);
      Record record;
      record.uniform = every > 1;
      for (std::size_t i = 0; i < fine.t.size(); i += every) {
        if (every == 1 && (i * 2654435761U >> 7) % 3 == 0) continue;
        record.t.push_back(fine.t[i]), record.y.push_back(fine.y[i]);
      }
      const MissingForceInput input = {
          .record = &record, .first = 0, .size = record.t.size(), .sigma = kSigma, .link = LateralLink(), .y0 = 0.025};
      const MissingForce force = FindMissingForce({&input, 1});
      EXPECT_FALSE(force.IsSignificant()) << every << ", " << seed << ": " << force.words;
    }
  }
}

}  // namespace
}  // namespace uiclink
