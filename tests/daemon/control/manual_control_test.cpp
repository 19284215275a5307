#include "daemon/control/manual_control.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

using namespace contourd;
using Json = ManualControl::Json;

namespace {

constexpr std::uint64_t kOwner = 7, kOther = 8;

class Desk : public testing::CurrentJobFixture {
 public:
  // Why the method is refused; empty when it is not.
  std::string refusal_of(const std::string& method, const Json& parameters = Json::object(),
                         std::uint64_t connection = kOwner) {
    try {
      const ControlMethod& called = methods.at(method);
      // What comes later is tested with the loop.
      const ControlMethod::Later later = [](const auto&) { FAIL("later"); };
      reply = called.call_later ? called.call_later(parameters, {connection}, later).value()
                                : called.call(parameters, {connection});
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    } catch (const InvalidParameters& invalid) {
      return invalid.what();
    }
    return "";
  }
  // The machine's time goes on; the loop does not run.
  bool run_machine_to(ManualState state) {
    while (process.state() != state) {
      if (!clock.run_next()) return false;
    }
    return true;
  }
  void home() {
    REQUIRE(refusal_of("home").empty());
    REQUIRE(run_machine_to(ManualState::Idle));
  }

  PrintQueue queue{
      log.log,
      {.check = [](const std::string&, JobReader::Keep, const auto& done) { done(JobOutlook{}); },
       .forget = [](const std::string&) {},
       .reject = [](const std::string&, const std::string&, const Spool::Rejected&) {},
       .changed = [] {},
       .refused = [](const std::string&, const std::string&) {},
       .removed = [](const std::string&, const std::string&) {},
       .keep_order = [](const QueueOrder::Names&, const auto&) {}}};
  JobScheduler scheduler{context,
                         spool,
                         queue,
                         hold,
                         {.has_job = [this] { return job.job() != nullptr; },
                          .prints = [this] { return job.print().state() != PrintState::Idle; },
                          .controlled_by_hand = [] { return false; },
                          .begin = [](const ClaimedJob&) {},
                          .copy_over = [] {}}};
  JobHistory history;
  ManualProcess process{machine, clock, [] {}};
  ReminderConfig reminder_config;
  Reminders reminders{reminder_config};
  PrinterStatus status{context, {spool, queue, scheduler, hold, job, history, process, reminders}};
  Worker worker{loop, "test"};
  ManualControl control{context, {hold, job, scheduler, status}, process, worker};
  ControlMethods methods = control.methods();
  Json reply;
};

}  // namespace

TEST_CASE(
    "Commands that move the plate or turn on the light need service rights, and commands that stop them do "
    "not") {
  Desk desk;
  for (const auto& [name, method] : desk.methods) {
    CAPTURE(name);
    CHECK(method.changes == (name != "inputs" && name != "upload"));
    CHECK(method.needs_service_rights == (name != "stop" && name != "light_off" && name != "inputs"));
  }
}

TEST_CASE("Nothing is done by hand while a job is under way") {
  Desk desk;
  desk.begin();
  for (const auto& [name, method] : desk.methods) {
    CAPTURE(name);
    CHECK(desk.refusal_of(name).starts_with("part is being printed: "));
  }
  CHECK(desk.process.operations() == 0);
}

TEST_CASE("A move wants a known height, one target within the travel, and a speed that the axis has") {
  Desk desk;
  CHECK(desk.refusal_of("move", {{"to_mm", 5}}) == "the plate's position is unknown: home comes first");
  desk.home();
  CHECK(desk.refusal_of("move") == "move takes either to_mm or by_mm");
  CHECK(desk.refusal_of("move", {{"to_mm", 5}, {"by_mm", 1}}) == "move takes either to_mm or by_mm");
  CHECK(desk.refusal_of("move", {{"to_mm", -1}}) == "to_mm is a number from 0 to 160 mm");
  CHECK(desk.refusal_of("move", {{"to_mm", "up"}}) == "to_mm is a number from 0 to 160 mm");
  CHECK(desk.refusal_of("move", {{"by_mm", -1}}) ==
        "the plate cannot go to -1.000 mm: it is at 0.000 mm and goes from 0 to 160 mm");
  CHECK(desk.refusal_of("move", {{"to_mm", 5}, {"speed_mm_s", 0}})
            .starts_with("speed_mm_s is a number from 0.01 to "));
  CHECK(desk.process.operations() == 1);
  CHECK(desk.refusal_of("move", {{"to_mm", 5}}).empty());
  CHECK(desk.reply["manual"]["state"] == "moving");
  CHECK(desk.reply["manual"]["operations"] == 2);
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  CHECK(desk.refusal_of("move", {{"by_mm", -2.5}, {"speed_mm_s", 1}}).empty());
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  CHECK(desk.machine.z_axis().height() == Nanometers{2'500'000});
}

