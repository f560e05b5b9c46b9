// Which parameter set is used for which link, and what a result says it stands on.

#include "vehicle/wagon_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "data/checksum.h"
#include "data/input_error.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class WagonLinks : public testing::Test {
 protected:
  /// A set with that main stiffness in the directions given.
  std::string WriteSet(const std::string& name, double k, bool lateral = true, bool longitudinal = true,
                       double g = 9.82) const {
    std::string text = "name = \"" + name + "\"\nsource = \"test\"\nload_N = 3714.0\ng = " + std::to_string(g) + "\n";
    const std::string direction = "k = " + std::to_string(k) + "\nsliders = [ { k = 1.0, T0 = 0.01 } ]\n";
    if (lateral) text += "[lateral]\n" + direction;
    if (longitudinal) text += "[longitudinal]\n" + direction;
    folder_.Write(name + ".toml", text);
    return (folder_.path() / (name + ".toml")).string();
  }

  static WagonInputs Read(const std::vector<std::string>& sets) {
    WagonInputs inputs;
    ReadWagonLinks({.sets = sets}, &inputs);
    return inputs;
  }

  /// Lateral stiffnesses of the corners.
  static std::vector<double> Lateral(const WagonInputs& inputs) {
    std::vector<double> k;
    for (const CornerLinks& links : inputs.links) k.push_back(links.lateral.k);
    return k;
  }
  static std::vector<double> Longitudinal(const WagonInputs& inputs) {
    std::vector<double> k;
    for (const CornerLinks& links : inputs.links) k.push_back(links.longitudinal.k);
    return k;
  }

  static std::string Fault(const std::vector<std::string>& sets) {
    try {
      Read(sets);
    } catch (const UsageError& error) {
      return error.what();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(WagonLinks, AreThoseOfSet1Unasked) {
  const WagonInputs inputs = Read({});
  EXPECT_THAT(Lateral(inputs), testing::Each(4.2010));  // table 4.1
  EXPECT_THAT(Longitudinal(inputs), testing::Each(6.4763));
  EXPECT_THAT(inputs.notices, IsEmpty());
  ASSERT_EQ(inputs.files.size(), 1u);
  EXPECT_EQ(inputs.files[0].role, "set");
  EXPECT_EQ(inputs.files[0].sha256, CalcFileSha256(inputs.files[0].path));
  EXPECT_EQ(inputs.files[0].used_for.size(), 8u);
}

TEST_F(WagonLinks, ANarrowerPlaceWinsWhateverTheOrder) {
  const std::string all = WriteSet("all", 1), lateral = WriteSet("lateral", 2), rear = WriteSet("rear", 3),
                    corner = WriteSet("corner", 4), one = WriteSet("one", 5);
  std::vector<std::string> sets{all, "lateral=" + lateral, "rear=" + rear, "front-left=" + corner,
                                "rear-right.longitudinal=" + one};
  std::ranges::sort(sets);
  do {
    const WagonInputs inputs = Read(sets);
    ASSERT_THAT(Lateral(inputs), ElementsAre(4, 2, 3, 3));
    ASSERT_THAT(Longitudinal(inputs), ElementsAre(4, 1, 3, 5));
    ASSERT_THAT(inputs.notices, IsEmpty());
  } while (std::ranges::next_permutation(sets).found);
}

TEST_F(WagonLinks, TwoSetsForOnePlaceAreNamed) {
  const std::string a = WriteSet("a", 1), b = WriteSet("b", 2);
  EXPECT_EQ(Fault({a, b}), "--set: expected one set for each place, found two: " + a + " and " + b);
  EXPECT_THAT(Fault({"lateral=" + a, "lateral=" + b}), HasSubstr("expected one set for each place"));
  EXPECT_EQ(Fault({"lateral=" + a, "longitudinal=" + b}), "");
}

TEST_F(WagonLinks, AnUnknownPlaceIsNamed) {
  EXPECT_THAT(Fault({"latteral=set1"}), HasSubstr("before '=', found \"latteral\""));
  EXPECT_THAT(Fault({"front-left.vertical=set1"}), HasSubstr("found \"front-left.vertical\""));
  EXPECT_THAT(Fault({"lateral.front-left=set1"}), HasSubstr("found \"lateral.front-left\""));
}

TEST_F(WagonLinks, ADirectionThatWasNotMeasuredComesFromSet1AndIsSaidSo) {
  const std::string set = WriteSet("measured", 3, true, false);
  const WagonInputs inputs = Read({set});
  EXPECT_THAT(Lateral(inputs), testing::Each(3));
  EXPECT_THAT(Longitudinal(inputs), testing::Each(6.4763));
  ASSERT_EQ(inputs.notices.size(), 1u);
  EXPECT_EQ(
      inputs.notices[0],
      set +
          " has no longitudinal direction: it comes from set1 (front_left.longitudinal, front_right.longitudinal, "
          "rear_left.longitudinal, rear_right.longitudinal)");
  ASSERT_EQ(inputs.files.size(), 2u);
}

TEST_F(WagonLinks, LinksWithoutASetAreSaidSo) {
  const WagonInputs inputs = Read({"lateral=" + WriteSet("measured", 3)});
  EXPECT_THAT(Longitudinal(inputs), testing::Each(6.4763));
  EXPECT_THAT(inputs.notices, ElementsAre(HasSubstr("no set is given: it comes from set1 (front_left.longitudinal")));
}

TEST_F(WagonLinks, SetsThatAreNotUsedAreNotPartOfTheResult) {
  const std::string all = WriteSet("all", 1), lateral = WriteSet("lateral", 2),
                    longitudinal = WriteSet("longitudinal", 3);
  const WagonInputs inputs = Read({all, "lateral=" + lateral, "longitudinal=" + longitudinal});
  std::vector<std::string> names;
  for (const InputFile& file : inputs.files) names.push_back(file.name);
  EXPECT_THAT(names, testing::UnorderedElementsAre("lateral", "longitudinal"));
}

TEST_F(WagonLinks, EffectsOfRigAndSensorAreLeftOutWithANotice) {
  folder_.Write("extended.toml",
                "name = \"extended\"\nsource = \"test\"\nload_N = 3714.0\n"
                "[lateral]\nk = 4.0\nsliders = [ { k = 1.0, T0 = 0.01 } ]\n"
                "effects = [ { id = \"viscous_damping\", c = 0.01 }, { id = \"sensor_drift\" } ]\n");
  const WagonInputs inputs = Read({"lateral=" + (folder_.path() / "extended.toml").string(), "longitudinal=set1"});
  ASSERT_EQ(inputs.notices.size(), 1u);
  EXPECT_THAT(inputs.notices[0], HasSubstr("effect sensor_drift of "));
  EXPECT_THAT(inputs.notices[0], HasSubstr("has no place on a wagon and is left out"));
}

// The numbers of a set are per unit of load: forces on the wagon are the numbers times the load, whatever g they were
// divided with.
TEST_F(WagonLinks, SetsOfDifferentGravityCanShareACorner) {
  const std::string a = WriteSet("a", 1), b = WriteSet("b", 2, true, true, 9.81), same = WriteSet("c", 2);
  const auto force = [&](const std::string& longitudinal) {
    const CornerLinks links = Read({"lateral=" + a, "longitudinal=" + longitudinal}).links[0];
    const Link link(links.longitudinal, links.g, 1e4);
    return LinkState::AtRest(link, 0).CalcForce(link, 3e-3, 0);
  };
  EXPECT_EQ(force(b), force(same));
  EXPECT_NE(force(b), force(a));
}

TEST_F(WagonLinks, FaultsOfASetNameFileAndLine) {
  folder_.Write("bad.toml", "name = \"bad\"\nsource = \"\"\nload_N = 1.0\n[lateral]\nk = -3.0\nsliders = []\n");
  EXPECT_THAT(Fault({(folder_.path() / "bad.toml").string()}), HasSubstr("bad.toml:5: expected k > 0 [1/m], found -3"));
}

TEST(WagonBody, KnowsFreightAndItsFiles) {
  WagonInputs inputs;
  ReadWagonBody({.cargo = "water"}, &inputs);
  EXPECT_TRUE(inputs.loaded);
  EXPECT_EQ(inputs.files.size(), 2u);
  EXPECT_EQ(inputs.files[0].role, "wagon");
  EXPECT_EQ(inputs.files[1].role, "cargo");
  EXPECT_NEAR(inputs.body.m, 13563 + 20000, 0.5);  // tables 7.1 and 7.2, printed without decimals
  WagonInputs empty;
  ReadWagonBody({}, &empty);
  EXPECT_FALSE(empty.loaded);
}

}  // namespace
}  // namespace uiclink
