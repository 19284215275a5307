// What a call does to a process whose contracts are checked: it is made in a child, which must not come to
// its end.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

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

// What the call requires and did not get; empty when it broke no contract.
template <typename Call>
[[nodiscard]] std::string contract_broken_by(Call call) {
  int ends[2];
  if (::pipe(ends) != 0) return "no pipe";
  const pid_t child = ::fork();
  if (child == 0) {
    broken_contract_pipe = ends[1];
    on_broken_contract([](const BrokenContract& broken) noexcept {
      ::dprintf(broken_contract_pipe, "%s", broken.requirement);
      ::_exit(EXIT_FAILURE);  // no core dump for each
    });
    call();
    ::_exit(EXIT_SUCCESS);
  }
  ::close(ends[1]);
  std::string requirement = read_all(ends[0]);
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (requirement.empty() && status != 0) return "it ended otherwise, with status " + std::to_string(status);
  return requirement;
}

// Said where costly checks are off, so that their case is shown as skipped.
[[nodiscard]] inline bool costly_checks_are_off() {
  if (!kCostlyChecks) std::printf("SKIPPED: this build makes no costly checks\n");
  return !kCostlyChecks;
}

}  // namespace contourd::testing