TEST_CASE("From nobody knows where the plate goes a short way, slowly, and only when nothing is in its way") {
  Desk desk;
  const std::string alone = "unhomed goes with by_mm, and neither to_mm nor speed_mm_s";
  CHECK(desk.refusal_of("move", {{"unhomed", true}}) == alone);
  CHECK(desk.refusal_of("move", {{"unhomed", true}, {"to_mm", 1}}) == alone);
  CHECK(desk.refusal_of("move", {{"unhomed", true}, {"by_mm", 1}, {"speed_mm_s", 1}}) == alone);
  CHECK(desk.refusal_of("move", {{"unhomed", 1}, {"by_mm", 1}}) == "unhomed is true or false");
  for (const double way : {2.1, -2.1})
    CHECK(desk.refusal_of("move", {{"unhomed", true}, {"by_mm", way}}) ==
          "by_mm is a number from -2 to 2 mm without a known position");
  CHECK(desk.process.operations() == 0);
  CHECK(desk.refusal_of("move", {{"unhomed", true}, {"by_mm", 2}}).empty());
  CHECK(desk.reply["manual"]["state"] == "moving");
  const TimePoint begun = desk.clock.now();
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  CHECK(desk.clock.now() - begun >= std::chrono::seconds{2});
  CHECK(desk.process.problem().empty());
  // Which way is down nobody knows.
  desk.hold.set_plate_occupant("gear");
  for (const int way : {1, -1}) {
    CHECK(desk.refusal_of("move", {{"unhomed", true}, {"by_mm", way}}).find("gear is on the plate") !=
          std::string::npos);
    CHECK(desk.refusal_of("move", {{"unhomed", true}, {"by_mm", way}, {"plate_is_clear", true}}).empty());
    REQUIRE(desk.run_machine_to(ManualState::Idle));
  }
}

TEST_CASE("The plate does not go down on a part or a held queue, unless that is said to be in no way") {
  for (const bool held : {false, true}) {
    CAPTURE(held);
    Desk desk;
    desk.home();
    REQUIRE(desk.refusal_of("move", {{"to_mm", 20}}).empty());
    REQUIRE(desk.run_machine_to(ManualState::Idle));
    if (held)
      desk.hold.hold("the emergency stop was pressed");
    else
      desk.hold.set_plate_occupant("gear");
    const std::string why = held ? "the emergency stop was pressed" : "gear is on the plate";
    CHECK(desk.refusal_of("home").find(why) != std::string::npos);
    CHECK(desk.refusal_of("move", {{"by_mm", -1}}).find(why) != std::string::npos);
    CHECK(desk.refusal_of("move", {{"by_mm", 1}}).empty());
    REQUIRE(desk.run_machine_to(ManualState::Idle));
    CHECK(desk.refusal_of("home", {{"plate_is_clear", 1}}) == "plate_is_clear is true or false");
    CHECK(desk.refusal_of("home", {{"plate_is_clear", true}}).empty());
  }
}

TEST_CASE("Light by hand has a limit, wants a machine that is ready, and a plate out of the resin") {
  Desk desk;
  const std::string in_resin = "below 30 mm it may be in the resin; in_resin allows that";
  CHECK(desk.refusal_of("light_on") == "light_on takes seconds");
  CHECK(desk.refusal_of("light_on", {{"seconds", 31}}) == "seconds is a number from 0.001 to 30 s");
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}}) ==
        "the light stays off: the plate is nobody knows where, and " + in_resin);
  desk.home();
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}}) ==
        "the light stays off: the plate is at 0.000 mm, and " + in_resin);
  desk.machine.open_lid();
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}, {"in_resin", true}}) ==
        "the light stays off: the lid is open");
  desk.machine.close_lid();
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}, {"in_resin", true}}).empty());
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  REQUIRE(desk.refusal_of("move", {{"to_mm", 30}}).empty());
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}}) ==
        "the printer is controlled by hand already (moving): stop ends that");
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  CHECK(desk.refusal_of("light_on", {{"seconds", 1}}).empty());
}

