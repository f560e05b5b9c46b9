#include "data/parameter_set_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

template <typename Error>
std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string ParseMessage(const std::string& text) {
  return MessageOf<InputError>([&] { ParseParameterSet(text, "set.toml"); });
}

auto IsSlider(double k, double T0) { return AllOf(Field(&Slider<double>::k, k), Field(&Slider<double>::T0, T0)); }

// --- the shipped sets ---

fs::path Shipped(const std::string& name) { return fs::path(UICLINK_SOURCE_DIR) / "data" / "parameter_sets" / name; }

TEST(ShippedParameterSets, FirstIsTableFourOne) {
  const ParameterSet set = ReadParameterSet(Shipped("set1.toml"));
  EXPECT_EQ(set.name, "set 1");
  EXPECT_NEAR(set.load_N, 378.2 * 9.82, 0.5);  // thesis, 4.2: mass on the links; rounded to a newton
  EXPECT_EQ(set.g, 9.82);
  ASSERT_TRUE(set.lateral && set.longitudinal);
  EXPECT_EQ(set.lateral->k, 4.2010);
  EXPECT_THAT(set.lateral->sliders, ElementsAre(IsSlider(1.4222, 0.014)));
  EXPECT_EQ(set.longitudinal->k, 6.4763);
  EXPECT_THAT(set.longitudinal->sliders,
              ElementsAre(IsSlider(2.00, 6e-3), IsSlider(0.50, 3e-3), IsSlider(0.37, 2e-3), IsSlider(0.50, 2e-3)));
  EXPECT_TRUE(set.lateral->effects.empty() && set.longitudinal->effects.empty());
}

TEST(ShippedParameterSets, SecondIsTableFourTwo) {
  const ParameterSet set = ReadParameterSet(Shipped("set2.toml"));
  EXPECT_EQ(set.name, "set 2");
  EXPECT_EQ(set.g, 9.82);
  ASSERT_TRUE(set.lateral && set.longitudinal);
  EXPECT_EQ(set.lateral->k, 3.413);
  EXPECT_THAT(set.lateral->sliders, ElementsAre(IsSlider(10.503, 0.018)));
  EXPECT_EQ(set.longitudinal->k, 5.50);
  EXPECT_THAT(set.longitudinal->sliders, ElementsAre(IsSlider(3.44, 6.98e-3), IsSlider(2.00, 5.11e-3),
                                                     IsSlider(0.33, 0.91e-3), IsSlider(1.90, 7.16e-3)));
}

// --- the format ---

constexpr char kExtended[] = R"(name = "fit"
source = "ten records"
load_N = 3714
[lateral]
k = 4.0
sliders = [ { k = 1.5, T0 = 0 } ]
effects = [ { id = "viscous_damping", c = 0.012 }, { id = "stribeck_friction", zeta = 0.3, a = -1 } ]
std = { k = 0.1, k1 = 0.2, T01 = 0.001, "viscous_damping.c" = 0.003 }
[lateral.covariance]
order = ["T01", "k", "viscous_damping.c"]
matrix = [ [1e-6, 1e-6, 0.0], [1e-6, 0.01, -1e-5], [0.0, -1e-5, 9e-6] ]
)";

TEST(ParameterSetFile, CarriesExtendedSets) {
  const ParameterSet set = ParseParameterSet(kExtended, "set.toml");
  EXPECT_EQ(set.name, "fit");
  EXPECT_EQ(set.source, "ten records");
  EXPECT_EQ(set.load_N, 3714);
  EXPECT_EQ(set.g, kThesisGravity);  // where the file does not say
  EXPECT_FALSE(set.longitudinal);
  ASSERT_TRUE(set.lateral);
  ASSERT_EQ(set.lateral->effects.size(), 2);
  EXPECT_EQ(set.lateral->effects[1].id, "stribeck_friction");
  EXPECT_THAT(set.lateral->effects[1].parameters, ElementsAre(testing::Pair("zeta", 0.3), testing::Pair("a", -1)));
  EXPECT_EQ(set.lateral->std.at("T01"), 0.001);
  EXPECT_EQ(set.lateral->std.at("viscous_damping.c"), 0.003);
  ASSERT_TRUE(set.lateral->covariance);
  EXPECT_EQ(set.lateral->covariance->matrix[1][2], -1e-5);
}

