// What the plain model gets wrong: clean records show nothing, a hidden effect shows where an engineer would look.

#include "identify/symptoms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "identify/symptom_inputs.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

Identification IdentifyRig(const rig::Settings& settings, int records = 3) {
  IdentifyOptions options;
  options.starts.count = 0;
  options.threads = 1;
  return Identify(Direction::kLateral, MakeRecords(settings, records, Direction::kLateral), options);
}

const Symptom& Find(const Symptoms& symptoms, const std::string& id) {
  static const Symptom missing{};
  const auto found =
      std::find_if(symptoms.list.begin(), symptoms.list.end(), [&](const Symptom& s) { return s.id == id; });
  if (found != symptoms.list.end()) return *found;
  ADD_FAILURE() << "no symptom " << id;
  return missing;
}

bool IsSignificant(const Symptoms& symptoms, const std::string& id) {
  return std::any_of(symptoms.list.begin(), symptoms.list.end(),
                     [&](const Symptom& s) { return s.id == id && s.IsSignificant(); });
}

/// Read-outs whose z has a sign are standard normal for records of the model itself.
TEST(Symptoms, OfCleanRecordsAreNoise) {
  constexpr int kStudies = 20;
  std::map<std::string, double> squares;
  int above = 0;
  for (int study = 0; study < kStudies; ++study) {
    const Symptoms symptoms = FindSymptoms(IdentifyRig(PlainLateral(500 + static_cast<std::uint64_t>(study))));
    bool any = false;
    for (const Symptom& s : symptoms.list) {
      if (!s.of_model) continue;
      squares[s.id] += s.z * s.z;
      any |= s.IsSignificant();
      // Five deviations, among 500 values of which none of 100 draws knows its error better than to 7 %.
      EXPECT_LT(std::abs(s.z), 5) << s.id << ": " << s.sentence;
    }
    above += any ? 1 : 0;
    EXPECT_FALSE(symptoms.exponent.known) << "study " << study;
  }
  EXPECT_LE(above, 2);                   // 8 of 640 have one; three of 20 would come once in 2000
  for (const auto& [id, sum] : squares)  // chi-square of 20: above 51.4 once in 8000, 1.6 of an rms
    EXPECT_LT(std::sqrt(sum / kStudies), 1.6) << id;
  // And they are no smaller than that: what the fit follows is taken out of their errors (99.9 %: 0.54).
  for (const char* id : {"T0_from_decrement", "T0_from_centre", "loss_per_half_cycle_large", "backbone_large",
                         "backbone_small", "mid_line_in_time", "rest_off_centre"})
    EXPECT_GT(std::sqrt(squares[id] / kStudies), 0.54) << id;
}

TEST(Symptoms, ScatterBetweenRecordsIsNone) {
  rig::Settings settings = PlainLateral(40);
  settings.scatter = {.k = 0.03, .joint_k = 0.03, .joint_T0 = 0.03};
  const Identification id = IdentifyRig(settings, 5);
  ASSERT_FALSE(id.shared);
  for (const Symptom& s : FindSymptoms(id).list) EXPECT_FALSE(s.of_model && s.IsSignificant()) << s.sentence;
}

