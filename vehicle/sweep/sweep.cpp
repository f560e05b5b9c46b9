#include "vehicle/sweep/sweep.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <stdexcept>
#include <unordered_map>

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

/// Who does what.
class Dispatcher {
 public:
  Dispatcher(Team* team, const std::vector<std::size_t>& runs)
      : team_(*team), to_do_(runs.begin(), runs.end()), in_hand_(team->members()) {}

  void HandOut() {
    for (std::size_t member = 0; member < team_.members(); ++member) {
      if (team_.Hands(member) == 0) TakeBack(member);
    }
    int hands = 0;
    for (std::size_t member = 0; member < team_.members(); ++member) hands += team_.Hands(member);
    if (hands == 0) throw std::runtime_error("expected one process at least to do the runs, found all of them lost");
    for (std::size_t member = 0; member < team_.members(); ++member) HandOut(member, hands);
  }

  /// False for a run that came back before, from a member that was thought lost.
  bool Note(const FinishedRun& done) {
    const auto owner = owner_.find(done.run);
    if (owner == owner_.end()) return false;
    --in_hand_[owner->second];
    owner_.erase(owner);
    mean_s_ += (done.wall_s - mean_s_) / ++noted_;
    return true;
  }

  bool idle() const { return owner_.empty(); }  ///< nothing is handed out

 private:
  void HandOut(std::size_t member, int all_hands) {
    const auto hands = static_cast<double>(team_.Hands(member));
    // Ahead by 250 ms, so that nobody waits for a hand-out on a busy computer; long runs one by one, so that nobody has
    // two while another has none; at the end no more than a fair share of what is left.
    constexpr double kAhead_s = 0.25, kMost = 256;
    const double ahead = noted_ > 0 ? std::min(std::floor(1 + kAhead_s / std::max(mean_s_, 1e-9)), kMost) : 1;
    const double share = std::ceil(static_cast<double>(to_do_.size()) / all_hands);
    const double wanted = hands * std::min(ahead, std::max(share, 1.0));
    std::vector<std::size_t> runs;
    while (!to_do_.empty() && static_cast<double>(in_hand_[member]) < wanted) {
      const std::size_t run = to_do_.front();
      to_do_.pop_front();
      owner_[run] = member;
      ++in_hand_[member];
      runs.push_back(run);
    }
    if (!runs.empty()) team_.Give(member, runs);
  }

  void TakeBack(std::size_t member) {
    if (in_hand_[member] == 0) return;
    for (auto run = owner_.begin(); run != owner_.end();) {
      if (run->second == member) {
        to_do_.push_front(run->first);
        run = owner_.erase(run);
      } else {
        ++run;
      }
    }
    in_hand_[member] = 0;
  }

  Team& team_;
  std::deque<std::size_t> to_do_;
  std::vector<std::size_t> in_hand_;                    ///< by member
  std::unordered_map<std::size_t, std::size_t> owner_;  ///< of runs that are handed out
  double mean_s_ = 0, noted_ = 0;
};

}  // namespace

SweepResult RunSweep(Team* team, SweepStore* store, const std::function<bool()>& go_on,
                     const std::function<void(const SweepProgress&)>& on_progress) {
  constexpr std::chrono::milliseconds kOldest{200};  // of a finished run that is not written
  // For what is handed out ahead, a quarter of a second of work; mpirun kills two seconds after it has asked to end.
  constexpr std::chrono::milliseconds kFarewell{1000};
  const Clock::time_point begin = Clock::now();
  const std::size_t total = store->missing().size();
  Dispatcher dispatcher(team, store->missing());
  SweepResult result;
  std::vector<FinishedRun> unwritten;
  Clock::time_point written = begin, interrupted = begin;
  const auto write = [&] {
    if (!unwritten.empty()) store->Write(unwritten);
    result.done += unwritten.size();
    unwritten.clear();
    written = Clock::now();
    const double elapsed = Seconds(written - begin);
    const double left =
        result.done > 0 ? elapsed * static_cast<double>(total - result.done) / static_cast<double>(result.done) : 0;
    if (on_progress) on_progress({.done = result.done, .total = total, .elapsed_s = elapsed, .left_s = left});
  };
  while (result.done + unwritten.size() < total) {
    if (!result.interrupted && go_on && !go_on()) {
      result.interrupted = true;
      interrupted = Clock::now();
    }
    if (!result.interrupted) dispatcher.HandOut();
    if (result.interrupted && (dispatcher.idle() || Clock::now() - interrupted >= kFarewell)) break;
    for (FinishedRun& done : team->Take()) {
      if (!dispatcher.Note(done)) continue;
      result.run_s += done.wall_s;
      unwritten.push_back(std::move(done));
    }
    if (Clock::now() - written >= kOldest) write();
  }
  write();
  for (std::size_t member = 0; member < team->members(); ++member)
    result.lost_members += team->Hands(member) == 0 ? 1 : 0;
  result.wall_s = Seconds(Clock::now() - begin);
  return result;
}

}  // namespace uiclink
