#define OMPI_SKIP_MPICXX 1
#include "vehicle/sweep/mpi_team.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <thread>

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

enum Tag : int { kRuns = 1, kResults, kEnd };

constexpr auto kSignOfLife = 500ms;
constexpr auto kSilence = 10s;   // after it a process is lost
constexpr auto kGoneRoot = 60s;  // a busy disk may hold up process 0
constexpr auto kLook = 2ms;      // between looks for messages: MPI's own waiting takes a whole core

// --- finished runs as bytes; all processes run the same program ------------------------------------------------------

template <typename T>
void Put(std::string* bytes, const T& value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename T>
T Get(const char** from) {
  T value;
  std::memcpy(&value, *from, sizeof value);
  *from += sizeof value;
  return value;
}

std::string Pack(const std::vector<FinishedRun>& runs) {
  std::string bytes;
  for (const FinishedRun& done : runs) {
    Put(&bytes, done.run);
    Put(&bytes, done.outcome.status);
    Put(&bytes, done.wall_s);
    Put(&bytes, done.outcome.reason.size());
    bytes += done.outcome.reason;
    Put(&bytes, done.outcome.values.size());
    for (const double value : done.outcome.values) Put(&bytes, value);
  }
  return bytes;
}

void Unpack(const std::string& bytes, std::vector<FinishedRun>* runs) {
  const char* from = bytes.data();
  while (from != bytes.data() + bytes.size()) {
    FinishedRun& done = runs->emplace_back();
    done.run = Get<std::size_t>(&from);
    done.outcome.status = Get<RunStatus>(&from);
    done.wall_s = Get<double>(&from);
    const auto letters = Get<std::size_t>(&from);
    done.outcome.reason.assign(from, letters);
    from += letters;
    done.outcome.values.resize(Get<std::size_t>(&from));
    for (double& value : done.outcome.values) value = Get<double>(&from);
  }
}

void Send(const void* bytes, std::size_t size, int to, Tag tag) {
  MPI_Send(bytes, static_cast<int>(size), MPI_BYTE, to, tag, MPI_COMM_WORLD);
}

/// To process 0, long messages too: such a one is on its way until it is received, and if process 0 has died, for ever.
class Outbox {
 public:
  /// Whether the last message has arrived.
  bool IsFree() {
    int arrived = 1;
    if (request_ != MPI_REQUEST_NULL) MPI_Test(&request_, &arrived, MPI_STATUS_IGNORE);
    return arrived != 0;
  }
  /// Where it IsFree().
  void Send(std::string bytes, Tag tag) {
    bytes_ = std::move(bytes);
    MPI_Isend(bytes_.data(), static_cast<int>(bytes_.size()), MPI_BYTE, 0, tag, MPI_COMM_WORLD, &request_);
  }

 private:
  std::string bytes_;
  MPI_Request request_ = MPI_REQUEST_NULL;
};

struct Message {
  int from = -1;  ///< -1: there was none
  int tag = 0;
  std::string bytes;
};

Message Receive() {
  int there = 0, size = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return {};
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{
      .from = status.MPI_SOURCE, .tag = status.MPI_TAG, .bytes = std::string(static_cast<std::size_t>(size), ' ')};
  MPI_Recv(message.bytes.data(), size, MPI_BYTE, message.from, message.tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

std::vector<int> GatherInts(int mine) {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  std::vector<int> all(static_cast<std::size_t>(size));
  MPI_Allgather(&mine, 1, MPI_INT, all.data(), 1, MPI_INT, MPI_COMM_WORLD);
  return all;
}

// --- process 0 -------------------------------------------------------------------------------------------------------

class MpiTeam : public Team {
 public:
  MpiTeam(const SweepPlan& plan, int threads, bool* lost)
      : crew_(plan, threads), hands_(GatherInts(crew_.hands())), heard_(hands_.size(), Clock::now()), lost_(*lost) {}

  /// Takes what still comes, so that nobody is stuck in a message, until all have said that they end.
  ~MpiTeam() override {
    std::size_t left = 0;
    for (std::size_t member = 1; member < members(); ++member) {
      if (Hands(member) == 0) continue;
      Send(&lost_, lost_ ? 1 : 0, static_cast<int>(member), kEnd);
      ++left;
    }
    for (const Clock::time_point end = Clock::now() + kSilence; left > 0 && Clock::now() < end;) {
      const Message message = Receive();
      if (message.from < 0) std::this_thread::sleep_for(kLook);
      if (message.tag == kEnd) --left;
    }
    lost_ |= left > 0;
  }

  std::size_t members() const override { return hands_.size(); }

  int Hands(std::size_t member) const override {
    return member == 0 || Clock::now() - heard_[member] < kSilence ? hands_[member] : 0;
  }

  void Give(std::size_t member, const std::vector<std::size_t>& runs) override {
    if (member == 0) return crew_.Give(runs);
    // Messages as short as these are on their way at once, also to a process that has died.
    constexpr std::size_t kMost = 256;
    for (std::size_t i = 0; i < runs.size(); i += kMost) {
      const std::size_t size = std::min(kMost, runs.size() - i) * sizeof runs[0];
      Send(&runs[i], size, static_cast<int>(member), kRuns);
    }
  }

  std::vector<FinishedRun> Take() override {
    SendSignsOfLife();
    std::vector<FinishedRun> done = crew_.Take(0ms);
    for (Message message = Receive(); message.from >= 0; message = Receive()) {
      heard_[static_cast<std::size_t>(message.from)] = Clock::now();
      if (message.tag == kResults) Unpack(message.bytes, &done);
    }
    for (std::size_t member = 1; member < members(); ++member) lost_ |= Hands(member) == 0;
    if (done.empty()) std::this_thread::sleep_for(kLook);
    return done;
  }

 private:
  void SendSignsOfLife() {
    if (Clock::now() - said_ < kSignOfLife) return;
    said_ = Clock::now();
    for (std::size_t member = 1; member < members(); ++member) {
      if (Hands(member) > 0) Send(nullptr, 0, static_cast<int>(member), kRuns);
    }
  }

  Crew crew_;
  std::vector<int> hands_;
  std::vector<Clock::time_point> heard_;
  Clock::time_point said_ = Clock::now();
  bool& lost_;
};

}  // namespace

MpiSession::MpiSession() {
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
}

MpiSession::~MpiSession() {
  if (lost_) {
    // mpirun --enable-recovery makes nothing of exit codes.
    if (alone_) std::cerr << "wagon: process 0 lost; resume with the same command\n";
    std::cout.flush();
    std::fflush(nullptr);
    std::quick_exit(rank() == 0 || alone_ ? 1 : 0);
  }
  MPI_Finalize();
}

int MpiSession::rank() const {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int MpiSession::size() const {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

std::string MpiSession::Broadcast(const std::string& text) const {
  std::string all = text;
  unsigned long size = all.size();
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, 0, MPI_COMM_WORLD);
  all.resize(size);
  MPI_Bcast(all.data(), static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD);
  return all;
}

bool MpiSession::SameEverywhere(const std::string& text) const {
  const int same = Broadcast(text) == text ? 1 : 0;
  int all = 0;
  MPI_Allreduce(&same, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  return all == 1;
}

std::unique_ptr<Team> MpiSession::MakeTeam(const SweepPlan& plan, int threads) {
  return std::make_unique<MpiTeam>(plan, threads, &lost_);
}

void MpiSession::Serve(const SweepPlan& plan, int threads) {
  Crew crew(plan, threads);
  GatherInts(crew.hands());
  Outbox outbox;
  std::vector<FinishedRun> done;
  Clock::time_point heard = Clock::now(), said = heard;
  bool ended = false;
  while (Clock::now() - heard < (ended ? kSilence : kGoneRoot)) {
    for (Message message = Receive(); message.from >= 0; message = Receive()) {
      heard = Clock::now();
      if (message.tag == kEnd) {
        lost_ = !message.bytes.empty();
        ended = true;
        break;
      }
      std::vector<std::size_t> runs(message.bytes.size() / sizeof(std::size_t));
      std::memcpy(runs.data(), message.bytes.data(), message.bytes.size());
      crew.Give(runs);
    }
    for (FinishedRun& run : crew.Take(0ms)) done.push_back(std::move(run));
    if (outbox.IsFree()) {
      if (ended) return Send(nullptr, 0, 0, kEnd);
      if (!done.empty() || Clock::now() - said > kSignOfLife) {
        outbox.Send(Pack(done), kResults);
        done.clear();
        said = Clock::now();
      }
    }
    std::this_thread::sleep_for(kLook);
  }
  lost_ = alone_ = true;
}

}  // namespace uiclink
