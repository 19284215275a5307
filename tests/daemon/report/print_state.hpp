// States of prints, and the times in them, by their names.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "daemon/print/print_modes.hpp"
#include "daemon/report/state_times.hpp"

namespace contourd::testing {

[[nodiscard]] inline PrintState print_state(std::string_view name) {
  const std::vector<PrintState> states = print_states();
  const auto found = std::ranges::find(states, name, &PrintState::name);
  if (found == states.end()) throw std::invalid_argument("no mode has this state");
  return *found;
}

// Returns the time that a print spent in a state.
[[nodiscard]] inline Duration time_in(const StateTimes& times, std::string_view state) {
  Duration time{};
  for (const StateTimes::Total& total : times.totals())
    if (total.state.name == state) time += total.time;
  return time;
}

}  // namespace contourd::testing
