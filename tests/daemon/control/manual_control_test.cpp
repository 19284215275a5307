#include "daemon/control/manual_control.hpp"

#include <map>

#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"

using Json = ManualControl::Json;

namespace {

constexpr std::uint64_t kFirst = 7, kOther = 8;

class ManualControlFixture : public testing::ControlFixture {
 public:
  // Calls the method and returns why it is refused; empty if it is not.
  std::string refusal_of(const std::string& method, const Json& parameters = Json::object(),
                         std::uint64_t connection = kFirst) {
    try {
      const ControlMethod& called = methods.at(method);
      const ControlMethod::Later later = [this](const auto& result) { reply = std::get<Json>(result); };
      const Json checked = called.check(method, parameters);
      if (called.call_later)
        called.call_later(checked, {connection}, later);
      else
        reply = called.call(checked, {connection});
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    } catch (const InvalidParameters& invalid) {
      return invalid.what();
    }
    return "";
  }
  // Advances the machine's time to the state; the loop does not run.
  bool run_machine_to(ManualState state) {
    while (manual.state() != state) {
      if (!clock.run_next()) return false;
    }
    return true;
  }
  void home() {
    REQUIRE(refusal_of("home").empty());
    REQUIRE(run_machine_to(ManualState::Idle));
  }

  Worker worker{loop, "test"};
  ManualControl control{context, {hold, job, scheduler, status}, manual, worker};
  ControlMethods methods = control.methods();
  Json reply;
};

}  // namespace

TEST_CASE("Commands that cause motion or light need service rights, and commands that stop them do not") {
  ManualControlFixture fixture;
  for (const auto& [name, method] : fixture.methods) {
    CAPTURE(name);
    CHECK(method.changes == (name != "inputs" && name != "upload"));
    CHECK(method.needs_service_rights == (name != "stop" && name != "light_off" && name != "inputs"));
  }
}

TEST_CASE("Manual control is refused while a job is running") {
  ManualControlFixture fixture;
  fixture.begin();
  const std::map<std::string, Json> needed{{"light_on", {{"seconds", 1}}},
                                           {"upload", {{"from", 0}, {"data", "AAAA"}}}};
  for (const auto& [name, method] : fixture.methods) {
    CAPTURE(name);
    const auto parameters = needed.find(name);
    CHECK(fixture.refusal_of(name, parameters == needed.end() ? Json::object() : parameters->second)
              .starts_with("part is being printed: "));
  }
  CHECK(fixture.manual.operations() == 0);
}

TEST_CASE("A move needs a known height, one target within the travel, and a speed within the axis' range") {
  ManualControlFixture fixture;
  CHECK(fixture.refusal_of("move", {{"to_mm", 5}}) == "the plate's position is unknown: home first");
  fixture.home();
  CHECK(fixture.refusal_of("move") == "move takes either to_mm or by_mm");
  CHECK(fixture.refusal_of("move", {{"to_mm", 5}, {"by_mm", 1}}) == "move takes either to_mm or by_mm");
  CHECK(fixture.refusal_of("move", {{"to_mm", -1}}) == "to_mm must be a number from 0 to 160 mm");
  CHECK(fixture.refusal_of("move", {{"to_mm", "up"}}) == "to_mm must be a number from 0 to 160 mm");
  CHECK(fixture.refusal_of("move", {{"by_mm", -1}}) ==
        "the plate cannot go to -1.000 mm: it is at 0.000 mm and goes from 0 to 160 mm");
  CHECK(fixture.refusal_of("move", {{"to_mm", 5}, {"speed_mm_s", 0}})
            .starts_with("speed_mm_s must be a number from 0.01 to "));
  CHECK(fixture.manual.operations() == 1);
  CHECK(fixture.refusal_of("move", {{"to_mm", 5}}).empty());
  CHECK(fixture.reply["manual"]["state"] == "moving");
  CHECK(fixture.reply["manual"]["operations"] == 2);
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  CHECK(fixture.refusal_of("move", {{"by_mm", -2.5}, {"speed_mm_s", 1}}).empty());
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  CHECK(fixture.machine.z_axis().height() == Nanometers{2'500'000});
}

