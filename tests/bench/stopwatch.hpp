// Times what a function takes: by the steady clock, and the CPU time of all threads of this process (which
// other programs on the machine disturb less). Not thread-safe.
#pragma once

#include <time.h>

#include <chrono>
#include <utility>
#include <vector>

#include "tests/bench/statistics.hpp"

namespace contourd::bench {

struct Times {
  std::vector<double> wall_s, cpu_s;
};

[[nodiscard]] inline double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

template <typename Function>
void time_once(Times& times, Function&& function) {
  const double cpu = process_cpu_s();
  const auto start = std::chrono::steady_clock::now();
  std::forward<Function>(function)();
  const auto end = std::chrono::steady_clock::now();
  times.cpu_s.push_back(process_cpu_s() - cpu);
  times.wall_s.push_back(std::chrono::duration<double>(end - start).count());
}

// A run to warm up, then `runs` timed ones.
template <typename Function>
[[nodiscard]] Times time_runs(int runs, Function&& function) {
  function();
  Times times;
  for (int run = 0; run < runs; ++run)
    time_once(times, function);
  return times;
}

}  // namespace contourd::bench