constexpr char kWithSpread[] = R"(name = "fit"
source = "ten records"
load_N = 3714
[lateral]
k = 4.0
sliders = [ { k = 1.5, T0 = 0.02 } ]
effects = [ { id = "viscous_damping", c = 0.012 } ]
[lateral.covariance]
order = ["k", "k1"]
coverage = 2.262
spread = { k = 0.08, k1 = 0.05, T01 = 0, "viscous_damping.c" = 1e-3 }
matrix = [ [0.01, 0.0], [0.0, 0.04] ]
)";

TEST(ParameterSetFile, CarriesCoverageAndSpread) {
  const ParameterSet set = ParseParameterSet(kWithSpread, "set.toml");
  const Covariance& covariance = set.lateral->covariance.value();
  EXPECT_EQ(covariance.coverage, 2.262);
  EXPECT_THAT(covariance.spread, ElementsAre(testing::Pair("T01", 0), testing::Pair("k", 0.08),
                                             testing::Pair("k1", 0.05), testing::Pair("viscous_damping.c", 1e-3)));
  EXPECT_THAT(FormatParameterSet(set), HasSubstr(R"(
covariance = { order = ["k", "k1"], coverage = 2.262, spread = { k = 0.08, k1 = 0.05, T01 = 0.0, "viscous_damping.c" = 0.001 }, matrix = [  # products of the parameters' units
  [0.01, 0.0],
  [0.0, 0.04],
] }
)"));
  // A file that says nothing of them, as all did once.
  const ParameterSet old = ParseParameterSet(kExtended, "set.toml");
  EXPECT_FALSE(old.lateral->covariance->coverage);
  EXPECT_TRUE(old.lateral->covariance->spread.empty());
}

TEST(ParameterSetFile, IsWrittenForPeople) {
  EXPECT_EQ(FormatParameterSet(ParseParameterSet(kExtended, "set.toml")),
            R"(# Parameters of a UIC link suspension for Piotrowski's dry-friction model. Format: data/README.md.
name = "fit"
source = "ten records"
load_N = 3714.0  # M g during the measurement [N]
g = 9.82  # m/s^2, that the set was normalised with

[lateral]
k = 4.0  # 1/m, divided by M g
sliders = [  # k: 1/m, divided by M g; T0: -, divided by M g
  { k = 1.5, T0 = 0.0 },
]
effects = [  # beside the plain model; units: identify effects
  { id = "viscous_damping", c = 0.012 },
  { id = "stribeck_friction", zeta = 0.3, a = -1.0 },
]
std = { k = 0.1, k1 = 0.2, T01 = 0.001, "viscous_damping.c" = 0.003 }  # standard deviations, units of the parameters
covariance = { order = ["T01", "k", "viscous_damping.c"], matrix = [  # products of the parameters' units
  [1e-06, 1e-06, 0.0],
  [1e-06, 0.01, -1e-05],
  [0.0, -1e-05, 9e-06],
] }
)");
}

// --- round trip ---

/// Any double of either sign that the key allows, from the smallest to the largest: mantissa and exponent are both
/// random.
class RandomSets {
 public:
  explicit RandomSets(std::uint64_t seed) : generator_(seed) {}

  ParameterSet Next() {
    ParameterSet set;
    set.name = Text();
    set.source = Text();
    set.load_N = Positive();
    set.g = Positive();
    const int which = Count(1, 3);
    if (which & 1) set.lateral = NextDirection();
    if (which & 2) set.longitudinal = NextDirection();
    return set;
  }

 private:
  int Count(int low, int high) { return std::uniform_int_distribution(low, high)(generator_); }

  double Finite() {
    for (;;) {
      const double value = std::bit_cast<double>(generator_());
      if (std::isfinite(value)) return value;
    }
  }
  double Positive() {
    const double value = std::abs(Finite());
    return value > 0 ? value : 1;
  }
  double Moderate() { return std::exp(std::uniform_real_distribution(-30.0, 30.0)(generator_)); }

  std::string Text() {
    static const std::vector<std::string> kParts = {"a",    "\"",       "\\", "\n", "\t",  "\x01",
                                                    "\x7f", "\xc3\xa9", "#",  "'",  " = ", "\"\"\""};
    std::string text;
    for (int i = Count(0, 8); i > 0; --i)
      text += kParts[static_cast<std::size_t>(Count(0, static_cast<int>(kParts.size()) - 1))];
    return text;
  }

  DirectionParameters NextDirection() {
    DirectionParameters parameters;
    parameters.k = Positive();
    for (int i = Count(0, 6); i > 0; --i)
      parameters.sliders.push_back({Positive(), Count(0, 5) ? std::abs(Finite()) : 0.0});
    for (int i = Count(0, 2); i > 0; --i) {
      parameters.effects.push_back(
          {"effect_" + std::to_string(i) + Text(), {{"zeta", Finite()}, {"a b", Finite()}, {"c", -0.0}}});
    }
    for (const std::string& symbol : ParameterSymbols(static_cast<int>(parameters.sliders.size()))) {
      if (Count(0, 1)) parameters.std[symbol] = std::abs(Finite());
    }
    if (Count(0, 1)) parameters.covariance = NextCovariance(static_cast<int>(parameters.sliders.size()));
    return parameters;
  }

  Covariance NextCovariance(int sliders) {
    Covariance covariance{.order = ParameterSymbols(sliders), .matrix = {}};
    std::shuffle(covariance.order.begin(), covariance.order.end(), generator_);
    const std::size_t n = covariance.order.size();
    std::vector<double> sigma(n);
    for (double& s : sigma) s = Moderate();
    covariance.matrix.assign(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const double correlation = i == j ? 1 : std::uniform_real_distribution(-1.0, 1.0)(generator_);
        covariance.matrix[i][j] = covariance.matrix[j][i] = correlation * sigma[i] * sigma[j];
      }
    }
    if (Count(0, 1)) covariance.coverage = Positive();
    for (const std::string& symbol : covariance.order)
      if (Count(0, 1)) covariance.spread[symbol] = std::abs(Finite());
    return covariance;
  }

  std::mt19937_64 generator_;
};

