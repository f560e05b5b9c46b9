// Records in which nothing is hidden: how often does an effect of the catalogue do well by chance?
//
// Each case is one link drawn as in the blind study, as is, scattered from record to record, or with a friction
// asymmetry that nobody can see. The whole pipeline runs: the rig's noise, converter and pushes, release, fits, the
// test whether the records share their link, and every effect's trial. CalcFamilyWiseP() is right when the smallest p
// of a case is below p0 in at most a share p0 of the cases.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "identify/effect_search.h"
#include "identify/family_wise.h"
#include "identify/identification.h"
#include "identify/link_coordinates.h"
#include "measurements/rig/rig.h"
#include "tests/hidden_effects/blind_cases.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

/// Not the blind study's: thresholds are not set on what they are judged by. Nor 1965, whose cases F was fitted to.
constexpr std::uint64_t kStudySeed = 2003;
constexpr int kFirstClean = 1 * kCasesPerKind;

/// The records of a clean case. It is drawn with three; further ones start between its smallest and largest extremum.
std::vector<Record> MakeCleanRecords(int number, int count) {
  const BlindCase blind = DrawBlindCase(kStudySeed, kFirstClean + number);
  double low = 1, high = 0;
  for (const rig::Settings& s : blind.settings) {
    low = std::min(low, s.push.first_extremum);
    high = std::max(high, s.push.first_extremum);
  }
  std::mt19937_64 random(kStudySeed + static_cast<std::uint64_t>(number));
  std::uniform_real_distribution<double> extremum(low, high);
  std::vector<Record> records;
  for (int i = 0; i < count; ++i) {
    rig::Settings settings = blind.settings[static_cast<std::size_t>(i % kBlindRecords)];
    if (i >= kBlindRecords) settings.push.first_extremum = extremum(random);
    records.push_back(ToRecord(rig::MakeRecord(settings, i + 1), Direction::kLateral));
  }
  return records;
}

/// The smallest p of the catalogue, and whose it was.
struct Chance {
  double p = 1;
  std::string effect;
};

/// How the diagnosis starts: the plain fit once more as the search does it, with one link or one per record.
struct PlainStart {
  std::vector<FitData> data;
  Sharing sharing = Sharing::kLink;
  ExtendedState state;
  double samples = 0;
};

PlainStart Collect(const Identification& id) {
  PlainStart start;
  start.sharing = id.shared ? Sharing::kLink : Sharing::kShape;
  Levels levels;
  FromOscillator(id.link, &levels, &start.state.link.shape);
  if (id.shared) start.state.link.levels = {levels};
  for (const std::size_t i : id.UsedIndices()) {
    const RecordResult& record = id.records[i];
    start.data.push_back(record.Data());
    start.samples += static_cast<double>(start.data.back().size);
    start.state.link.starts.push_back(record.start);
    if (id.shared) continue;
    Shape shape;
    FromOscillator(record.link, &levels, &shape);
    start.state.link.levels.push_back(levels);
  }
  start.state.own.resize(start.data.size());
  return start;
}

Chance FindSmallestP(const Identification& id) {
  const PlainStart start = Collect(id);
  const EffectSearch search(start.data, start.sharing, {.threads = 1, .progress = {}});
  const ExtendedOutcome plain = search.Refit(Extension(), start.state);
  std::vector<const Effect*> tried;
  for (const Effect* effect : Effects())
    if (effect->unseen.empty()) tried.push_back(effect);
  Chance smallest;
  for (const EffectFit& fit : search.Try(Extension(), plain, tried)) {
    const double statistic = fit.refitted ? start.samples * std::log(plain.chi2 / fit.outcome.chi2) : fit.score;
    const double p = CalcFamilyWiseP(statistic, fit.unknowns, fit.alternatives, start.data.size());
    if (p < smallest.p) smallest = {.p = p, .effect = std::string(fit.effect->id)};
  }
  return smallest;
}

/// P(X > limit) of a binomial variable: its probabilities one after the other.
double CalcBinomialTail(int n, double p, int limit) {
  double tail = 0;
  for (int x = limit + 1; x <= n; ++x)
    tail += std::exp(std::lgamma(n + 1.0) - std::lgamma(x + 1.0) - std::lgamma(n - x + 1.0) + x * std::log(p) +
                     (n - x) * std::log1p(-p));
  return tail;
}

constexpr double kLevels[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};

/// A level fails when so many cases below it have a probability of less than 1e-4 were p exact. Six levels: a study
/// fails falsely once in 1700 at most, with another seed; with this one it holds, or shows a change.
constexpr double kFalseFailure = 1e-4;

void RunStudy(int cases, int records) {
  std::vector<double> smallest;
  std::map<std::string, int> whose;
  int sharing = 0;
  for (int i = 0; i < cases; ++i) {
    IdentifyOptions options;
    options.threads = 1;
    const Identification id = Identify(Direction::kLateral, MakeCleanRecords(i, records), options);
    ASSERT_EQ(id.CountUsed(), records) << "case " << i;
    const Chance chance = FindSmallestP(id);
    smallest.push_back(chance.p);
    sharing += id.shared ? 1 : 0;
    if (chance.p < kLevels[0]) ++whose[chance.effect];
    if (IsLong())
      std::printf("case %d of %d record(s): p = %.6g, %s, one link: %d\n", i, records, chance.p, chance.effect.c_str(),
                  id.shared);
  }
  std::printf("%d cases of %d record%s (%d with one link):", cases, records, records == 1 ? "" : "s", sharing);
  for (const double level : kLevels) {
    const auto below =
        static_cast<int>(std::count_if(smallest.begin(), smallest.end(), [&](double p) { return p < level; }));
    std::printf("  P(p < %g) = %.3f", level, static_cast<double>(below) / cases);
    int limit = 0;
    while (CalcBinomialTail(cases, level, limit) > kFalseFailure) ++limit;
    EXPECT_LE(below, limit) << "of " << cases << " cases of " << records << " records have p < " << level;
  }
  std::printf("\n  below %g:", kLevels[0]);
  for (const auto& [effect, count] : whose) std::printf("  %s %d", effect.c_str(), count);
  std::printf("\n");
}

TEST(FalseAlarms, ThreeRecordsKeepTheirProbability) { RunStudy(IsLong() ? 600 : 40, 3); }

TEST(FalseAlarms, OneRecordKeepsItsProbability) {
  if (!IsLong()) GTEST_SKIP() << "long form only";
  RunStudy(400, 1);
}

TEST(FalseAlarms, TenRecordsKeepTheirProbability) {
  if (!IsLong()) GTEST_SKIP() << "long form only";
  RunStudy(150, 10);
}

}  // namespace
}  // namespace uiclink
