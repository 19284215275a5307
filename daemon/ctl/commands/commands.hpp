// The commands that control contourd or look at its computer. Each function adds a command, or related
// commands, to the program. The commands throw exceptions for problems with the data or the daemon (see
// exit_codes.hpp).
#pragma once

#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Shows the picture on the printer's display.
void add_mask(Command& program);
void add_status(Command& program);
// Adds queue and accept.
void add_queue(Command& program);
// Adds history, usage and replaced.
void add_history(Command& program);
// Checks a waiting job and the printer before the first light.
void add_preflight(Command& program);
// Adds pause, set, exclude, resume, cancel, plate-cleared and rescue.
void add_print_control(Command& program);
void add_resume(Command& program);
// Lifts the part of an interrupted print out of the resin.
void add_rescue(Command& program);
// Adds vat and vat filled.
void add_vat(Command& program);
// Shows contourd's lines in the journal.
void add_logs(Command& program);
// Adds the commands that check and show a printer's configuration.
void add_config(Command& program);
// Adds export prusaslicer, which writes profiles of the printer for a slicer.
void add_export(Command& program);
// Collects the facts for a bug report in one small archive without secrets.
void add_diagnose(Command& program);
// Adds home, move, stop, motor, light, show and projector, which work only while no job is printed.
void add_manual(Command& program);
// Shows the live states of the printer's inputs, for wiring.
void add_switches(Command& program);
// Moves the plate by keys, in a terminal.
void add_jog(Command& program);
// Levels the plate, step by step, together with the user at the printer.
void add_level(Command& program);
// Adds web password and web addresses, which set up the printer's web page.
void add_web(Command& program);
// Shows the manual page, or the usage of a command of `program`.
void add_help(Command& program);
// Adds complete and describe, by which shells and the manual page get the description of the commands.
void add_description(Command& program);

}  // namespace contourd::ctl
