#include "vehicle/reproduce/reproduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "model/parallel.h"
#include "vehicle/reproduce/measure.h"

namespace uiclink::reproduce {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Something to do: an item on a geometry.
struct Job {
  const Item* item;
  std::string geometry;
  Task task;
  double cost;
  std::string name;
};

/// The wagon of an item on a track whose contact table has been made.
WagonInputs MakeInputs(const Item& item, const WagonInputs& track) {
  WagonInputs inputs = track;
  inputs.choice = ChoiceOf(item, track.choice.geometry);
  inputs.files.clear();
  inputs.notices.clear();
  WagonInputs contact = track;
  ReadWagonBody(inputs.choice, &inputs);
  inputs.files.insert(inputs.files.end(), contact.files.begin(), contact.files.end());
  ReadWagonLinks(inputs.choice, &inputs);
  return inputs;
}

class Reproducer {
 public:
  explicit Reproducer(const ReproduceOptions& options) : options_(options), store_(options.folder) {}

  Reproduction Run() {
    const Clock::time_point begin = Clock::now();
    reproduction_.geometries = options_.geometries;
    reproduction_.items = SelectItems(options_);
    reproduction_.quick = options_.quick;
    ReadTracks();
    std::vector<Job> jobs = ListMissing();
    std::ranges::stable_sort(jobs, std::ranges::greater{}, &Job::cost);
    DoAll(jobs);
    if (failure_) std::rethrow_exception(failure_);
    reproduction_.interrupted = stopped_;
    reproduction_.wall_s = Since(begin);
    return std::move(reproduction_);
  }

 private:
  bool GoOn() {
    if (!options_.go_on || options_.go_on()) return true;
    stopped_ = true;
    return false;
  }

  /// The contact table of a geometry is made once.
  void ReadTracks() {
    for (const std::string& geometry : options_.geometries) {
      WagonInputs track;
      track.choice.geometry = geometry;
      ReadWagonContact(track.choice, &track);
      const TrackGeometry& g = *track.geometry;
      reproduction_.geometry_words[geometry] = fmt::format(
          "{} contact under {:.1f} kN a wheel; gauge {:.2f} mm measured {:g} mm below the rail's top, each rail {:.4f} "
          "mm "
          "further out; wheel {} on rail {}, r0 {:g} mm",
          g.contact == ContactModel::kRigid ? "rigid" : "elastic", 1e-3 * g.wheel_load, 1e3 * g.gauge,
          1e3 * g.gauge_depth, 1e3 * g.rail_offset, g.wheel, g.rail, 1e3 * g.r0);
      tracks_.emplace(geometry, std::move(track));
    }
  }

  std::vector<Job> ListMissing() {
    std::vector<Job> jobs;
    for (const std::string& geometry : options_.geometries) {
      for (const Item* item : reproduction_.items) {
        Task task = TaskOn(*item, geometry);
        if (options_.quick) task = Quicken(task);
        const std::string key = CalcKey(*item, task, MakeInputs(*item, tracks_.at(geometry)));
        std::optional<ItemResult> known;
        if (!options_.again) known = store_.Read(geometry, item->id, key);
        if (known) {
          reproduction_.results[{geometry, item->id}] = std::move(*known);
        } else {
          jobs.push_back({item, geometry, task, EstimateCost(task), fmt::format("{} on {}", item->id, geometry)});
        }
      }
    }
    return jobs;
  }

  /// The jobs on their threads, progress from this one.
  void DoAll(const std::vector<Job>& jobs) {
    begin_ = Clock::now();
    known_ = reproduction_.results.size();
    total_ = known_ + jobs.size();
    for (const Job& job : jobs) cost_ += job.cost;
    std::atomic<bool> finished{false};
    std::jthread workers([&] {
      ParallelFor(jobs.size(), options_.threads, [&](std::size_t i) { Do(jobs[i]); });
      finished = true;
    });
    while (!finished) {
      Tell();
      std::this_thread::sleep_for(std::chrono::milliseconds(finished ? 0 : 100));
    }
  }

