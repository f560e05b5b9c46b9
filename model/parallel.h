#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace uiclink {

/// Threads to use: as asked, or as many as the machine has.
inline int CountThreads(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Calls work(0) .. work(size - 1) on `threads` threads (0: as many as the machine has). Each index is handled once;
/// the results must not depend on the order. `work` must not throw. `on_done(finished)` runs on the calling thread.
inline void ParallelFor(std::size_t size, int threads, const std::function<void(std::size_t)>& work,
                        const std::function<void(std::size_t)>& on_done = nullptr) {
  const std::size_t helpers = std::min(static_cast<std::size_t>(CountThreads(threads)) - 1, size > 0 ? size - 1 : 0);
  std::atomic<std::size_t> next{0}, finished{0};
  const auto take = [&](bool calling) {
    for (std::size_t i = next++; i < size; i = next++) {
      work(i);
      const std::size_t done = ++finished;
      if (calling && on_done) on_done(done);
    }
  };
  std::vector<std::jthread> pool;
  for (std::size_t i = 0; i < helpers; ++i) pool.emplace_back([&] { take(false); });
  take(true);
}

}  // namespace uiclink
