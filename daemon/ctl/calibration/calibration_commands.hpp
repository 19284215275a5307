// The commands that calibrate a resin and a projector. Each function adds commands to the program or to a
// group. The commands throw exceptions for problems with the data or the daemon (see exit_codes.hpp).
#pragma once

#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Adds the group `calibrate`, which makes calibration prints.
void add_calibrate(Command& program);
// Adds the group `fit`, which computes figures from what was measured on them.
void add_fit(Command& program);

// Add the commands of both groups for the resin's working curve and for the projector's gamma.
void add_calibrate_windows(Command& calibrate);
void add_fit_windows(Command& fit);

// Add the commands of both groups for models that are printed as jobs: the tower of exposures, the bridges
// for the memory at a peel, and the rows of blocks for shrinkage and growth.
void add_calibrate_models(Command& calibrate);
void add_fit_models(Command& fit);
void add_fit_exposure(Command& fit);

// Add the commands of both groups for the lamp's light over the display.
void add_calibrate_lamp(Command& calibrate);
void add_fit_lamp(Command& fit);

}  // namespace contourd::ctl
