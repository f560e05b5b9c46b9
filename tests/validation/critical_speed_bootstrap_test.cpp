// Are the bounds of the linear critical speed as wide as they should be? The ten records of measurements/ are resampled
// with replacement and identified anew, every time carried to the wagon; and fresh sets of ten records are made from
// the same population of links, whose critical speed is known. Prints what it finds.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

#include "data/data_path.h"
#include "data/parameter_set_file.h"
#include "identify/diagnosis.h"
#include "identify/identification.h"
#include "identify/report_wagon.h"
#include "measurements/rig/rig.h"
#include "model/parallel.h"
#include "tests/support/rig_records.h"
#include "vehicle/hunting/speed_bounds.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr std::size_t kResamples = 48;  // the standard deviation of so many is right to 10 %
constexpr std::size_t kFreshSets = 32;
constexpr int kRecords = 10;

std::filesystem::path Measurements() { return std::filesystem::path(UICLINK_SOURCE_DIR) / "measurements"; }

/// What `identify` does with records, on one thread.
RunResult IdentifyAll(std::vector<Record> records) {
  IdentifyOptions identify;
  DiagnoseOptions diagnose;
  identify.threads = diagnose.threads = 1;
  RunResult run;
  run.directions.push_back(Identify(Direction::kLateral, std::move(records), identify));
  run.diagnoses.push_back(Diagnose(run.directions[0], diagnose));
  return run;
}

/// A wagon on set 1 whose lateral links are replaced.
class Geometry {
 public:
  explicit Geometry(const std::string& name) : name_(name) {
    WagonChoice choice;
    choice.sets = {"set1"};
    choice.geometry = name;
    const WagonInputs inputs = ReadWagonInputs(choice);
    links_ = inputs.links;
    wagon_.emplace(MakeWagon(inputs));
    StabilityOptions options;
    options.first_only = true;
    const StabilityResult result = FindCrossings(*wagon_, options);
    known_ = {*result.linear_critical_speed, result.crossings.front().mode.lambda};
  }
  const std::string& name() const { return name_; }

  std::array<CornerLinks, kCorners> LinksOn(const DirectionParameters& lateral) const {
    std::array<CornerLinks, kCorners> links = links_;
    for (CornerLinks& corner : links) corner.lateral = lateral;
    return links;
  }
  double CriticalSpeed(const DirectionParameters& lateral) const {
    return FindCriticalSpeedNear(WithLinks(*wagon_, LinksOn(lateral)), known_);
  }
  /// Standard deviation by first order, without Student's factor.
  double PropagatedStd(const DirectionParameters& lateral) const {
    const SetScatter scatter(LinksOn(lateral), {.draws = 0});
    const Eigen::VectorXd gradient =
        CalcSpeedGradient(scatter, WithLinks(*wagon_, scatter.nominal()), {CriticalSpeed(lateral), known_.lambda});
    return std::sqrt(gradient.dot(scatter.covariance() * gradient));
  }

 private:
  std::string name_;
  std::array<CornerLinks, kCorners> links_;
  std::optional<Wagon> wagon_;
  KnownCrossing known_;
};

const std::vector<Geometry>& Geometries() {
  static const std::vector<Geometry> geometries{Geometry("nominal-1435"), Geometry("thesis-equivalent")};
  return geometries;
}

/// Critical speed of a set and its bounds, by model and geometry.
struct Found {
  double V = 0, std = 0, coverage = 1.96;
};
struct FoundAll {
  std::array<std::array<Found, 2>, 2> of;  ///< [plain, extended][geometry]
  bool named = false;                      ///< a cause was named
  std::string failure;
};

FoundAll Carry(std::vector<Record> records) {
  FoundAll all;
  try {
    const RunResult run = IdentifyAll(std::move(records));
    all.named = HasCauses(run);
    for (const bool extended : {false, true}) {
      const ValidationSet set = MakeValidationSet(run, extended, "");
      for (std::size_t g = 0; g < 2; ++g) {
        const Geometry& geometry = Geometries()[g];
        all.of[extended ? 1 : 0][g] = {.V = geometry.CriticalSpeed(*set.set.lateral),
                                       .std = geometry.PropagatedStd(*set.set.lateral),
                                       .coverage = set.set.lateral->covariance->coverage.value()};
      }
    }
  } catch (const std::exception& error) {
    all.failure = error.what();
  }
  return all;
}

template <typename Of>
double Std(const std::vector<FoundAll>& all, Of of) {
  double sum = 0, squares = 0, n = 0;
  for (const FoundAll& found : all) {
    if (!found.failure.empty()) continue;
    const double value = of(found);
    sum += value;
    squares += value * value;
    n += 1;
  }
  return std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)));
}

std::size_t CountFailures(const std::vector<FoundAll>& all) {
  std::size_t failed = 0;
  for (const FoundAll& found : all) {
    if (found.failure.empty()) continue;
    ++failed;
    fmt::print("failed: {}\n", found.failure);
  }
  return failed;
}

