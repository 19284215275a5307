// The available print modes: layered, and continuous after some layers. No other module knows which mode
// runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/print/print_mode.hpp"
#include "hw/machine.hpp"

namespace contourd {

// Returns the mode that carries out this printer's prints, and makes the machine safe. All arguments must
// outlive it.
[[nodiscard]] std::unique_ptr<PrintMode> make_print_mode(Machine& machine, Clock& clock,
                                                         PrintObserver& observer);

// Returns the states of all modes, each name once.
[[nodiscard]] std::vector<PrintState> print_states();

// Draws the modes' tables as a Graphviz graph, with the rows for Failed, which are alike, as one; also the
// tables for manual control, homing, and a serial projector's power and light.
[[nodiscard]] std::string draw_print_states();

}  // namespace contourd
