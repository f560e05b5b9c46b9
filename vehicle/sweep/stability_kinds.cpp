// The linear wagon (vehicle/stability.h): critical speeds, and how small motions grow at one speed.

#include <fmt/format.h>

#include <limits>

#include "vehicle/stability.h"
#include "vehicle/sweep/run_kind.h"

namespace uiclink {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

class StabilityKind : public OneByOne {
 public:
  explicit StabilityKind(const StabilityOptions& options) : options_(options) {}

  const std::string& name() const override {
    static const std::string name = "stability";
    return name;
  }
  const std::vector<ResultColumn>& columns() const override {
    static const std::vector<ResultColumn> columns{
        {"linear_critical_speed"}, {"critical_frequency_hz"}, {"crossings", true}, {"unstable_at_start", true}};
    return columns;
  }
  std::string Identity() const override {
    return fmt::format("kind=stability from={} to={} step={} tolerance={}", options_.from, options_.to, options_.step,
                       options_.tolerance);
  }
  bool UsesSpeed() const override { return false; }
  bool UsesStart() const override { return false; }

  SweepOutcome Run(const RunBench& bench, const RunSetup& /*setup*/) const override {
    StabilityOptions options = options_;
    options.on_speed = [&bench](double, const std::vector<std::complex<double>>&) {
      if (!bench.go_on()) throw RunGivenUp();
    };
    const StabilityResult result = FindCrossings(*bench.wagon, options);
    double frequency = kNone;
    for (const Crossing& crossing : result.crossings)
      if (result.linear_critical_speed == crossing.V) frequency = crossing.frequency_hz;
    return {.values = {result.linear_critical_speed.value_or(kNone), frequency,
                       static_cast<double>(result.crossings.size()), static_cast<double>(result.unstable_at_start)}};
  }

 private:
  StabilityOptions options_;
};

class ModesKind : public OneByOne {
 public:
  const std::string& name() const override {
    static const std::string name = "modes";
    return name;
  }
  const std::vector<ResultColumn>& columns() const override {
    static const std::vector<ResultColumn> columns{{"growth_per_s"}, {"growth_frequency_hz"}, {"unstable_modes", true}};
    return columns;
  }
  std::string Identity() const override { return "kind=modes"; }
  bool UsesStart() const override { return false; }

  SweepOutcome Run(const RunBench& bench, const RunSetup& setup) const override {
    const std::vector<std::complex<double>> all = CalcEigenvalues(Linearize(*bench.wagon, setup.speed));
    int unstable = 0;
    for (const std::complex<double>& lambda : all) unstable += lambda.real() > 0 && lambda.imag() >= 0 ? 1 : 0;
    const LinearMode first{.lambda = all.front()};
    return {.values = {first.lambda.real(), first.frequency_hz(), static_cast<double>(unstable)}};
  }
};

}  // namespace

std::shared_ptr<const RunKind> ReadStabilityKind(Table* run) {
  StabilityOptions options;
  const Range speed{.unit = "m/s", .low = 0.01, .high = 300};
  options.from = run->OptionalNumber("from", speed).value_or(options.from);
  options.to = run->OptionalNumber("to", speed).value_or(options.to);
  options.step = run->OptionalNumber("step", {.unit = "m/s", .low = 1e-3, .high = 300}).value_or(options.step);
  options.tolerance =
      run->OptionalNumber("tolerance", {.unit = "m/s", .low = 1e-12, .high = 1}).value_or(options.tolerance);
  if (!(options.from < options.to) && options.from == options.from && options.to == options.to) {
    run->Report("to", fmt::format("to > from = {:g} [m/s]", options.from), fmt::format("{:g}", options.to));
  }
  return std::make_shared<StabilityKind>(options);
}

std::shared_ptr<const RunKind> ReadModesKind(Table* /*run*/) { return std::make_shared<ModesKind>(); }

}  // namespace uiclink
