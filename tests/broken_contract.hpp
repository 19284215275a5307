// Runs a call in a child process with checked contracts and reports the contract that it breaks.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/contract/expects.hpp"

namespace contourd::testing {

inline int broken_contract_pipe = -1;

inline std::string read_all(int descriptor) {
  std::string all;
  char bytes[512];
  for (ssize_t count = 0; (count = ::read(descriptor, bytes, sizeof bytes)) > 0;)
    all.append(bytes, static_cast<std::size_t>(count));
  return all;
}

// The result of one child process. If another thread held a lock when the child was forked, the lock is never
// released in the child, and an alarm ends it.
struct ContractTrial {
  std::string requirement;
  int status = 0;
};
template <typename Call>
[[nodiscard]] ContractTrial try_contract(const Call& call) {
  constexpr unsigned kLongestSeconds = 10;
  int ends[2];
  if (::pipe(ends) != 0) return {"no pipe", 0};
  const pid_t child = ::fork();
  if (child == 0) {
    broken_contract_pipe = ends[1];
    on_broken_contract([](const BrokenContract& broken) noexcept {
      ::dprintf(broken_contract_pipe, "%s", broken.requirement);
      ::_exit(EXIT_FAILURE);  // no core dump for each
    });
    ::alarm(kLongestSeconds);
    call();
    ::_exit(EXIT_SUCCESS);
  }
  ::close(ends[1]);
  ContractTrial trial;
  trial.requirement = read_all(ends[0]);
  ::close(ends[0]);
  ::waitpid(child, &trial.status, 0);
  return trial;
}

// Returns the requirement that the call breaks; empty if it breaks none.
template <typename Call>
[[nodiscard]] std::string contract_broken_by(const Call& call) {
  constexpr int kTrials = 3;
  ContractTrial trial = try_contract(call);
  for (int i = 1; i < kTrials && WIFSIGNALED(trial.status) && WTERMSIG(trial.status) == SIGALRM; ++i)
    trial = try_contract(call);
  if (trial.requirement.empty() && trial.status != 0)
    return "it ended without a broken contract, with status " + std::to_string(trial.status);
  return trial.requirement;
}

// True if costly checks are off; then also prints the line that marks the test case as skipped.
[[nodiscard]] inline bool costly_checks_are_off() {
  if (!kCostlyChecks) std::printf("SKIPPED: this build makes no costly checks\n");
  return !kCostlyChecks;
}

}  // namespace contourd::testing
