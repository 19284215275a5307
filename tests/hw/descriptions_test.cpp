
#include "hw/projector.hpp"
#include "hw/z_axis.hpp"
#include "tests/catch.hpp"

TEST_CASE("Every outcome of the axis and the projector has a description of its own") {
  std::set<std::string_view> words;
  for (const HomingResult r :
       {HomingResult::Homed, HomingResult::NoTrigger, HomingResult::StillClosed, HomingResult::WrongSwitch,
        HomingResult::NoMovement, HomingResult::Fault, HomingResult::Stopped}) {
    CHECK(words.insert(describe(r)).second);
  }
  for (const MoveResult r : {MoveResult::Reached, MoveResult::Stopped, MoveResult::OutsideTravel,
                             MoveResult::NotHomed, MoveResult::Fault, MoveResult::AtSwitch}) {
    CHECK(words.insert(describe(r)).second);
  }
  for (const ProjectorReply r :
       {ProjectorReply::Ok, ProjectorReply::Refused, ProjectorReply::NoAnswer, ProjectorReply::Interlocked}) {
    CHECK(words.insert(describe(r)).second);
  }
  CHECK(words.count("unknown") == 0);
}
