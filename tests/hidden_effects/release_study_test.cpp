// Where does the free decay start? The phases of many blind cases against what the rig knows. UICLINK_LONG=1 takes as
// many cases as the long blind study and prints the same table.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "identify/noise.h"
#include "identify/release.h"
#include "tests/hidden_effects/blind_cases.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

enum Outcome { kRight, kTooEarly, kTooLate, kBeside, kRefused, kOutcomes };
using Counts = std::array<int, kOutcomes>;

int Sum(const Counts& counts) {
  int sum = 0;
  for (const int count : counts) sum += count;
  return sum;
}
int Wrong(const Counts& counts) { return counts[kTooEarly] + counts[kTooLate] + counts[kBeside]; }

/// Right within 30 ms: the shortest half swing is 250 ms, and a mode of 1.5 mm or the other axis (1 mm) beside 14 mm
/// moves the extremum of the reading itself by up to 1.5/14 rad, 18 ms at 6 rad/s, and the fit by some more.
Outcome Judge(const Phases& phases, double first_extremum_s) {
  constexpr double kWithin = 0.030, kHalfSwing = 0.2;
  if (!phases.usable) return kRefused;
  const double error = phases.extrema[0].t - first_extremum_s;
  if (std::abs(error) <= kWithin) return kRight;
  if (std::abs(error) < kHalfSwing) return kBeside;
  return error < 0 ? kTooEarly : kTooLate;
}

void AddCase(int number, std::map<std::string, Counts>* table) {
  constexpr std::uint64_t kStudySeed = 3;  // that of blind_study
  const BlindCase blind = DrawBlindCase(kStudySeed, number);
  const std::string name = blind.effects.empty()             ? std::string(Name(blind.kind)) + ": " + blind.variant
                           : blind.kind == CaseKind::kSingle ? blind.effects[0]
                                                             : std::string(Name(blind.kind));
  for (std::size_t i = 0; i < blind.settings.size(); ++i) {
    const rig::RigRecord made = rig::MakeRecord(blind.settings[i], static_cast<int>(i) + 1);
    Record record = ToRecord(made, Direction::kLateral);
    record.sampling_hz = static_cast<double>(record.t.size() - 1) / record.t.back();
    const Phases phases = FindPhases(record, EstimateNoise(record.t, record.y));
    ++(*table)[name][static_cast<std::size_t>(Judge(phases, made.truth.first_extremum_s))];
  }
}

/// Prints the outcomes of `count` cases of a kind and adds them up.
Counts Study(CaseKind kind, int count) {
  std::map<std::string, Counts> table;
  for (int i = 0; i < count; ++i) AddCase(static_cast<int>(kind) * kCasesPerKind + i, &table);
  Counts sum{};
  fmt::print("{:<32}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}\n", Name(kind), "records", "right", "early", "late", "beside",
             "refused");
  for (const auto& [name, counts] : table) {
    fmt::print("{:<32}{:>8}", name, Sum(counts));
    for (std::size_t k = 0; k < kOutcomes; ++k) fmt::print("{:>8}", counts[k]), sum[k] += counts[k];
    fmt::print("\n");
  }
  return sum;
}

int Choose(int few, int many) { return IsLong() ? many : few; }

TEST(ReleaseStudy, CleanRecordsAndDecoysAreAllRight) {
  for (const auto& [kind, few, many] : {std::tuple(CaseKind::kClean, 30, 300), {CaseKind::kDecoy, 12, 150}}) {
    const Counts counts = Study(kind, Choose(few, many));
    EXPECT_EQ(counts[kRight], Sum(counts));
  }
}

TEST(ReleaseStudy, HiddenEffectsAreNoPush) {
  const int effects = static_cast<int>(ObservableEffects().size());
  const Counts counts = Study(CaseKind::kSingle, Choose(3 * effects, 50 * effects));
  EXPECT_EQ(counts[kRefused], 0);
  EXPECT_LE(100 * Wrong(counts), Sum(counts));  // one in a hundred
}

TEST(ReleaseStudy, PairsHardlyEither) {
  const Counts counts = Study(CaseKind::kPair, Choose(15, 150));
  EXPECT_EQ(counts[kRefused], 0);
  EXPECT_LE(100 * Wrong(counts), 3 * Sum(counts));  // each of the two meddles
}

}  // namespace
}  // namespace uiclink
