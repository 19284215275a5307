// Brings the plate to a position. If the screw has backlash the plate comes from below, so that it ends
// resting on the screw. If there is an encoder, it checks the position, and with the policy Correct a
// difference is corrected by further steps. Drive and position must outlive this object. Event loop's thread
// only.
#pragma once

#include <functional>
#include <string>
#include <utility>

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

  // Moves to `plate` within a motion of the drive, then calls `there`. REQUIRES: the plate's position is
  // known.
  void begin(Microsteps plate, MillimetersPerSecond speed, std::function<void()> there);

 private:
  void go();
  void verify();
  void compare();
  void arrive() { std::exchange(there_, nullptr)(); }

  AxisDrive& drive_;
  PlatePosition& position_;
  Wiring wiring_;
  Microsteps plate_{};
  MillimetersPerSecond speed_{0};
  std::function<void()> there_;
};

}  // namespace contourd