std::uint64_t Bits(double value) { return std::bit_cast<std::uint64_t>(value); }

void ExpectSame(const DirectionParameters& a, const DirectionParameters& b) {
  EXPECT_EQ(Bits(a.k), Bits(b.k));
  ASSERT_EQ(a.sliders.size(), b.sliders.size());
  for (std::size_t i = 0; i < a.sliders.size(); ++i) {
    EXPECT_EQ(Bits(a.sliders[i].k), Bits(b.sliders[i].k));
    EXPECT_EQ(Bits(a.sliders[i].T0), Bits(b.sliders[i].T0));
  }
  ASSERT_EQ(a.effects.size(), b.effects.size());
  for (std::size_t i = 0; i < a.effects.size(); ++i) {
    EXPECT_EQ(a.effects[i].id, b.effects[i].id);
    EXPECT_EQ(a.effects[i].parameters, b.effects[i].parameters);
  }
  EXPECT_EQ(a.std, b.std);
  ASSERT_EQ(a.covariance.has_value(), b.covariance.has_value());
  if (!a.covariance) return;
  EXPECT_EQ(a.covariance->order, b.covariance->order);
  EXPECT_EQ(a.covariance->matrix, b.covariance->matrix);
  EXPECT_EQ(a.covariance->coverage, b.covariance->coverage);
  EXPECT_EQ(a.covariance->spread, b.covariance->spread);
}

