#include "hw/projector.hpp"
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
      return "the position is unknown, home first";
  }
  return "unknown";
}

std::string_view describe(ProjectorReply reply) {
  switch (reply) {
    case ProjectorReply::Ok:
      return "ok";
    case ProjectorReply::Refused:
      return "the projector refused the command";
    case ProjectorReply::NoAnswer:
      return "the projector does not answer";
  }
  return "unknown";
}

}  // namespace contourd