TEST_CASE(
    "From an unknown position the plate moves a short distance, slowly, and only if nothing is in its way") {
  ManualControlFixture fixture;
  const std::string alone = "unhomed takes by_mm, but neither to_mm nor speed_mm_s";
  CHECK(fixture.refusal_of("move", {{"unhomed", true}}) == alone);
  CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"to_mm", 1}}) == alone);
  CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"by_mm", 1}, {"speed_mm_s", 1}}) == alone);
  CHECK(fixture.refusal_of("move", {{"unhomed", 1}, {"by_mm", 1}}) == "unhomed must be true or false");
  for (const double distance : {2.1, -2.1})
    CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"by_mm", distance}}) ==
          "by_mm must be a number from -2 to 2 mm without a known position");
  CHECK(fixture.manual.operations() == 0);
  CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"by_mm", 2}}).empty());
  CHECK(fixture.reply["manual"]["state"] == "moving");
  const TimePoint begun = fixture.clock.now();
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  CHECK(fixture.clock.now() - begun >= std::chrono::seconds{2});
  CHECK(fixture.manual.problem().empty());
  // The direction of down is unknown, so both are refused.
  fixture.hold.set_plate_occupant("gear");
  for (const int distance : {1, -1}) {
    CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"by_mm", distance}}).find("gear is on the plate") !=
          std::string::npos);
    CHECK(fixture.refusal_of("move", {{"unhomed", true}, {"by_mm", distance}, {"plate_is_clear", true}})
              .empty());
    REQUIRE(fixture.run_machine_to(ManualState::Idle));
  }
}

TEST_CASE("The plate is not lowered onto a part or while the queue is held, unless it is declared clear") {
  for (const bool held : {false, true}) {
    CAPTURE(held);
    ManualControlFixture fixture;
    fixture.home();
    REQUIRE(fixture.refusal_of("move", {{"to_mm", 20}}).empty());
    REQUIRE(fixture.run_machine_to(ManualState::Idle));
    if (held)
      fixture.hold.hold("the emergency stop was pressed");
    else
      fixture.hold.set_plate_occupant("gear");
    const std::string why = held ? "the emergency stop was pressed" : "gear is on the plate";
    CHECK(fixture.refusal_of("home").find(why) != std::string::npos);
    CHECK(fixture.refusal_of("move", {{"by_mm", -1}}).find(why) != std::string::npos);
    CHECK(fixture.refusal_of("move", {{"by_mm", 1}}).empty());
    REQUIRE(fixture.run_machine_to(ManualState::Idle));
    CHECK(fixture.refusal_of("home", {{"plate_is_clear", 1}}) == "plate_is_clear must be true or false");
    CHECK(fixture.refusal_of("home", {{"plate_is_clear", true}}).empty());
  }
}

TEST_CASE("Manual light has a time limit and needs a ready machine and a plate above the resin") {
  ManualControlFixture fixture;
  const std::string in_resin = "below 30 mm it may be in the resin; add in_resin to allow that";
  CHECK(fixture.refusal_of("light_on") == "seconds must be a number from 0.001 to 30 s");
  CHECK(fixture.refusal_of("light_on", {{"seconds", 31}}) == "seconds must be a number from 0.001 to 30 s");
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}}) ==
        "the light stays off: the plate is at an unknown height, and " + in_resin);
  fixture.home();
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}}) ==
        "the light stays off: the plate is at 0.000 mm, and " + in_resin);
  fixture.machine.open_lid();
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}, {"in_resin", true}}) ==
        "the light stays off: the lid is open");
  fixture.machine.close_lid();
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}, {"in_resin", true}}).empty());
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  REQUIRE(fixture.refusal_of("move", {{"to_mm", 30}}).empty());
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}}) ==
        "the printer is already controlled by hand (moving): stop ends the operation");
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  CHECK(fixture.refusal_of("light_on", {{"seconds", 1}}).empty());
}

