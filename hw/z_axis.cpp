#include "hw/z_axis.hpp"

namespace contourd {

std::string_view describe(HomingResult result) {
  switch (result) {
    case HomingResult::Homed:
      return "homed";
    case HomingResult::NoTrigger:
      return "the limit switch did not trigger after the full travel";
    case HomingResult::StillClosed:
      return "the limit switch is still closed after backing off";
    case HomingResult::WrongSwitch:
      return "the switch at the other end closed: the motor may turn the wrong way";
    case HomingResult::NoMovement:
      return "the encoder does not follow the motor";
    case HomingResult::Fault:
      return "a fault ended homing";
    case HomingResult::Stopped:
      return "homing was stopped";
  }
  return "unknown";
}

std::string_view describe(MoveResult result) {
  switch (result) {
    case MoveResult::Reached:
      return "reached";
    case MoveResult::Stopped:
      return "the move was stopped";
    case MoveResult::OutsideTravel:
      return "the target lies outside the travel";
    case MoveResult::NotHomed:
      return "the position is unknown; home first";
    case MoveResult::Fault:
      return "a fault ended the move";
    case MoveResult::AtSwitch:
      return "the limit switch is reached";
  }
  return "unknown";
}

}  // namespace contourd