TEST(ParameterSetFile, ReadsBackBitByBit) {
  RandomSets sets(20030301);
  for (int i = 0; i < 500; ++i) {
    const ParameterSet set = sets.Next();
    SCOPED_TRACE("set " + std::to_string(i));
    const ParameterSet back = ParseParameterSet(FormatParameterSet(set), "back.toml");
    EXPECT_EQ(back.name, set.name);
    EXPECT_EQ(back.source, set.source);
    EXPECT_EQ(Bits(back.load_N), Bits(set.load_N));
    EXPECT_EQ(Bits(back.g), Bits(set.g));
    for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
      ASSERT_EQ(back[direction].has_value(), set[direction].has_value());
      if (set[direction]) ExpectSame(*back[direction], *set[direction]);
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST(ParameterSetFile, IsWrittenToAFileAndReadFromIt) {
  const fs::path folder = fs::temp_directory_path() / ("uiclink_parameter_set_test_" + std::to_string(::getpid()));
  const ParameterSet set = ReadParameterSet(Shipped("set1.toml"));
  WriteParameterSet(set, folder / "out" / "parameters.toml");
  const ParameterSet back = ReadParameterSet(folder / "out" / "parameters.toml");
  fs::remove_all(folder);
  ExpectSame(*back.lateral, *set.lateral);
  ExpectSame(*back.longitudinal, *set.longitudinal);
}

// --- wrong input ---

TEST(ParameterSetErrors, ListEveryFault) {
  EXPECT_EQ(
      ParseMessage(R"(name = "wrong"
load_N = 0
gravity = 9.81
[lateral]
k = -3
sliders = [ { k = 0.0, T0 = 0.014 }, { k = 1.0, T0 = -0.1, mu = 0.2 }, { T0 = 1 } ]
std = { k = -1, k4 = 1 }
[longitudnal]
k = 1
)"),
      "set.toml: expected source = \"text\", found nothing\n"
      "set.toml:2: expected load_N > 0 [N], found 0\n"
      "set.toml:3: expected a known key, found \"gravity\" (known: g, lateral, load_N, longitudinal, name, source)\n"
      "set.toml:5: expected k > 0 [1/m], found -3\n"
      "set.toml:6: expected k > 0 [1/m], found 0\n"
      "set.toml:6: expected T0 >= 0 [-], found -0.1\n"
      "set.toml:6: expected k > 0 [1/m] in lateral.sliders[3], found nothing\n"
      "set.toml:6: expected a known key in lateral.sliders[2], found \"mu\" (known: T0, k)\n"
      "set.toml:7: expected k >= 0 [unit of the parameter], found -1\n"
      "set.toml:7: expected a known key in lateral.std, found \"k4\" (known: T01, T02, T03, k, k1, k2, k3)\n"
      "set.toml:8: expected a known key, found \"longitudnal\" (did you mean \"longitudinal\"?)");
}

TEST(ParameterSetErrors, AskForADirection) {
  EXPECT_EQ(ParseMessage(""),
            "set.toml: expected name = \"text\", found nothing\n"
            "set.toml: expected source = \"text\", found nothing\n"
            "set.toml: expected load_N > 0 [N], found nothing\n"
            "set.toml: expected a table [lateral] or [longitudinal], found neither");
}

/// A good set with one slider and this covariance.
std::string CovarianceMessage(const std::string& covariance) {
  return ParseMessage(
      "name = \"n\"\nsource = \"s\"\nload_N = 1\n[lateral]\nk = 4\nsliders = [ { k = 1, T0 = 0.1 } ]\n" + covariance);
}

TEST(ParameterSetErrors, CheckTheCovariance) {
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 0.5], [0.5, 1]] }\n"), "no error");
  EXPECT_EQ(CovarianceMessage("covariance = { matrix = [[1]] }\n"),
            "set.toml:7: expected order = [\"texts\"] in lateral.covariance, found nothing");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k\"], matrix = [[1, 0], [0, 1]] }\n"),
            "set.toml:7: expected every parameter once, found \"k\" twice");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k2\"], matrix = [[1]] }\n"),
            "set.toml:7: expected names among k, k1, T01, found \"k2\"");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 0]] }\n"),
            "set.toml:7: expected 2 rows as in order, found 1");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 0], [0]] }\n"),
            "set.toml:7: expected 2 numbers in row 2, found 1");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 0], [0, -1]] }\n"),
            "set.toml:7: expected a variance >= 0 of k1, found -1");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 0.1], [0.2, 1]] }\n"),
            "set.toml:7: expected a symmetric matrix, found 0.2 and 0.1 for k1, k");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\", \"k1\"], matrix = [[1, 3], [3, 4]] }\n"),
            "set.toml:7: expected a covariance of k1, k within +-2, found 3");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\"], matrix = [[nan]] }\n"),
            "set.toml:7: expected a finite number matrix[1][1] [product of units], found nan");
}

