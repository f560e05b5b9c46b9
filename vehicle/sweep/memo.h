#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace uiclink {

/// Things that are made once for each key and shared by threads: one makes it, the others wait. What making it throws,
/// everybody gets who asks for that key.
template <typename T>
class Memo {
 public:
  /// @param most  the oldest ones are forgotten beyond that many; 0: none is.
  explicit Memo(std::size_t most = 0) : most_(most) {}

  std::shared_ptr<const T> Get(const std::string& key, const std::function<T()>& make) {
    std::promise<std::shared_ptr<const T>> promise;
    std::shared_future<std::shared_ptr<const T>> made;
    bool mine = false;
    {
      const std::lock_guard lock(mutex_);
      const auto [entry, is_new] = made_.try_emplace(key);
      if (is_new) {
        entry->second = promise.get_future().share();
        order_.push_back(key);
        if (most_ > 0 && order_.size() > most_) {
          made_.erase(order_.front());
          order_.pop_front();
        }
      }
      made = entry->second;
      mine = is_new;
    }
    if (mine) {
      try {
        promise.set_value(std::make_shared<const T>(make()));
      } catch (...) {
        promise.set_exception(std::current_exception());
      }
    }
    return made.get();
  }

 private:
  std::size_t most_;
  std::mutex mutex_;
  std::map<std::string, std::shared_future<std::shared_ptr<const T>>> made_;
  std::deque<std::string> order_;
};

}  // namespace uiclink
