#include "daemon/jobs/current_job.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

using namespace contourd;
using Desk = contourd::testing::CurrentJobFixture;
namespace fs = std::filesystem;

namespace {

bool was_told(const Desk& desk, const std::string& what) {
  return std::ranges::find(desk.told, what) != desk.told.end();
}

bool has_printed(const Desk& desk) {
  return was_told(desk, "state: warming up");
}

}  // namespace

TEST_CASE("A job is read, printed and filed, and each layer is told") {
  Desk desk;
  desk.begin();
  CHECK(desk.job.job() != nullptr);
  CHECK(desk.job.name() == "part");
  REQUIRE(desk.run_to_end());
  CHECK(desk.ended[0].outcome == "done");
  CHECK(desk.job.job() == nullptr);
  CHECK(desk.has("done/part.stl"));
  CHECK(desk.has("done/part.report.json"));
  CHECK(std::ranges::count(desk.told, "changed: layer") == 4);  // 0.2 mm
  CHECK(was_told(desk, "memory freed"));
}

TEST_CASE("The disk knows that the plate is occupied before there is any light") {
  Desk desk;
  desk.begin();
  bool lit = false;
  REQUIRE(desk.run_to_end([&] {
    if (!desk.machine.light_is_on()) return;
    lit = true;
    CHECK(desk.has_record("plate-occupied"));
  }));
  CHECK(lit);
}

TEST_CASE("A plate that nothing was shown on is clear") {
  Desk desk;
  desk.begin();
  REQUIRE(desk.run_to_end([&] {
    if (desk.job.print().state() == PrintState::Homing) desk.job.cancel();
  }));
  CHECK(desk.ended[0].outcome == "cancelled");
  CHECK_FALSE(desk.hold.plate_occupant());
  CHECK_FALSE(desk.has_record("plate-occupied"));
}

TEST_CASE("What is no model is refused, with its reason beside it, and nothing is printed") {
  Desk desk;
  desk.put_text(Spool::Folder::Incoming, "bad.stl", "no model");
  desk.begin("bad.stl");
  REQUIRE(desk.run_to_end());
  CHECK(desk.ended[0].outcome == "failed");
  CHECK_FALSE(desk.ended[0].reason.empty());
  CHECK(desk.has("failed/bad.stl"));
  CHECK(desk.has("failed/bad.reason.txt"));
  CHECK_FALSE(has_printed(desk));
  CHECK_FALSE(desk.hold.reason());
}

TEST_CASE("A job that is cancelled while it is read is not printed") {
  Desk desk;
  desk.begin();
  desk.job.cancel();
  REQUIRE(desk.run_to_end());
  CHECK(desk.ended[0].outcome == "cancelled");
  CHECK(desk.ended[0].reason == "cancelled before it started");
  CHECK_FALSE(has_printed(desk));
}

TEST_CASE("A job that had not begun goes back to where it came from") {
  Desk desk;
  desk.begin();
  desk.job.stop("contourd was stopped");
  desk.job.give_back();
  CHECK(desk.job.job() == nullptr);
  CHECK(desk.has("incoming/part.stl"));
  CHECK(desk.log.has("part: had not begun, waits for the next start"));
}

TEST_CASE("A print that begins while the queue is held, or something is in its way, waits for its owner") {
  Desk desk;
  std::string why;
  SECTION("held") {
    desk.hold.hold(why = "the emergency stop was pressed");
  }
  SECTION("in its way") {
    desk.machine.open_lid();
    why = desk.machine.why_not_ready();
  }
  SECTION("both: what is in its way is told") {
    desk.hold.hold("the emergency stop was pressed");
    desk.machine.open_lid();
    why = desk.machine.why_not_ready();
  }
  desk.begin();
  REQUIRE(desk.run_until([&] { return desk.job.print().state() == PrintState::Held; }));
  CHECK(desk.job.print().interruption() == why);
}

TEST_CASE("A failed print holds the queue before its end is told") {
  Desk desk;
  desk.begin();
  bool held_first = false;
  REQUIRE(desk.run_to_end([&] {
    if (desk.job.print().state() == PrintState::Homing) desk.job.print().fail("steps were lost");
    held_first = held_first || (desk.hold.reason() && desk.ended.empty());
  }));
  CHECK(held_first);
  CHECK(desk.hold.reason() == "part failed: steps were lost");
  CHECK(desk.ended[0].outcome == "failed");
  CHECK(desk.ended[0].reason == "steps were lost");
}

TEST_CASE("A print that failed with light leaves that the queue is held to be recorded in the dark") {
  Desk desk;
  desk.begin();
  bool failed = false;
  REQUIRE(desk.run_to_end([&] {
    if (failed || !desk.machine.light_is_on()) return;
    failed = true;
    desk.told.clear();
    desk.hold.hold("the emergency stop was pressed");
    CHECK(desk.hold.due());
    desk.job.print().fail("the emergency stop was pressed");
  }));
  CHECK(failed);
  CHECK(was_told(desk, "light gone"));
  CHECK(desk.has("failed/part.stl"));
}

TEST_CASE("A print that cannot be filed keeps the queue, and is filed with the hold's records") {
  Desk desk;
  const fs::path obstacle = desk.spool.folder(Spool::Folder::Done) / "part.stl";
  desk.begin();
  fs::create_directories(obstacle / "full");
  REQUIRE(desk.run_to_end());
  CHECK(desk.has("printing/part.stl"));
  CHECK(desk.hold.reason_to_wait().starts_with("part is not filed yet: "));
  fs::remove_all(obstacle);
  desk.hold.keep();
  CHECK(desk.has("done/part.stl"));
}

TEST_CASE("An interruption is in the report") {
  Desk desk;
  desk.begin();
  bool interrupted = false;
  REQUIRE(desk.run_to_end([&] {
    PrintProcess& print = desk.job.print();
    if (print.state() == PrintState::Paused) print.resume();
    if (interrupted || !desk.machine.light_is_on()) return;
    interrupted = true;
    print.interrupt("the lid was opened");
    CHECK_FALSE(desk.machine.light_is_on());
  }));
  std::ifstream file(desk.config.spool_folder / "done" / "part.report.json");
  CHECK(nlohmann::json::parse(file)["interruptions"].dump().find("layer 1: the lid was opened") !=
        std::string::npos);
}
