#pragma once

#include <filesystem>

namespace uiclink {

/// The right to write a store, by flock on the file beside it ("sweep.sqlite-lock"): it ends with the process, however
/// that ends. The file is removed with the lock, and stays behind after a kill, which does no harm.
class StoreLock {
 public:
  /// @throws InputError if another process has it, naming that.
  explicit StoreLock(const std::filesystem::path& store);
  ~StoreLock();
  StoreLock(const StoreLock&) = delete;
  StoreLock& operator=(const StoreLock&) = delete;

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace uiclink