constexpr std::array<const char*, 2> kModels{"plain", "extended"};

TEST(CriticalSpeedBootstrap, BoundsOfTheTenRecordsAreAsWideAsTheirResamplesScatter) {
  std::vector<Record> shipped;
  for (int i = 1; i <= kRecords; ++i)
    shipped.push_back(ReadRecord(Measurements() / fmt::format("lateral_{:02}.txt", i)));
  std::vector<std::vector<Record>> samples(kResamples);
  std::mt19937_64 random(20);
  for (std::vector<Record>& sample : samples)
    for (int i = 0; i < kRecords; ++i) sample.push_back(shipped[random() % kRecords]);
  const FoundAll stated = Carry(shipped);
  ASSERT_EQ(stated.failure, "");
  std::vector<FoundAll> found(kResamples);
  ParallelFor(kResamples, 0, [&](std::size_t i) { found[i] = Carry(std::move(samples[i])); });
  EXPECT_EQ(CountFailures(found), 0u);
  // Means over ten of ten records scatter by sqrt((n - 1)/n) of what means over ten fresh ones would.
  const double fresh = std::sqrt(kRecords / (kRecords - 1.0));
  for (std::size_t model = 0; model < 2; ++model) {
    for (std::size_t g = 0; g < 2; ++g) {
      const double std = fresh * Std(found, [&](const FoundAll& f) { return f.of[model][g].V; });
      const Found& here = stated.of[model][g];
      fmt::print("{} {}: {:.4f} m/s, standard deviation propagated {:.4f}, resampled {:.4f} m/s, ratio {:.2f}\n",
                 kModels[model], Geometries()[g].name(), here.V, here.std, std, std / here.std);
      // 48 resamples know a standard deviation to 10 %, ten records themselves to 24 %. Bounds of the plain model are
      // wider than they need be (2.6 times): the structure that it leaves in the residuals counts as error of each
      // record, although it is the same in all of them.
      if (model == 1) {
        EXPECT_GT(std / here.std, 0.5) << Geometries()[g].name();
      }
      EXPECT_LT(std / here.std, 2.0) << kModels[model] << ' ' << Geometries()[g].name();
    }
  }
  for (std::size_t g = 0; g < 2; ++g) {
    const double difference = fresh * Std(found, [&](const FoundAll& f) { return f.of[0][g].V - f.of[1][g].V; });
    const double a = fresh * Std(found, [&](const FoundAll& f) { return f.of[0][g].V; });
    const double b = fresh * Std(found, [&](const FoundAll& f) { return f.of[1][g].V; });
    fmt::print(
        "plain less extended {}: {:+.4f} m/s, standard deviation resampled {:.4f}; correlation of the two {:.3f}\n",
        Geometries()[g].name(), stated.of[0][g].V - stated.of[1][g].V, difference,
        (a * a + b * b - difference * difference) / (2 * a * b));
  }
}

TEST(CriticalSpeedBootstrap, BoundsOfFreshRecordsHoldTheTruth) {
  rig::Settings settings = rig::ReadSettings(Measurements() / "rig/settings/lateral.toml");
  DirectionParameters truth;
  truth.k = settings.link.k;
  for (const rig::Joint& joint : settings.link.joints) truth.sliders.push_back({.k = joint.k, .T0 = joint.T0});
  std::vector<FoundAll> found(kFreshSets);
  ParallelFor(kFreshSets, 0, [&](std::size_t i) {
    rig::Settings fresh = settings;
    fresh.seed = 7000 + i;
    found[i] = Carry(MakeRecords(fresh, kRecords, Direction::kLateral));
  });
  EXPECT_EQ(CountFailures(found), 0u);
  for (std::size_t g = 0; g < 2; ++g) {
    const double V = Geometries()[g].CriticalSpeed(truth);
    for (std::size_t model = 0; model < 2; ++model) {
      int held = 0, used = 0;
      double stated = 0, mean = 0;
      for (const FoundAll& f : found) {
        if (!f.failure.empty()) continue;
        const Found& here = f.of[model][g];
        held += std::abs(here.V - V) <= here.coverage * here.std ? 1 : 0;
        stated += here.std;
        mean += here.V - V;
        ++used;
      }
      const double std = Std(found, [&](const FoundAll& f) { return f.of[model][g].V; });
      fmt::print(
          "{} {}: truth {:.4f} m/s, held by {} of {} intervals; bias {:+.4f}, standard deviation propagated "
          "{:.4f}, of fresh sets {:.4f}, ratio {:.2f}\n",
          kModels[model], Geometries()[g].name(), V, held, used, mean / used, stated / used, std, std * used / stated);
      // 95 % of 32 are 30.4; binomially fewer than 26 happen once in 250. The plain model lacks a cause that the
      // records hold: it is told above and not asked for its truth.
      if (model == 1) {
        EXPECT_GE(held, static_cast<int>(0.81 * used)) << Geometries()[g].name();
      }
    }
  }
}

}  // namespace
}  // namespace uiclink
