// Brings the plate to a position: from below, if the screw has backlash, so that it ends where it bears on
// the screw. An encoder is asked whether it is there, and what is missing is made good where that is the
// policy. Drive and position must outlive it. Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "hw/gpio/axis_drive.hpp"
#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/plate_position.hpp"

namespace contourd {

class PlateApproach {
 public:
  struct Wiring {
    std::function<void(const AxisFault&)> fail;
    std::function<void(const std::string&)> notice;
  };

  PlateApproach(AxisDrive& drive, PlatePosition& position, Wiring wiring);

  // To `plate`, within a motion of the drive; then calls `there`. REQUIRES: the position is
  // known.
  void begin(Microsteps plate, MillimetersPerSecond speed, std::function<void()> there);

 private:
  void go();
  void verify();
  void compare();
  void arrive();

  AxisDrive& drive_;
  PlatePosition& position_;
  Wiring wiring_;
  Microsteps plate_{};
  MillimetersPerSecond speed_{0};
  std::function<void()> there_;
};

}  // namespace contourd
