// Links that are drawn for the runs of a campaign: from the covariance of their sets, from corner to corner, by seed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/input_error.h"
#include "tests/cli/temporary_folder.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;

/// A set whose lateral k and T01 were identified together, and whose k differs from link to link.
constexpr const char* kSet = R"(
name = "identified"
source = "test"
load_N = 3714.0
[lateral]
k = 4.0
sliders = [{ k = 1.0, T0 = 0.01 }]
covariance = { order = ["k", "T01"], matrix = [[0.01, -6e-5], [-6e-5, 1e-6]], spread = { k = 0.2 } }
[longitudinal]
k = 6.0
sliders = []
)";

class Draws : public testing::Test {
 protected:
  Draws() { folder_.Write("set.toml", kSet); }

  SweepPlan Plan(const std::string& text) const {
    return SweepPlan(
        ParseCampaign("name = \"test\"\n" + text + "[run]\nkind = \"modes\"\n", folder_.path() / "c.toml"));
  }
  /// The wagons of `n` samples of the set.
  SweepPlan Drawn(const std::string& draw, int n, const std::string& first = "") const {
    return Plan(first + "[base]\nset = \"set.toml\"\ndraw = \"" + draw + "\"\n[sample]\nn = " + std::to_string(n) +
                "\n");
  }
  static std::vector<double> Column(const SweepPlan& plan, std::size_t column) {
    std::vector<double> values;
    for (std::size_t run = 0; run < plan.size(); ++run) values.push_back(plan.Drawn(run).at(column).value());
    return values;
  }
  std::string Fault(const std::string& text) const {
    try {
      Plan(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double Product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - Mean(a)) * (b[i] - Mean(b));
  return sum / static_cast<double>(a.size());
}

TEST_F(Draws, HaveTheCovarianceOfTheSet) {
  constexpr int kSamples = 2000;
  const SweepPlan plan = Drawn("set", kSamples);
  ASSERT_THAT(plan.drawn_columns(), ElementsAre("drawn_lateral_k", "drawn_lateral_T01"));
  const std::vector<double> k = Column(plan, 0), T0 = Column(plan, 1);
  // Four standard errors: of a mean s/sqrt(n), of a covariance at most s1 s2 sqrt(2/n).
  const double n = kSamples;
  EXPECT_NEAR(Mean(k), 4, 4 * 0.1 / std::sqrt(n));
  EXPECT_NEAR(Mean(T0), 0.01, 4 * 1e-3 / std::sqrt(n));
  EXPECT_NEAR(Product(k, k), 0.01, 4 * 0.01 * std::sqrt(2 / n));
  EXPECT_NEAR(Product(T0, T0), 1e-6, 4 * 1e-6 * std::sqrt(2 / n));
  EXPECT_NEAR(Product(k, T0), -6e-5, 4 * 1e-4 * std::sqrt(2 / n));
}

TEST_F(Draws, AreInTheWagonAndTheSameAtAllCornersOfASet) {
  const SweepPlan plan = Drawn("set", 3);
  for (std::size_t run = 0; run < plan.size(); ++run) {
    const auto wagon = plan.shelf().Get(plan.Setup(run));
    for (std::size_t corner = 0; corner < kCorners; ++corner) {
      EXPECT_EQ(wagon->lateral[corner].law().k, plan.Drawn(run)[0]);
      EXPECT_EQ(wagon->longitudinal[corner].law().k, 6) << "nothing is known of its error";
    }
  }
}

TEST_F(Draws, OfCornersAreFactorsOnTheSpreadThatTheSetHas) {
  const SweepPlan plan = Drawn("corners", 1), both = Drawn("set+corners", 1);
  ASSERT_THAT(plan.drawn_columns(), ElementsAre("factor_lateral_k_front_left", "factor_lateral_k_front_right",
                                                "factor_lateral_k_rear_left", "factor_lateral_k_rear_right"));
  ASSERT_EQ(both.drawn_columns().size(), 6u);
  const auto one = plan.shelf().Get(plan.Setup(0)), two = both.shelf().Get(both.Setup(0));
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const double factor = *plan.Drawn(0)[corner];
    EXPECT_GT(std::abs(factor - 1), 1e-4);
    EXPECT_LT(std::abs(factor - 1), 6 * 0.2 / 4);
    EXPECT_EQ(one->lateral[corner].law().k, 4 * factor);
    EXPECT_EQ(two->lateral[corner].law().k, *both.Drawn(0)[0] * factor) << "the same factors with draws of the set";
  }
}

TEST_F(Draws, DependOnSeedAndSampleAlone) {
  const SweepPlan few = Drawn("set", 3), many = Drawn("set", 5), other = Drawn("set", 3, "seed = 1\n");
  EXPECT_THAT(Column(many, 0), IsSupersetOf(Column(few, 0))) << "more samples leave the others as they are";
  for (std::size_t run = 0; run < few.size(); ++run) {
    EXPECT_EQ(few.Id(run), many.Id(run));
    EXPECT_EQ(few.Drawn(run), Drawn("set", 3).Drawn(run));
    EXPECT_NE(few.Drawn(run), other.Drawn(run));
    EXPECT_NE(few.Id(run), other.Id(run));
  }
}

TEST_F(Draws, WithoutSamplesAreIdentifiedByTheirSeed) {
  for (const char* const what : {"draw = \"set\"\n", "scatter_percent = 5\n"}) {
    const std::string text = std::string("[base]\nset = \"set.toml\"\n") + what;
    EXPECT_NE(Plan(text).Id(0), Plan("seed = 1\n" + text).Id(0)) << what;
  }
}

TEST_F(Draws, AreRefusedWhereTheSetHasNoCovariance) {
  EXPECT_THAT(Fault("[base]\ndraw = \"set\"\n[sample]\nn = 2\n"),
              HasSubstr("set set1: expected a covariance to draw from (identify writes one), found none"));
  EXPECT_THAT(Fault("[base]\ndraw = \"corners\"\n[grid]\nset = [\"set.toml\", \"set1\"]\n[sample]\nn = 2\n"),
              HasSubstr("set set1: expected a covariance with a spread between links"));
  EXPECT_THAT(Fault("[base]\ndraw = \"nothing\"\n"), IsEmpty());
}

TEST_F(Draws, AreColumnsOfTheStore) {
  const SweepPlan plan = Drawn("set", 2);
  const std::filesystem::path store = folder_.path() / "a.sqlite";
  const FinishedRun done{.run = 1, .outcome = {.values = {0.25, 1, 3}}, .wall_s = 0.5};
  SweepStore(store, plan, "1", SweepStore::Existing::kGoOn).Write({done});
  EXPECT_THAT(SweepStore::FormatCsv(store), HasSubstr(",speed,drawn_lateral_k,drawn_lateral_T01,growth_per_s,"));
  Sqlite database(store, Sqlite::Mode::kReadWrite);
  SqliteStatement query(&database, "SELECT drawn_lateral_k, drawn_lateral_T01 FROM runs");
  ASSERT_TRUE(query.Step());
  EXPECT_EQ(query.Number(0), plan.Drawn(1)[0]);
  EXPECT_EQ(query.Number(1), plan.Drawn(1)[1]);
}

TEST_F(Draws, ComeToAStoreThatGrows) {
  const std::filesystem::path store = folder_.path() / "a.sqlite";
  const std::string grid = "[base]\nset = \"set.toml\"\n[grid]\ndraw = [\"nothing\"";
  SweepStore(store, Plan(grid + "]\n"), "1", SweepStore::Existing::kGoOn)
      .Write({{.run = 0, .outcome = {.values = {0.25, 1, 3}}, .wall_s = 0.5}});
  const SweepStore grown(store, Plan(grid + ", \"set\"]\n"), "1", SweepStore::Existing::kGoOn);
  EXPECT_THAT(grown.missing(), ElementsAre(1));
}

}  // namespace
}  // namespace uiclink
