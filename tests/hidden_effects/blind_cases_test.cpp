// What the blind study stands on: draws that keep their ranges and can be repeated, and a score that reads answers
// right. The answers are written by hand here.

#include "tests/hidden_effects/blind_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/cli/temporary_folder.h"
#include "tests/hidden_effects/blind_score.h"

namespace uiclink {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

constexpr int kDraws = 400;

TEST(BlindCases, LinksKeepTheirRanges) {
  int above = 0, scattered = 0;
  for (int i = 0; i < kDraws; ++i) {
    const BlindCase blind = DrawBlindCase(1, i);
    scattered += blind.scattered ? 1 : 0;
    ASSERT_EQ(blind.settings.size(), static_cast<std::size_t>(kBlindRecords));
    for (const rig::Settings& s : blind.settings) {
      const rig::Joint& joint = s.link.joints.at(0);
      EXPECT_TRUE(s.link.k >= 2.5 && s.link.k <= 6) << s.link.k;
      EXPECT_TRUE(joint.k / s.link.k >= 0.3 && joint.k / s.link.k <= 4) << joint.k / s.link.k;
      EXPECT_TRUE(joint.T0 >= 0.005 && joint.T0 <= 0.025) << joint.T0;
      const double y_c = joint.T0 / joint.k;
      EXPECT_TRUE(y_c >= 1e-3 && y_c <= 8e-3) << y_c;
      EXPECT_TRUE(s.push.first_extremum >= std::max(14e-3, 2.5 * y_c) && s.push.first_extremum <= 30e-3);
      EXPECT_EQ(s.scatter.k > 0, blind.scattered);
    }
    above += blind.settings[0].link.joints[0].k > blind.settings[0].link.k ? 1 : 0;
  }
  EXPECT_GT(above, kDraws / 5);  // k1 above k and below
  EXPECT_LT(above, kDraws * 4 / 5);
  EXPECT_NEAR(scattered, kDraws / 2, 40);  // four standard deviations of a coin
}

TEST(BlindCases, EveryObservableEffectIsHiddenInTurn) {
  const std::vector<const rig::Effect*> effects = ObservableEffects();
  EXPECT_EQ(effects.size(), rig::EffectCatalogue().size() - 1);
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const BlindCase blind = DrawBlindCase(1, static_cast<int>(i));
    EXPECT_EQ(blind.effects, std::vector<std::string>{effects[i]->id});
    for (const rig::Effect& effect : rig::AllEffects()) {
      const auto size = effect.parameters.front().value;
      const bool acts = blind.settings[0].link.effects.*size != rig::EffectSizes{}.*size;
      EXPECT_EQ(acts, std::string(effect.id) == effects[i]->id) << effect.id;
    }
  }
}

TEST(BlindCases, ValuesStayInsideWhatTheRigAccepts) {
  for (const CaseKind kind : kCaseKinds) {
    for (int i = 0; i < kDraws; ++i) {
      const int number = static_cast<int>(kind) * kCasesPerKind + i;
      const rig::Settings s = DrawBlindCase(1, number).settings[0];
      for (const rig::Effect& effect : rig::AllEffects())
        for (const rig::EffectParameter& p : effect.parameters) {
          const double value = s.link.effects.*p.value;
          EXPECT_TRUE(value >= p.low && value <= p.high)
              << number << ' ' << effect.id << '.' << p.symbol << ' ' << value;
        }
    }
  }
}

TEST(BlindCases, NuisancesAreRelativeToTheMotion) {
  for (int i = 0; i < 19 * 40; ++i) {
    const BlindCase blind = DrawBlindCase(2, i);
    const rig::Settings& s = blind.settings[0];
    const rig::EffectSizes& e = s.link.effects;
    if (std::isfinite(e.saturation_level)) {
      EXPECT_GE(e.saturation_level, 0.699 * blind.swing);
      EXPECT_LE(e.saturation_level, 0.971 * blind.swing);
    }
    if (e.stop_k > 0) {
      EXPECT_LT(std::abs(e.stop_position), 0.971 * blind.swing);
    }
    if (e.extra_k > 0) {
      const double ratio = e.extra_T0 / e.extra_k / (s.link.joints[0].T0 / s.link.joints[0].k);
      EXPECT_GE(std::max(ratio, 1 / ratio), 1.7);
    }
    if (e.cross_A > 0) {
      for (const double K : {s.link.k, s.link.k + s.link.joints[0].k})
        EXPECT_GT(std::abs(std::log(e.cross_f / (std::sqrt(s.link.g * K) / 6.283185307))), 0.08);
    }
  }
}

