#include "vehicle/sweep/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "data/input_error.h"

namespace uiclink {
namespace {

/// Whether the open file is the one of that name: the process before may have removed it between open and flock.
bool IsStill(int file, const std::filesystem::path& path) {
  struct stat open {};
  struct stat named {};
  return fstat(file, &open) == 0 && stat(path.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
         open.st_dev == named.st_dev;
}

std::string ReadOwner(int file) {
  char text[32] = {};
  const ssize_t size = pread(file, text, sizeof text - 1, 0);
  return size > 0 ? " (process " + std::string(text, static_cast<std::size_t>(size)) + ")" : "";
}

}  // namespace

StoreLock::StoreLock(const std::filesystem::path& store) : path_(store.string() + "-lock") {
  for (;;) {
    file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0)
      throw InputError(store.string(), 0, std::string("expected a folder to write to, found: ") + std::strerror(errno));
    if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const bool taken = errno == EWOULDBLOCK;
      const std::string found = taken ? "another one at work on it" + ReadOwner(file_) : std::strerror(errno);
      close(file_);
      throw InputError(store.string(), 0,
                       "expected to be the only process that writes this store, found " + found +
                           (taken ? "; --status looks at it meanwhile" : ""));
    }
    if (IsStill(file_, path_)) break;
    close(file_);
  }
  const std::string owner = std::to_string(getpid());
  if (ftruncate(file_, 0) != 0 || pwrite(file_, owner.data(), owner.size(), 0) < 0) return;  // only for the message
}

StoreLock::~StoreLock() {
  unlink(path_.c_str());
  close(file_);
}

}  // namespace uiclink