TEST(Symptoms, LossesShowTheirExponentWhileTheJointsRoll) {
  const struct {
    double rig::EffectSizes::*size;
    double value, exponent;
    const char* words;
  } losses[] = {{&rig::EffectSizes::rolling_T_r, 3e-4, 1, "as dry friction has it"},
                {&rig::EffectSizes::viscous_c, 0.01, 2, "as viscous damping has it"},
                {&rig::EffectSizes::drag_d, 0.3, 3, "as quadratic drag or micro-slip has it"}};
  for (const auto& loss : losses) {
    rig::Settings settings = PlainLateral(900);
    settings.link.effects.*loss.size = loss.value;
    const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
    const DecayExponent& e = symptoms.exponent;
    ASSERT_TRUE(e.known) << loss.words;
    // Half a width to each side: a 95 % interval, three seeds.
    EXPECT_LT(e.low - 0.5 * (e.high - e.low), loss.exponent);
    EXPECT_GT(e.high + 0.5 * (e.high - e.low), loss.exponent);
    EXPECT_LT(e.high - e.low, 0.3);
    const Symptom& rolling = Find(symptoms, "rolling_loss");
    EXPECT_GT(rolling.z, 50);
    EXPECT_THAT(rolling.sentence, HasSubstr(loss.words));
    EXPECT_LT(rolling.modelled, 0.05 * rolling.measured);
    EXPECT_GT(Find(symptoms, "loss_per_half_cycle_small").z, 20);
    // What the tail loses is missing in the locked amplitude, and T0 takes its place nowhere: the readings disagree.
    EXPECT_LT(Find(symptoms, "T0_from_lock").z, -20);
    EXPECT_GT(Find(symptoms, "T0_from_decrement").z, 10);
  }
}

TEST(Symptoms, RollingFrictionHasItsSizeInTheSentence) {
  rig::Settings settings = PlainLateral(900);
  settings.link.effects.rolling_T_r = 3e-4;
  const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
  // 2 T_r/(k + k1) per half cycle: 0.1068 mm; 2 % for the cycles in which the joint still slides a little.
  EXPECT_NEAR(Find(symptoms, "rolling_loss").measured, 2e3 * 3e-4 / (3.41 + 2.21), 0.002);
}

TEST(Symptoms, ADriftingZeroMovesTheMidLine) {
  rig::Settings settings = PlainLateral(900);
  settings.link.effects.drift_rate = 2e-5;
  const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
  const Symptom& middle = Find(symptoms, "mid_line_in_time");
  EXPECT_GT(middle.z, 50);
  EXPECT_NEAR(middle.measured - middle.modelled, 0.020, 0.0005);  // mm/s; the noise of the slope is 0.0001
  EXPECT_THAT(middle.sentence, HasSubstr("mm/s"));
  EXPECT_TRUE(IsSignificant(symptoms, "drift_line"));
  EXPECT_FALSE(IsSignificant(symptoms, "rolling_loss"));
  EXPECT_FALSE(IsSignificant(symptoms, "unknown_line"));
}

TEST(Symptoms, MainsHumIsALineWithAName) {
  rig::Settings settings = PlainLateral(900);
  settings.link.effects.hum_A = 5e-5;
  const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
  const Symptom& line = Find(symptoms, "mains_line");
  EXPECT_GT(line.z, 20);
  EXPECT_NEAR(line.measured, 0.05, 0.001);  // mm; noise of an amplitude over three records: 0.0003
  EXPECT_THAT(line.sentence, HasSubstr("at 50.0"));
  for (const Symptom& s : symptoms.list)
    if (s.IsSignificant() && s.of_model) {
      EXPECT_THAT((std::set<std::string>{"mains_line", "residual_not_white", "residual_over_noise"}),
                  testing::Contains(s.id))
          << s.sentence;
    }
}

TEST(Symptoms, ABentSensorMakesEvenHarmonics) {
  rig::Settings settings = PlainLateral(900);
  settings.link.effects.nonlinearity_e = 1;
  const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
  EXPECT_GT(Find(symptoms, "second_harmonic").z, 50);
  EXPECT_GT(Find(symptoms, "second_harmonic").z, 5 * std::abs(Find(symptoms, "third_harmonic").z));
  const Symptom& middle = Find(symptoms, "mid_line_against_amplitude");
  EXPECT_GT(middle.z, 50);
  // reading = y + e y^2: at both turns e A^2, in the middle nothing; the mid-line of the turns lies at e A^2.
  EXPECT_NEAR(middle.measured - middle.modelled, 1, 0.1);
  const Symptom& displacement = Find(symptoms, "residual_against_displacement");
  EXPECT_TRUE(displacement.IsSignificant());
  EXPECT_THAT(displacement.sentence, HasSubstr("like its square"));
  EXPECT_FALSE(IsSignificant(symptoms, "rolling_loss"));
}

