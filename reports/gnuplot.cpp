#include "reports/gnuplot.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "reports/figure.h"

namespace uiclink {
namespace {

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePointer = std::unique_ptr<std::FILE, Closer>;

[[noreturn]] void ThrowSystemError(const std::string& what, int error) {
  throw FigureError("the figure cannot be drawn: " + what + ": " + std::generic_category().message(error));
}

/// A file without a name. Input and output go through files, not pipes, so neither side can fill one up and wait.
FilePointer OpenUnnamed() {
  FilePointer file(std::tmpfile());
  if (!file) ThrowSystemError("no temporary file", errno);
  return file;
}

std::string ReadAll(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char block[1 << 16];
  while (const std::size_t n = std::fread(block, 1, sizeof block, file)) text.append(block, n);
  return text;
}

/// Starts gnuplot with these files as its standard input, output and error.
pid_t Start(std::FILE* in, std::FILE* out, std::FILE* err) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, fileno(in), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, fileno(out), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, fileno(err), STDERR_FILENO);
  char program[] = "gnuplot", no_settings[] = "--default-settings", from_input[] = "-";
  char* const words[] = {program, no_settings, from_input, nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, program, &files, nullptr, words, environ);
  posix_spawn_file_actions_destroy(&files);
  if (error == ENOENT) {
    throw FigureError("the figure cannot be drawn: gnuplot is not installed (Debian package gnuplot-nox)");
  }
  if (error != 0) ThrowSystemError("gnuplot cannot be started", error);
  return child;
}

/// The exit code; -1 if a signal ended the process.
int WaitForEnd(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) ThrowSystemError("gnuplot was lost", errno);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::string RunGnuplot(const std::string& script) {
  const FilePointer in = OpenUnnamed(), out = OpenUnnamed(), err = OpenUnnamed();
  if (std::fwrite(script.data(), 1, script.size(), in.get()) != script.size() || std::fflush(in.get()) != 0) {
    ThrowSystemError("no space for its data", errno);
  }
  std::rewind(in.get());
  const int exit_code = WaitForEnd(Start(in.get(), out.get(), err.get()));
  std::string drawing = ReadAll(out.get());
  if (exit_code != 0 || drawing.empty())
    throw FigureError("the figure cannot be drawn: gnuplot says:\n" + ReadAll(err.get()));
  return drawing;
}

}  // namespace uiclink
