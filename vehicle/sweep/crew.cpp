#include "vehicle/sweep/crew.h"

#include <exception>
#include <utility>

namespace uiclink {

using Clock = std::chrono::steady_clock;

Crew::Crew(const SweepPlan& plan, int threads) : plan_(plan) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

Crew::~Crew() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  given_.notify_all();
}

void Crew::Give(const std::vector<std::size_t>& runs) {
  {
    const std::lock_guard lock(mutex_);
    to_do_.insert(to_do_.end(), runs.begin(), runs.end());
    unfinished_ += runs.size();
  }
  given_.notify_all();
}

std::vector<FinishedRun> Crew::Take(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  finished_.wait_for(lock, patience, [this] { return unfinished_ == 0; });
  return std::exchange(done_, {});
}

std::optional<std::size_t> Crew::TakeRun() {
  const std::lock_guard lock(mutex_);
  if (stopped_ || to_do_.empty()) return std::nullopt;
  const std::size_t run = to_do_.front();
  to_do_.pop_front();
  return run;
}

void Crew::Finish(FinishedRun done) {
  const std::lock_guard lock(mutex_);
  done_.push_back(std::move(done));
  if (--unfinished_ == 0) finished_.notify_all();
}

/// Of one thread.
class Crew::Source : public RunSource {
 public:
  explicit Source(Crew* crew) : crew_(*crew) {}

  std::optional<RunJob> Next() override {
    while (const std::optional<std::size_t> run = crew_.TakeRun()) {
      const Clock::time_point begin = Clock::now();
      RunJob job;
      job.run = *run;
      try {
        job.setup = crew_.plan_.Setup(*run);
        job.bench = {crew_.plan_.shelf().Get(job.setup), [&crew = crew_] { return !crew.stopped_; }};
        job.prepared_s = Since(begin);
        return job;
      } catch (const std::exception& fault) {
        Finish(job, {.status = RunStatus::kFailed, .reason = fault.what()}, Since(begin));
      }
    }
    return std::nullopt;
  }

  void Finish(const RunJob& job, SweepOutcome outcome, double wall_s) override {
    crew_.Finish({.run = job.run, .outcome = std::move(outcome), .wall_s = job.prepared_s + wall_s});
  }

 private:
  static double Since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

  Crew& crew_;
};

void Crew::Work() {
  Source source(this);
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      given_.wait(lock, [this] { return stopped_ || !to_do_.empty(); });
      if (stopped_) return;
    }
    try {
      plan_.campaign().kind->Work(source);
    } catch (const RunGivenUp&) {
      return;  // nobody waits for it
    }
  }
}

}  // namespace uiclink
