#include "vehicle/sweep/run_kind.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <map>
#include <utility>

namespace uiclink {
namespace {

using Read = std::shared_ptr<const RunKind> (*)(Table*);

const std::map<std::string, Read>& RunKinds() {
  static const std::map<std::string, Read> kinds{
      {"modes", ReadModesKind}, {"simulate", ReadSimulateKind}, {"stability", ReadStabilityKind}};
  return kinds;
}

}  // namespace

const char* Name(RunStatus status) {
  constexpr std::array<const char*, kRunStatuses> kNames{"done", "failed", "wheel_lift", "derailed"};
  return kNames[static_cast<std::size_t>(status)];
}

void OneByOne::Work(RunSource& source) const {
  using Clock = std::chrono::steady_clock;
  while (const std::optional<RunJob> job = source.Next()) {
    const Clock::time_point begin = Clock::now();
    SweepOutcome outcome;
    try {
      outcome = Run(job->bench, job->setup);
    } catch (const RunGivenUp&) {
      throw;
    } catch (const std::exception& fault) {
      outcome = {.status = RunStatus::kFailed, .reason = fault.what()};
    }
    source.Finish(*job, std::move(outcome), std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

std::shared_ptr<const RunKind> ReadRunKind(Table* run) {
  const std::string kind = run->String("kind");
  const auto found = RunKinds().find(kind);
  if (found != RunKinds().end()) return found->second(run);
  std::vector<std::string> names;
  for (const auto& [name, read] : RunKinds()) names.push_back(name);
  if (run->Has("kind"))
    run->Report("kind", fmt::format("kind = one of {}", fmt::join(names, ", ")), fmt::format("\"{}\"", kind));
  run->Know(run->Keys());  // what they mean, nobody knows without the kind
  return nullptr;
}

}  // namespace uiclink
