// Columns of extended models in the hot loop of a fit.

#include "identify/extended_columns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

class EveryColumn : public testing::TestWithParam<const Effect*> {};

/// Closed forms, integrated motions and readings alike; the first evaluation takes what the others use again.
TEST_P(EveryColumn, AllocatesNothingTheSecondTime) {
  for (const int sliders : {1, 4}) {
    const SyntheticRecords made = MakeSynthetic({GetParam()}, {{.seconds = 4}}, {.sliders = sliders});
    const ExtendedState& s = made.truth;
    ExtendedColumns columns(made.extension, sliders);
    const auto evaluate = [&](bool derivatives) {
      return columns.Evaluate(made.data[0], made.data[0].size, 1, s.link.levels[0].data(), s.link.shape.data(),
                              s.link.starts[0].data(), s.shared.data(), s.own[0].data(), derivatives);
    };
    for (const bool derivatives : {false, true}) {
      ASSERT_TRUE(evaluate(derivatives));
      const std::size_t before = CountAllocations();
      ASSERT_TRUE(evaluate(derivatives));
      EXPECT_EQ(CountAllocations() - before, 0u) << sliders << " sliders, derivatives: " << derivatives;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryColumn, testing::ValuesIn(Effects().begin(), Effects().end()),
                         [](const auto& test) { return std::string(test.param->id); });

/// The counter counts: the first evaluation does take memory.
TEST(ExtendedColumns, TakeMemoryTheFirstTime) {
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, {{.seconds = 4}});
  const ExtendedState& s = made.truth;
  ExtendedColumns columns(made.extension, 1);
  const std::size_t before = CountAllocations();
  ASSERT_TRUE(columns.Evaluate(made.data[0], made.data[0].size, 1, s.link.levels[0].data(), nullptr,
                               s.link.starts[0].data(), s.shared.data(), nullptr, true));
  EXPECT_GT(CountAllocations() - before, 0u);
}

}  // namespace
}  // namespace uiclink
