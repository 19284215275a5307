#include "daemon/jobs/current_job.hpp"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

namespace fs = std::filesystem;

namespace {

bool had_event(const CurrentJobFixture& fixture, const std::string& what) {
  return std::ranges::find(fixture.events, what) != fixture.events.end();
}

bool has_printed(const CurrentJobFixture& fixture) {
  return had_event(fixture, "state: warming up");
}

}  // namespace

TEST_CASE("A job is read, printed and filed, and each layer is reported") {
  CurrentJobFixture fixture;
  fixture.begin();
  CHECK(fixture.job.job() != nullptr);
  CHECK(fixture.job.name() == "part");
  REQUIRE(fixture.run_to_end());
  CHECK(fixture.ended[0].outcome == "done");
  CHECK(fixture.job.job() == nullptr);
  CHECK(fixture.has("done/part.stl"));
  CHECK(fixture.has("done/part.report.json"));
  CHECK(std::ranges::count(fixture.events, "changed: layer") == 4);  // 0.2 mm
}

TEST_CASE("The occupied plate is recorded on the disk before the light is first on") {
  CurrentJobFixture fixture;
  fixture.begin();
  bool lit = false;
  REQUIRE(fixture.run_to_end([&] {
    if (!fixture.machine.light_is_on()) return;
    lit = true;
    CHECK(fixture.has_record("plate-occupied"));
  }));
  CHECK(lit);
}

TEST_CASE("If no layer was exposed, the plate is what it was before the job") {
  CurrentJobFixture fixture;
  const std::optional<std::string> before = GENERATE(std::optional<std::string>(), "old");
  fixture.hold.set_plate_occupant(before);
  fixture.begin();
  REQUIRE(fixture.run_until([&] {
    if (fixture.job.print().state().name == "homing") fixture.job.cancel();
    return !fixture.ended.empty() && !fixture.hold.saving();
  }));
  CHECK(fixture.ended[0].outcome == "cancelled");
  CHECK(fixture.hold.plate_occupant() == before);
  CHECK(fixture.has_record("plate-occupied") == before.has_value());
}

TEST_CASE("A job does not begin if the disk refuses the record that its part is on the plate") {
  CurrentJobFixture fixture;
  fs::create_directories(fixture.state() / "plate-occupied" / "full");
  fixture.begin();
  REQUIRE(fixture.run_to_end([&] { CHECK_FALSE(fixture.machine.light_is_on()); }));
  CHECK(fixture.ended[0].outcome == "failed");
  CHECK(fixture.ended[0].reason.starts_with("cannot record that the plate is not clear from now on: "));
  CHECK(fixture.has("failed/part.stl"));
  CHECK_FALSE(fixture.hold.plate_occupant());
}

TEST_CASE("A job that is cancelled while its record is saved does not begin") {
  CurrentJobFixture fixture;
  fixture.begin();
  bool canceled = false;
  REQUIRE(fixture.run_to_end([&] {
    if (canceled || !fixture.hold.saving() || !fixture.job.job()) return;
    canceled = true;
    fixture.job.cancel();
  }));
  CHECK(canceled);
  CHECK(fixture.ended[0].outcome == "cancelled");
  CHECK(fixture.ended[0].reason == "cancelled before it started");
  CHECK_FALSE(fixture.hold.plate_occupant());
}

TEST_CASE("An invalid model is refused with a reason file, and nothing is printed") {
  CurrentJobFixture fixture;
  fixture.put_text(Spool::Folder::Incoming, "bad.stl", "no model");
  fixture.begin("bad.stl");
  REQUIRE(fixture.run_to_end());
  CHECK(fixture.ended[0].outcome == "failed");
  CHECK_FALSE(fixture.ended[0].reason.empty());
  CHECK(fixture.has("failed/bad.stl"));
  CHECK(fixture.has("failed/bad.reason.txt"));
  CHECK_FALSE(has_printed(fixture));
  CHECK_FALSE(fixture.hold.reason());
}

TEST_CASE("A job that is cancelled while it is read is not printed") {
  CurrentJobFixture fixture;
  fixture.begin();
  fixture.job.cancel();
  REQUIRE(fixture.run_to_end());
  CHECK(fixture.ended[0].outcome == "cancelled");
  CHECK(fixture.ended[0].reason == "cancelled before it started");
  CHECK_FALSE(has_printed(fixture));
}