TEST(Symptoms, TheOtherDirectionIsALineBesideTheMotion) {
  rig::Settings settings = PlainLateral(900);
  settings.link.effects.cross_A = 3e-4;  // 1.3 Hz
  const Symptoms symptoms = FindSymptoms(IdentifyRig(settings));
  const Symptom& line = Find(symptoms, "cross_axis_line");
  EXPECT_GT(line.z, 20);
  EXPECT_THAT(line.sentence, HasSubstr("longitudinal"));
}

TEST(Symptoms, TheFrequencyMethodIsBiasedOnCleanRecords) {
  const Identification id = IdentifyRig(PlainLateral(17));
  const Symptom& bias = Find(FindSymptoms(id), "frequency_method_bias");
  EXPECT_FALSE(bias.of_model);
  EXPECT_GT(bias.z, 20);
  EXPECT_NEAR(bias.modelled, 3.41, 0.02);
  EXPECT_GT(bias.measured, 1.15 * bias.modelled);
  EXPECT_THAT(bias.sentence, HasSubstr("a bias of the method"));
}

TEST(Symptoms, ClippedReadingsAreNoForce) {
  Identification id = IdentifyRig(PlainLateral(23), 1);
  RecordResult& r = id.records[0];
  SymptomInputs inputs(id);
  SymptomInput input = inputs.inputs()[0];
  Record clipped = r.record;
  constexpr double kLevel = 0.012;
  for (double& y : clipped.y) y = std::min(y, kLevel);
  input.record = &clipped;
  const Symptom& limit = Find(FindSymptoms({&input, 1}, Direction::kLateral), "readings_clipped");
  EXPECT_GT(limit.z, 100);
  EXPECT_DOUBLE_EQ(limit.measured, 1e3 * kLevel);
  EXPECT_THAT(limit.sentence, HasSubstr("12.000 mm"));
}

TEST(Symptoms, CurvesAreWhole) {
  const Symptoms symptoms = FindSymptoms(IdentifyRig(PlainLateral(3), 2));
  std::set<std::string> ids;
  for (const SymptomCurve& curve : symptoms.curves) {
    ids.insert(curve.id);
    ASSERT_FALSE(curve.x.empty()) << curve.id;
    for (const auto* column : {&curve.measured, &curve.modelled, &curve.error}) {
      ASSERT_EQ(column->size(), curve.x.size()) << curve.id;
      for (const double value : *column) ASSERT_TRUE(std::isfinite(value)) << curve.id;
    }
    ASSERT_EQ(curve.record.size(), curve.x.size());
    for (const double error : curve.error) ASSERT_GT(error, 0) << curve.id;
  }
  EXPECT_THAT(ids, testing::IsSupersetOf({"loss", "backbone", "envelope", "mid_line", "residual_spectrum",
                                          "residual_against_displacement", "residual_against_time"}));
}

TEST(Symptoms, RefuseWhatDoesNotFitTogether) {
  const Identification id = IdentifyRig(PlainLateral(3), 1);
  const SymptomInputs inputs(id);
  SymptomInput input = inputs.inputs()[0];
  input.sigma = 0;
  EXPECT_THROW(FindSymptoms({&input, 1}, Direction::kLateral), std::invalid_argument);
  input = inputs.inputs()[0];
  input.modelled = input.modelled.first(20);
  EXPECT_THROW(FindSymptoms({&input, 1}, Direction::kLateral), std::invalid_argument);
  EXPECT_TRUE(FindSymptoms(std::span<const SymptomInput>{}, Direction::kLateral).list.empty());
}

}  // namespace
}  // namespace uiclink