TEST_CASE("While manual light may be on, neither the plate moves nor the picture changes") {
  ManualControlFixture fixture;
  REQUIRE(fixture.refusal_of("light_on", {{"seconds", 10}, {"in_resin", true}}).empty());
  REQUIRE(fixture.run_machine_to(ManualState::Lit));
  CHECK(fixture.refusal_of("home") ==
        "the printer is already controlled by hand (lit): stop ends the operation");
  CHECK(fixture.refusal_of("show", {{"pattern", "grid"}}) == "the light is on: the picture stays as it is");
  CHECK(fixture.refusal_of("light_off").empty());
  CHECK(fixture.reply["manual"]["state"] == "extinguishing");
  CHECK(fixture.run_machine_to(ManualState::Idle));
  CHECK_FALSE(fixture.machine.light_is_on());
}

TEST_CASE("A manual operation ends with the connection that began it, not with another one") {
  ManualControlFixture fixture;
  fixture.home();
  REQUIRE(fixture.refusal_of("show", {{"pattern", "grid"}}, kOther).empty());
  REQUIRE(fixture.refusal_of("move", {{"to_mm", 100}}).empty());
  fixture.control.disconnected(kOther);
  CHECK(fixture.manual.picture().empty());
  CHECK(fixture.manual.state() == ManualState::Moving);
  fixture.control.disconnected(kFirst);
  CHECK(fixture.manual.state() == ManualState::Braking);
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  // The first connection no longer owns the operation of another one.
  REQUIRE(fixture.refusal_of("home", Json::object(), kOther).empty());
  fixture.control.disconnected(kFirst);
  CHECK(fixture.manual.state() == ManualState::Homing);
}

TEST_CASE("Stop ends a motion and the picture, from any connection") {
  ManualControlFixture fixture;
  fixture.home();
  REQUIRE(fixture.refusal_of("show", {{"pattern", "grid"}}).empty());
  REQUIRE(fixture.refusal_of("move", {{"to_mm", 100}}).empty());
  CHECK(fixture.refusal_of("stop", Json::object(), kOther).empty());
  CHECK(fixture.reply["manual"]["state"] == "braking");
  CHECK(fixture.reply["manual"]["picture"].is_null());
}

TEST_CASE("The position is unknown after the motor's current was turned off") {
  ManualControlFixture fixture;
  fixture.home();
  CHECK(fixture.refusal_of("motor_off").empty());
  CHECK(fixture.reply["manual"]["height_mm"].is_null());
}

TEST_CASE("An unknown pattern or power is refused with a list of the valid values") {
  ManualControlFixture fixture;
  CHECK(fixture.refusal_of("show", {{"pattern", "gird"}}) ==
        "pattern must be one of white, black, grid, checker, focus, border, dimensions");
  CHECK(fixture.refusal_of("show", {{"pattern", 3}}) == fixture.refusal_of("show"));
  CHECK(fixture.refusal_of("show", {{"pattern", "grid"}, {"seconds", 601}}) ==
        "seconds must be a number from 0.001 to 600 s");
  CHECK(fixture.refusal_of("projector", {{"power", "of"}}) == "power must be one of on, off");
  CHECK(fixture.manual.operations() == 0);
}

TEST_CASE("The status contains the projector's state after the projector has answered") {
  ManualControlFixture fixture;
  REQUIRE(fixture.refusal_of("projector", {{"power", "on"}}).empty());
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  REQUIRE(fixture.refusal_of("projector").empty());
  REQUIRE(fixture.run_machine_to(ManualState::Idle));
  CHECK(fixture.status.status()["manual"]["projector"]["powered"] == true);
}

TEST_CASE("The current inputs are reported, even while the plate moves") {
  ManualControlFixture fixture;
  REQUIRE(fixture.refusal_of("inputs").empty());
  CHECK(fixture.reply ==
        Json::parse(
            R"({"inputs": [{"name": "limit switch", "line": "simulated", "active": false, "edges": 0}]})"));
  fixture.home();
  REQUIRE(fixture.refusal_of("move", {{"to_mm", 100}}).empty());
  REQUIRE(fixture.refusal_of("inputs").empty());
  CHECK(fixture.reply["inputs"][0]["active"] == true);
  CHECK(fixture.reply["inputs"][0]["edges"] == 3);
  CHECK(fixture.manual.state() == ManualState::Moving);
}