TEST_CASE("A job that has not begun goes back to incoming/") {
  CurrentJobFixture fixture;
  fixture.begin();
  fixture.job.stop("contourd was stopped");
  fixture.job.give_back();
  CHECK(fixture.job.is_being_filed());
  REQUIRE(fixture.run_until([&] { return fixture.job.job() == nullptr; }));
  CHECK(fixture.has("incoming/part.stl"));
  CHECK(fixture.log.has("part: not started yet; waits in incoming for the next start of contourd"));
}

TEST_CASE("A print that begins while the queue is held or the machine is not ready waits for the user") {
  CurrentJobFixture fixture;
  std::string why;
  SECTION("held") {
    fixture.hold.hold(why = "the emergency stop was pressed");
  }
  SECTION("not ready") {
    fixture.machine.open_lid();
    why = fixture.machine.why_not_ready();
  }
  SECTION("both: the reason of the machine is reported") {
    fixture.hold.hold("the emergency stop was pressed");
    fixture.machine.open_lid();
    why = fixture.machine.why_not_ready();
  }
  fixture.begin();
  REQUIRE(fixture.run_until([&] { return fixture.job.print().state().name == "held"; }));
  CHECK(fixture.job.print().interruption() == why);
}

TEST_CASE("A failed print holds the queue before its end is reported") {
  CurrentJobFixture fixture;
  fixture.begin();
  bool held_first = false;
  REQUIRE(fixture.run_to_end([&] {
    if (fixture.job.print().state().name == "homing") fixture.job.print().fail("steps were lost");
    held_first = held_first || (fixture.hold.reason() && fixture.ended.empty());
  }));
  CHECK(held_first);
  CHECK(fixture.hold.reason() == "part failed: steps were lost");
  CHECK(fixture.ended[0].outcome == "failed");
  CHECK(fixture.ended[0].reason == "steps were lost");
}

TEST_CASE("The hold of a print that fails is on the disk before its files leave printing/") {
  CurrentJobFixture fixture;
  fixture.begin();
  bool failed = false, held_first = true;
  REQUIRE(fixture.run_to_end([&] {
    if (!failed && fixture.machine.light_is_on()) {
      failed = true;
      fixture.hold.hold("the emergency stop was pressed");
      fixture.job.print().fail("the emergency stop was pressed");
    }
    held_first = held_first && (fixture.has("printing/part.stl") || fixture.has_record("queue-held"));
  }));
  CHECK(failed);
  CHECK(held_first);
  CHECK(fixture.has("failed/part.stl"));
}

TEST_CASE("A print that cannot be filed keeps the queue waiting, and is filed with the hold's records") {
  CurrentJobFixture fixture;
  const fs::path obstacle = fixture.spool.folder(Spool::Folder::Done) / "part.stl";
  fixture.begin();
  fs::create_directories(obstacle / "full");
  bool waited = false;
  REQUIRE(fixture.run_until([&] {
    if (fixture.ended.empty() || fixture.hold.saving()) return false;
    if (!std::exchange(waited, true)) {
      CHECK(fixture.has("printing/part.stl"));
      CHECK(fixture.hold.reason_to_wait().starts_with("part is not filed yet: "));
      fs::remove_all(obstacle);
    }
    fixture.hold.retry();
    return !fixture.hold.saving();
  }));
  CHECK(waited);
  CHECK(fixture.has("done/part.stl"));
}

TEST_CASE("An interruption is in the report") {
  CurrentJobFixture fixture;
  fixture.begin();
  bool interrupted = false;
  REQUIRE(fixture.run_to_end([&] {
    PrintMode& print = fixture.job.print();
    if (print.state().name == "paused") print.resume();
    if (interrupted || !fixture.machine.light_is_on()) return;
    interrupted = true;
    print.interrupt("the lid was opened");
    CHECK_FALSE(fixture.machine.light_is_on());
  }));
  std::ifstream file(fixture.config.spool_folder / "done" / "part.report.json");
  CHECK(nlohmann::json::parse(file)["interruptions"].dump().find("layer 1: the lid was opened") !=
        std::string::npos);
}