std::string WriteAndRead(std::uint64_t seed, int number) {
  const TemporaryFolder folder;
  std::string text;
  for (const std::string& file : WriteBlindCase(DrawBlindCase(seed, number), folder.path()).files) {
    std::ostringstream content;
    content << std::ifstream(folder.path() / file).rdbuf();
    text += file + "\n" + content.str();
  }
  return text;
}

TEST(BlindCases, CanBeRepeatedAlone) {
  const std::string once = WriteAndRead(1, 7);
  EXPECT_EQ(WriteAndRead(1, 7), once);
  EXPECT_NE(WriteAndRead(2, 7), once);
  EXPECT_NE(WriteAndRead(1, 8), once);
}

TEST(BlindCases, FilesTellNothing) {
  for (const int number : {2, 10000, 20000, 40000}) {
    const std::string text = WriteAndRead(1, number);
    EXPECT_THAT(text, HasSubstr("record_3.txt"));
    for (const rig::Effect& effect : rig::AllEffects()) EXPECT_THAT(text, testing::Not(HasSubstr(effect.id)));
  }
}

// ---------------------------------------------------------------- score

const char* const kTruth = "viscous_damping";  // of case 0

Json Bounds(double low, double high) { return {{"value", 0.5 * (low + high)}, {"low", low}, {"high", high}}; }

/// An answer that is right in everything when `effect` is kTruth: the truth of kWritten is inside the extended fit's
/// bounds, not inside all of the plain one's.
Json GoodAnswer(const std::string& effect) {
  const Json cause = {{"effect", effect}, {"rivals", Json::array()}};
  return {{"records", Json::array({{{"used", true}, {"reason", nullptr}}})},
          {"fit",
           {{"shared", true},
            {"rms_over_noise", 20.0},
            {"rms_mm", 0.2},
            {"parameters", {{"k", Bounds(3.1, 3.2)}, {"k1", Bounds(1.9, 2.1)}, {"T01", Bounds(0.02, 0.03)}}}}},
          {"diagnosis",
           {{"verdict", "explained"},
            {"causes", Json::array({cause})},
            {"candidates", Json::array({{{"effect", kTruth}, {"rms_over_noise", 1.0}},
                                        {{"effect", "mains_hum"}, {"rms_over_noise", 7.0}},
                                        {{"effect", "sensor_drift"}, {"rms_over_noise", nullptr}},
                                        {{"effect", "quadratic_drag"}, {"rms_over_noise", 4.0}}})}}},
          {"extended_fit",
           {{"rms_over_noise", 1.0},
            {"parameters", {{"k", Bounds(2.9, 3.1)}, {"k1", Bounds(1.9, 2.1)}, {"T01", Bounds(0.009, 0.011)}}}}}};
}

const WrittenCase kWritten{.files = {},
                           .population = {.k = 3, .k1 = 2, .T01 = 0.01},
                           .records_mean = {.k = 3.15, .k1 = 2, .T01 = 0.01},
                           .noise_mm = 0.01};

CaseResult Score(const Json& answer, int number = 0) {
  CaseResult result;
  result.blind = DrawBlindCase(1, number);
  ReadAnswer(answer.dump(), kWritten, &result);
  return result;
}

