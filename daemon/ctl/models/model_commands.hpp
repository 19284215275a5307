// The commands that read models and records of prints without contourd. Each function adds one command to the
// program. The commands throw exceptions for problems with the data (see exit_codes.hpp).
#pragma once

#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Shows the contents and defects of a model's file.
void add_inspect(Command& program);
// Cuts a model at one height or into layers.
void add_slice(Command& program);
// Forecasts a whole print.
void add_analyze(Command& program);
// Computes the part that the light cures.
void add_cure(Command& program);
// Shows the masks that a continuous print has shown.
void add_frames(Command& program);
// Generates supports.
void add_support(Command& program);
// Finds the best orientation of a model.
void add_orient(Command& program);
// Draws a model, or a job of the spool.
void add_preview(Command& program);

}  // namespace contourd::ctl