  void Do(const Job& job) {
    if (stopped_ || !GoOn()) return;
    {
      const std::scoped_lock lock(mutex_);
      running_.insert(job.name);
    }
    try {
      const WagonInputs inputs = MakeInputs(*job.item, tracks_.at(job.geometry));
      const Bench bench{inputs, MakeWagon(inputs), [this] { return GoOn(); }};
      ItemResult result = Measure(job.task, bench);
      store_.Write(job.geometry, job.item->id, CalcKey(*job.item, job.task, inputs), result);
      const std::scoped_lock lock(mutex_);
      reproduction_.results[{job.geometry, job.item->id}] = std::move(result);
      ++reproduction_.computed;
      cost_done_ += job.cost;
    } catch (const GivenUp&) {  // it is done again by the next call
    } catch (...) {             // the disk is full
      const std::scoped_lock lock(mutex_);
      failure_ = std::current_exception();
      stopped_ = true;
    }
    const std::scoped_lock lock(mutex_);
    running_.erase(job.name);
  }

  void Tell() {
    if (!options_.on_progress) return;
    ReproduceProgress progress;
    {
      const std::scoped_lock lock(mutex_);
      progress = {
          .done = known_ + reproduction_.computed, .total = total_, .running = {running_.begin(), running_.end()}};
      if (cost_done_ > 0) progress.left_s = Since(begin_) * (cost_ - cost_done_) / cost_done_;
    }
    options_.on_progress(progress);
  }

  const ReproduceOptions& options_;
  ResultStore store_;
  Reproduction reproduction_;
  std::map<std::string, WagonInputs> tracks_;
  std::mutex mutex_;  // of what follows, and of results and computed
  std::set<std::string> running_;
  std::exception_ptr failure_;
  double cost_ = 0, cost_done_ = 0;
  std::size_t known_ = 0, total_ = 0;
  std::atomic<bool> stopped_{false};
  Clock::time_point begin_;
};

bool IsNamed(const Item& item, const std::string& name) {
  if (item.id == name) return true;
  return std::ranges::any_of(item.covers, [&](const std::string& covered) {
    return covered == name || covered == "figure " + name || covered == "table " + name ||
           covered.starts_with("figure " + name + "(") || covered.starts_with("table " + name + ",");
  });
}

}  // namespace

const ItemResult* Reproduction::Find(const std::string& geometry, const std::string& id) const {
  const auto found = results.find({geometry, id});
  return found != results.end() ? &found->second : nullptr;
}

std::vector<const Item*> SelectItems(const ReproduceOptions& options) {
  for (const std::string& name : options.only) {
    if (std::ranges::none_of(Items(), [&](const Item& item) { return IsNamed(item, name); }))
      throw UsageError(fmt::format("--only: expected an item (wagon reproduce --list), found \"{}\"", name));
  }
  for (const std::string& section : options.sections) {
    if (std::ranges::find(Sections(), section, &Section::number) == Sections().end())
      throw UsageError(fmt::format("--section: expected one of 10.1 to 10.5, found \"{}\"", section));
  }
  std::vector<const Item*> items;
  for (const Item& item : Items()) {
    const bool named = options.only.empty() ||
                       std::ranges::any_of(options.only, [&](const std::string& name) { return IsNamed(item, name); });
    const bool here =
        options.sections.empty() || std::ranges::find(options.sections, item.section) != options.sections.end();
    if (named && here) items.push_back(&item);
  }
  return items;
}

Reproduction Reproduce(const ReproduceOptions& options) { return Reproducer(options).Run(); }

std::vector<std::size_t> CountVerdicts(const Reproduction& reproduction, const std::string& geometry) {
  std::vector<std::size_t> counts(kVerdicts, 0);
  for (const Item* item : reproduction.items) {
    for (const Row& row : item->rows)
      ++counts[static_cast<std::size_t>(Compare(row, geometry, reproduction.Find(geometry, item->id)).verdict)];
  }
  return counts;
}

}  // namespace uiclink::reproduce