TEST(BlindScore, ARightAnswerIsRight) {
  const CaseResult r = Score(GoodAnswer(kTruth));
  EXPECT_EQ(r.fault, "");
  EXPECT_EQ(r.best_wrong, 4);
  EXPECT_EQ(r.best_wrong_effect, "quadratic_drag");
  EXPECT_TRUE(Counts(r) && IsNamedAlone(r) && IsNamedOrRival(r));
  EXPECT_EQ(r.plain_inside.records, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(r.extended_inside.records, (std::array<bool, 3>{true, true, true}));
}

TEST(BlindScore, RivalsAndFurtherCausesAreNotAlone) {
  Json answer = GoodAnswer("quadratic_drag");
  answer["diagnosis"]["causes"][0]["rivals"] = {kTruth};
  EXPECT_TRUE(!IsNamedAlone(Score(answer)) && IsNamedOrRival(Score(answer)));
  answer["diagnosis"]["causes"][0]["rivals"] = {kTruth, "mains_hum", "clearance"};
  EXPECT_FALSE(IsNamedOrRival(Score(answer)));  // four names are no answer
  answer = GoodAnswer(kTruth);
  answer["diagnosis"]["causes"].push_back({{"effect", "mains_hum"}, {"rivals", Json::array()}});
  EXPECT_TRUE(!IsNamedAlone(Score(answer)) && IsNamedOrRival(Score(answer)));
  EXPECT_FALSE(IsNamedOrRival(Score(GoodAnswer("mains_hum"))));
}

TEST(BlindScore, AnEffectThatOthersReplaceDoesNotCount) {
  Json answer = GoodAnswer(kTruth);
  answer["diagnosis"]["candidates"][3]["rms_over_noise"] = 2.9;
  EXPECT_FALSE(Counts(Score(answer)));
  answer["diagnosis"]["candidates"] = Json::array();  // nothing was fitted: the plain model is the best wrong one
  EXPECT_EQ(Score(answer).best_wrong, 20);
}

TEST(BlindScore, AnOverestimatedNoiseHidesNothing) {
  Json answer = GoodAnswer(kTruth);
  answer["fit"]["rms_over_noise"] = 2.0;  // of a noise told ten times too large: 0.1 mm
  answer["diagnosis"]["candidates"][3]["rms_over_noise"] = 0.4;
  const CaseResult r = Score(answer);
  EXPECT_DOUBLE_EQ(r.plain, 20);
  EXPECT_DOUBLE_EQ(r.best_wrong, 4);
  EXPECT_TRUE(Counts(r));
}

TEST(BlindScore, ScatteredLinksAreComparedWithTheRecordsOwnMean) {
  Json answer = GoodAnswer(kTruth);
  answer["fit"]["shared"] = false;
  const CaseResult r = Score(answer);
  EXPECT_TRUE(r.plain_inside.records[0] && !r.plain_inside.population[0]);
  EXPECT_TRUE(!r.extended_inside.records[0] && r.extended_inside.population[0]);
}

TEST(BlindScore, WhatIsMissingIsAFault) {
  Json answer = GoodAnswer(kTruth);
  answer.erase("diagnosis");
  EXPECT_THAT(Score(answer).fault, HasSubstr("no `diagnosis`"));
  EXPECT_EQ(Score(answer).plain, 20);
  answer = GoodAnswer(kTruth);
  answer.erase("extended_fit");
  EXPECT_THAT(Score(answer).fault, HasSubstr("no `extended_fit`"));
  answer = GoodAnswer(kTruth);
  answer["diagnosis"].erase("candidates");
  EXPECT_THAT(Score(answer).fault, HasSubstr("candidates"));
  answer = GoodAnswer(kTruth);
  answer["records"][0] = {{"used", false}, {"reason", "too short"}};
  EXPECT_THAT(Score(answer).fault, HasSubstr("too short"));
  EXPECT_EQ(Summarise({Score(answer)}).faults, 1);
}

TEST(BlindScore, SummaryCounts) {
  const int clean = kCasesPerKind, pair = 3 * kCasesPerKind, outside = 4 * kCasesPerKind;
  Json quiet = GoodAnswer(kTruth);
  quiet["diagnosis"]["verdict"] = "adequate";
  quiet["diagnosis"]["causes"] = Json::array();
  Json both = GoodAnswer(DrawBlindCase(1, pair).effects[0]);
  both["diagnosis"]["candidates"] = Json::array();
  Json half = both;
  both["diagnosis"]["causes"].push_back({{"effect", DrawBlindCase(1, pair).effects[1]}, {"rivals", Json::array()}});
  Json wrong = GoodAnswer("clearance");
  wrong["diagnosis"]["candidates"] = Json::array();
  const Summary s = Summarise({Score(GoodAnswer(kTruth)), Score(GoodAnswer("mains_hum")), Score(quiet, clean),
                               Score(GoodAnswer(kTruth), clean), Score(quiet, clean + 1), Score(both, pair),
                               Score(half, pair), Score(quiet, outside), Score(wrong, outside)});
  const auto is = [](const Share& share, int right, int all) { return share.right == right && share.all == all; };
  EXPECT_TRUE(is(s.alone, 1, 2));
  EXPECT_TRUE(is(s.named_or_rival, 1, 2));
  EXPECT_TRUE(is(s.false_alarms, 1, 3));
  EXPECT_TRUE(is(s.pairs_found, 1, 2));
  EXPECT_TRUE(is(s.outside_adequate, 0, 1));  // quiet: viscous_damping alone reaches the noise, so it does not count
  EXPECT_TRUE(is(s.outside_explained, 1, 1));
  EXPECT_TRUE(is(s.all_outside_adequate, 1, 2));
  EXPECT_TRUE(is(s.extended_inside[0], 2, 2));
  EXPECT_TRUE(is(s.plain_inside[0], 0, 2));
}

TEST(BlindScore, MatrixHasTruthDownAndAnswersAcross) {
  const std::string study = FormatStudy({Score(GoodAnswer(kTruth)), Score(GoodAnswer("mains_hum"))});
  EXPECT_THAT(study, HasSubstr("| hidden \\ named first | mains_hum | viscous_damping |\n"
                               "| --- | ---: | ---: |\n| viscous_damping | 1 | **1** |\n"));
}

}  // namespace
}  // namespace uiclink
