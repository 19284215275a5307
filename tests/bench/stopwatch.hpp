// Measures the duration of a function: by the steady clock, and as CPU time of all threads of this process,
// which other programs on the machine disturb less. Not thread-safe.
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
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

// Runs the function once to warm up, then `runs` times with the time taken.
template <typename Function>
[[nodiscard]] Times time_runs(int runs, Function&& function) {
  function();
  Times times;
  for (int run = 0; run < runs; ++run)
    time_once(times, function);
  return times;
}

// Calls function(argument) for all arguments in turn, `passes` times, and keeps each argument's best time.
// That removes disturbances by other programs, but keeps the real cost of an argument, with caches full of
// the others.
template <typename Argument, typename Function>
[[nodiscard]] Times best_of_passes(int passes, const std::vector<Argument>& arguments, Function&& function) {
  Times best;
  for (int pass = 0; pass < passes; ++pass) {
    Times times;
    for (const Argument& argument : arguments)
      time_once(times, [&] { function(argument); });
    if (pass == 0) best = times;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      best.wall_s[i] = std::min(best.wall_s[i], times.wall_s[i]);
      best.cpu_s[i] = std::min(best.cpu_s[i], times.cpu_s[i]);
    }
  }
  return best;
}

}  // namespace contourd::bench
