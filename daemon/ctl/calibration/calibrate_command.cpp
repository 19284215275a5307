#include "daemon/ctl/calibration/calibration_commands.hpp"

namespace contourd::ctl {

void add_calibrate(Command& program) {
  Command& calibrate = program.add("calibrate", "Make a calibration print");
  add_calibrate_lamp(calibrate);
  add_calibrate_windows(calibrate);
  add_calibrate_models(calibrate);
}

}  // namespace contourd::ctl
