#include "data/file.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "data/input_error.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePointer = std::unique_ptr<std::FILE, Closer>;

/// What the system says, in the words of our messages.
std::string Finding(int error) {
  switch (error) {
    case ENOENT:
      return "nothing of that name";
    case EISDIR:
      return "a directory";
    case ENOTDIR:
      return "a file where its path has a folder";
    case EACCES:
    case EPERM:
      return "no permission";
    case EROFS:
      return "a read-only file system";
    case ENOSPC:
      return "no space left";
    default:
      return "an error: " + std::generic_category().message(error);
  }
}

[[noreturn]] void ThrowUnreadable(const fs::path& path, int error) {
  throw InputError(path.string(), 0, "expected a readable file, found " + Finding(error));
}

[[noreturn]] void ThrowUnwritable(const fs::path& path, int error) {
  throw InputError(path.string(), 0, "expected a file that can be written, found " + Finding(error));
}

/// 0, or the error number. Closing is part of writing: a full disk may show only there.
int Write(const fs::path& path, std::string_view content) {
  errno = 0;
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (!file) return errno;
  int error = 0;
  if (std::fwrite(content.data(), 1, content.size(), file) != content.size()) error = errno;
  if (std::fclose(file) != 0 && error == 0) error = errno;
  return error;
}

/// Beside the file, hence on the same file system; the process number keeps two programs apart, the count two threads.
fs::path TemporaryName(const fs::path& path) {
  static std::atomic<unsigned> count{0};
  const std::string suffix = "." + std::to_string(::getpid()) + "." + std::to_string(count++) + ".tmp";
  return path.parent_path() / ("." + path.filename().string() + suffix);
}

}  // namespace

std::string ReadFileWhole(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) ThrowUnreadable(path, EISDIR);
  errno = 0;
  const FilePointer file(std::fopen(path.c_str(), "rb"));
  if (!file) ThrowUnreadable(path, errno);
  std::string content;
  char block[1 << 16];
  while (const std::size_t n = std::fread(block, 1, sizeof block, file.get())) content.append(block, n);
  if (std::ferror(file.get())) ThrowUnreadable(path, errno);
  return content;
}

void WriteFileWhole(const fs::path& path, std::string_view content) {
  std::error_code error;
  if (path.has_parent_path()) {
    fs::create_directories(path.parent_path(), error);
    if (error) ThrowUnwritable(path, error.value());
  }
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) ThrowUnwritable(path, EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    if (const int failure = Write(path, content)) ThrowUnwritable(path, failure);
    return;
  }
  const fs::path target = fs::exists(status) ? fs::canonical(path) : path;
  const fs::path temporary = TemporaryName(target);
  if (const int failure = Write(temporary, content)) {
    fs::remove(temporary, error);
    ThrowUnwritable(path, failure);
  }
  fs::rename(temporary, target, error);
  if (error) {
    const int failure = error.value();
    fs::remove(temporary, error);
    ThrowUnwritable(path, failure);
  }
}

}  // namespace uiclink
