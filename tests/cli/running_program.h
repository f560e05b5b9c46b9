#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <vector>

#include "tests/cli/program_run.h"

namespace uiclink {

/// A program that is at work beside the test. Killed at the end, if it still is.
class Running {
 public:
  Running(const std::vector<std::string>& words, const RunOptions& options)
      : out_(internal::OpenUnnamed()), err_(internal::OpenUnnamed()) {
    pid_ = fork();
    if (pid_ == 0) internal::RunChild(words, options, out_, err_);
  }
  ~Running() {
    if (pid_ > 0) Signal(SIGKILL), Wait();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int signal) const { kill(pid_, signal); }
  bool Ended() {
    return pid_ <= 0 || waitid(P_PID, static_cast<id_t>(pid_), &info_, WEXITED | WNOHANG | WNOWAIT) != 0 ||
           info_.si_pid != 0;
  }
  ProgramResult Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return {.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            .out = internal::TakeAll(out_),
            .err = internal::TakeAll(err_)};
  }

 private:
  int out_, err_;
  pid_t pid_ = -1;
  siginfo_t info_{};
};

}  // namespace uiclink
