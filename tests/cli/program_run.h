#pragma once

#include <fcntl.h>
#include <grp.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace uiclink {

/// What a program did: exit code (128 + number when a signal ended it) and what it wrote.
struct ProgramResult {
  int exit_code = -1;
  std::string out;
  std::string err;
};

inline std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// How a program is run.
struct RunOptions {
  std::filesystem::path folder;  ///< current folder
  bool unprivileged = false;     ///< as the user "nobody" (65534); needs root
};

namespace internal {

/// Exit codes of the child before the program starts.
inline constexpr int kCannotRun = 126;

[[noreturn]] inline void RunChild(const std::vector<std::string>& words, const RunOptions& options, int out, int err) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  if (chdir(options.folder.c_str()) != 0) _exit(kCannotRun);
  constexpr unsigned kNobody = 65534;
  if (options.unprivileged && (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0))
    _exit(kCannotRun);
  execv(argv[0], argv.data());
  _exit(kCannotRun);
}

/// A file without a name, for the output of a child: a pipe could fill up and stall it.
inline int OpenUnnamed() {
  std::string name = (std::filesystem::temp_directory_path() / "uiclink_output_XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) throw std::runtime_error("no temporary file " + name);
  unlink(name.c_str());
  return file;
}

inline std::string TakeAll(int file) {
  std::string text;
  char block[1 << 16];
  lseek(file, 0, SEEK_SET);
  for (ssize_t n = 0; (n = read(file, block, sizeof block)) > 0;) text.append(block, static_cast<std::size_t>(n));
  close(file);
  return text;
}

}  // namespace internal

/// Runs words[0], a path, with the other words as arguments, no input, and waits for its end.
inline ProgramResult RunProgram(const std::vector<std::string>& words, const RunOptions& options) {
  const int out = internal::OpenUnnamed(), err = internal::OpenUnnamed();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process for " + words[0]);
  if (child == 0) internal::RunChild(words, options, out, err);
  int status = 0;
  waitpid(child, &status, 0);
  ProgramResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = internal::TakeAll(out);
  result.err = internal::TakeAll(err);
  return result;
}

}  // namespace uiclink
