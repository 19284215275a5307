#include "daemon/print/print_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/print/continuous_print.hpp"
#include "daemon/print/continuous_states.hpp"
#include "daemon/print/layered_states.hpp"
#include "daemon/print/manual_states.hpp"
#include "hw/gpio/homing_states.hpp"
#include "hw/serial/projector_light_states.hpp"
#include "hw/serial/projector_power_states.hpp"

namespace contourd {

std::unique_ptr<PrintMode> make_print_mode(Machine& machine, Clock& clock, PrintObserver& observer) {
  return std::make_unique<ContinuousPrint>(machine, clock, observer);
}

std::vector<PrintState> print_states() {
  const auto layered = layered_print_states();
  std::vector<PrintState> states(layered.begin(), layered.end());
  for (const PrintState& state : continuous_print_states()) {
    const bool is_seen = state.name != name_of(ContinuousState::Layering);
    if (is_seen && std::ranges::find(states, state.name, &PrintState::name) == states.end())
      states.push_back(state);
  }
  return states;
}

std::string draw_print_states() {
  std::string graph =
      "digraph print {\n  node [shape=box, style=rounded];\n  \"any state\" [style=dashed];\n";
  bool failure_drawn = false;
  for_each_transition(layered_table(), [&](auto from, auto on, const LayeredTransition& row) {
    if (on == LayeredEvent::Failed && std::exchange(failure_drawn, true)) return;
    graph += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"];\n",
                         on == LayeredEvent::Failed ? "any state" : name_of(from), name_of(row.next(from)),
                         label_of(on, row));
  });
  graph += draw_table("continuous", continuous_table());
  graph += draw_table("by hand", manual_table());
  graph += draw_table("homing", homing_table());
  graph += draw_table("projector power", projector_power_table());
  graph += draw_table("projector light", projector_light_table());
  return graph + "}\n";
}

}  // namespace contourd