TEST(ParameterSetErrors, CheckCoverageAndSpread) {
  // The lines of the keys, where the covariance is a table of its own.
  EXPECT_EQ(CovarianceMessage("[lateral.covariance]\norder = [\"k\"]\nmatrix = [[1]]\ncoverage = 0\n"
                              "[lateral.covariance.spread]\nk = -1\nk2 = 1\n"),
            "set.toml:10: expected coverage > 0 [standard deviations], found 0\n"
            "set.toml:12: expected k >= 0 [unit of the parameter], found -1\n"
            "set.toml:13: expected a known key in lateral.covariance.spread, found \"k2\" (known: T01, k, k1)");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\"], matrix = [[1]], coverage = \"wide\" }\n"),
            "set.toml:7: expected coverage > 0 [standard deviations], found \"wide\"");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\"], matrix = [[1]], spread = 0.1 }\n"),
            "set.toml:7: expected a table spread, found 0.1");
  EXPECT_EQ(CovarianceMessage("covariance = { order = [\"k\"], matrix = [[1]], spread = { k = nan } }\n"),
            "set.toml:7: expected k >= 0 [unit of the parameter] and finite, found nan");
}

TEST(ParameterSetErrors, CheckTheEffects) {
  EXPECT_EQ(CovarianceMessage("effects = [ { c = \"much\" }, { id = \"a\" }, { id = \"a\" } ]\n"),
            "set.toml:7: expected id = \"text\" in lateral.effects[1], found nothing\n"
            "set.toml:7: expected a finite number c [unit of the effect], found \"much\"\n"
            "set.toml:7: expected every effect once, found \"a\" twice");
}

TEST(ParameterSetErrors, NameTheFileThatCannotBeRead) {
  EXPECT_EQ(MessageOf<InputError>([] { ReadParameterSet("/no/such/set.toml"); }),
            "/no/such/set.toml: expected a readable file, found nothing of that name");
}

TEST(FormatParameterSet, RefusesWhatCouldNotBeReadBack) {
  ParameterSet set = ParseParameterSet(kExtended, "set.toml");
  set.lateral->k = std::numeric_limits<double>::quiet_NaN();
  set.lateral->std["k7"] = 1;
  EXPECT_EQ(MessageOf<std::invalid_argument>([&] { FormatParameterSet(set); }),
            "FormatParameterSet: not a valid parameter set; in its text,\n"
            "FormatParameterSet:8: expected k > 0 [1/m] and finite, found nan\n"
            "FormatParameterSet:16: expected a known key in lateral.std, found \"k7\" (known: T01, k, k1, "
            "stribeck_friction.a, stribeck_friction.zeta, viscous_damping.c)");
}

}  // namespace
}  // namespace uiclink