TEST_CASE("While there may be light by hand, neither the plate moves nor the picture changes") {
  Desk desk;
  REQUIRE(desk.refusal_of("light_on", {{"seconds", 10}, {"in_resin", true}}).empty());
  REQUIRE(desk.run_machine_to(ManualState::Lit));
  CHECK(desk.refusal_of("home") == "the printer is controlled by hand already (lit): stop ends that");
  CHECK(desk.refusal_of("show", {{"pattern", "grid"}}) == "the light is on: the picture stays as it is");
  CHECK(desk.refusal_of("light_off").empty());
  CHECK(desk.reply["manual"]["state"] == "extinguishing");
  CHECK(desk.run_machine_to(ManualState::Idle));
  CHECK_FALSE(desk.machine.light_is_on());
}

TEST_CASE("What somebody began by hand ends with the connection that it came by, and no other") {
  Desk desk;
  desk.home();
  REQUIRE(desk.refusal_of("show", {{"pattern", "grid"}}, kOther).empty());
  REQUIRE(desk.refusal_of("move", {{"to_mm", 100}}).empty());
  desk.control.disconnected(kOther);
  CHECK(desk.process.picture().empty());
  CHECK(desk.process.state() == ManualState::Moving);
  desk.control.disconnected(kOwner);
  CHECK(desk.process.state() == ManualState::Braking);
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  // A later connection's operation is none of the first one's.
  REQUIRE(desk.refusal_of("home", Json::object(), kOther).empty());
  desk.control.disconnected(kOwner);
  CHECK(desk.process.state() == ManualState::Homing);
}

TEST_CASE("Stop ends a motion and the picture, whoever asks for it") {
  Desk desk;
  desk.home();
  REQUIRE(desk.refusal_of("show", {{"pattern", "grid"}}).empty());
  REQUIRE(desk.refusal_of("move", {{"to_mm", 100}}).empty());
  CHECK(desk.refusal_of("stop", Json::object(), kOther).empty());
  CHECK(desk.reply["manual"]["state"] == "braking");
  CHECK(desk.reply["manual"]["picture"].is_null());
}

TEST_CASE("Without its current the motor's position is unknown") {
  Desk desk;
  desk.home();
  CHECK(desk.refusal_of("motor_off").empty());
  CHECK(desk.reply["manual"]["height_mm"].is_null());
}

TEST_CASE("A pattern that there is none of names those there are, and so does a projector's power") {
  Desk desk;
  CHECK(desk.refusal_of("show", {{"pattern", "gird"}}) ==
        "pattern is one of white, black, grid, checker, focus, border, dimensions");
  CHECK(desk.refusal_of("show", {{"pattern", 3}}) == desk.refusal_of("show"));
  CHECK(desk.refusal_of("show", {{"pattern", "grid"}, {"seconds", 601}}) ==
        "seconds is a number from 0.001 to 600 s");
  CHECK(desk.refusal_of("projector", {{"power", "of"}}) == "power is one of on, off");
  CHECK(desk.process.operations() == 0);
}

TEST_CASE("What the projector says of itself is in the reply's status once it has answered") {
  Desk desk;
  REQUIRE(desk.refusal_of("projector", {{"power", "on"}}).empty());
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  REQUIRE(desk.refusal_of("projector").empty());
  REQUIRE(desk.run_machine_to(ManualState::Idle));
  CHECK(desk.status.status()["manual"]["projector"]["powered"] == true);
}

TEST_CASE("The inputs are told as they are, also while the plate moves") {
  Desk desk;
  REQUIRE(desk.refusal_of("inputs").empty());
  CHECK(desk.reply ==
        Json::parse(
            R"({"inputs": [{"name": "limit switch", "line": "simulated", "active": false, "edges": 0}]})"));
  desk.home();
  REQUIRE(desk.refusal_of("move", {{"to_mm", 100}}).empty());
  REQUIRE(desk.refusal_of("inputs").empty());
  CHECK(desk.reply["inputs"][0]["active"] == true);
  CHECK(desk.reply["inputs"][0]["edges"] == 3);
  CHECK(desk.process.state() == ManualState::Moving);
}
