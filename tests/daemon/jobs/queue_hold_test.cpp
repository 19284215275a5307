#include "daemon/jobs/queue_hold.hpp"

#include <filesystem>
#include <memory>
#include <string>

#include "daemon/spool/reading_record.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::PrinterFixture {
 public:
  // As a process that starts now has it.
  void restart() {
    hold = std::make_unique<QueueHold>(
        context, spool,
        QueueHold::Calls{.light_may_be_on = [this] { return lit; }, .retry = [this] { ++retries; }});
    hold->load();
  }
  void adopt_left_jobs(bool ended_in_reading = false) {
    hold->adopt_left_jobs([=](const JobFiles&) { return ended_in_reading; });
  }
  // The disk does not take this record.
  void obstruct(const std::string& record) const { fs::create_directories(state() / record / "full"); }
  void clear_away(const std::string& record) const { fs::remove_all(state() / record); }

  bool lit = false;
  int retries = 0;
  std::unique_ptr<QueueHold> hold;
};

class Hold : public Desk {
 public:
  Hold() { restart(); }
};

constexpr const char* kHeld = "queue-held";
constexpr const char* kOccupied = "plate-occupied";
constexpr const char* kEnded = "ended-print";

std::string record_of(PrintOutcome outcome, const std::string& reason) {
  return R"({"job": "part", "outcome": ")" + std::string(name_of(outcome)) + R"(", "reason": ")" + reason +
         "\"}";
}

}  // namespace

TEST_CASE("A held queue stays held in the next process, until it is released") {
  Hold desk;
  CHECK_FALSE(desk.hold->reason());
  desk.hold->hold("the lid is broken");
  desk.restart();
  CHECK(desk.hold->reason() == "the lid is broken");
  desk.hold->release();
  CHECK(desk.log.has("the queue goes on: the owner has seen to the printer"));
  desk.restart();
  CHECK_FALSE(desk.hold->reason());
}

TEST_CASE("A queue is held for the first reason, which is told once") {
  Hold desk;
  desk.hold->hold("one");
  desk.hold->hold("two");
  CHECK(desk.hold->reason() == "one");
  CHECK(desk.log.count("the queue is held") == 1);
}

TEST_CASE("What is to be recorded waits for the dark") {
  Hold desk;
  desk.lit = true;
  desk.hold->hold("the emergency stop");
  CHECK(desk.hold->due());
  CHECK_FALSE(desk.has_record(kHeld));
  desk.lit = false;
  desk.hold->keep();
  CHECK_FALSE(desk.hold->due());
  CHECK(desk.has_record(kHeld));
}

TEST_CASE("What the plate holds is on the disk at once, light or not") {
  Hold desk;
  desk.lit = true;
  desk.hold->set_plate_occupant("part");
  CHECK(desk.has_record(kOccupied));
  desk.hold->set_plate_occupant(std::nullopt);
  CHECK_FALSE(desk.has_record(kOccupied));
}

TEST_CASE("An owner is told what to say: plate-cleared where the plate has to be cleared too, else resume") {
  Hold desk;
  desk.hold->hold("part failed");
  CHECK(desk.hold->sentence() ==
        "the queue is held: part failed; see to the printer, then say \"contourctl resume\"");
  desk.hold->set_plate_occupant("part");
  CHECK(desk.hold->sentence() ==
        "the queue is held: part failed; see to the printer and clear the plate, then say \"contourctl "
        "plate-cleared\"");
  desk.config.wait_for_plate_cleared = false;
  CHECK(desk.hold->sentence().ends_with("then say \"contourctl resume\""));
}

TEST_CASE("The hold comes before the job that is not filed, and that before the plate") {
  Hold desk;
  desk.hold->set_plate_occupant("old");
  desk.put(Spool::Folder::Printing, "part.stl");
  fs::create_directories(desk.spool.folder(Spool::Folder::Done) / "part.stl" / "full");
  desk.hold->add_unfiled(desk.spool.files_of(Spool::Folder::Printing, "part.stl"), {PrintOutcome::Done, ""});
  desk.hold->hold("the lid is broken");
  CHECK(desk.hold->reason_to_wait().starts_with("the queue is held: the lid is broken"));
  desk.hold->release();
  CHECK(desk.hold->reason_to_wait().starts_with("part is not filed yet: "));
  fs::remove_all(desk.spool.folder(Spool::Folder::Done) / "part.stl");
  desk.hold->keep();
  CHECK(desk.hold->reason_to_wait() ==
        "the plate holds old; say \"contourctl plate-cleared\" when it is clear");
  desk.hold->set_plate_occupant(std::nullopt);
  CHECK(desk.hold->reason_to_wait().empty());
}

TEST_CASE("An occupied plate keeps nothing where the printer does not wait for it") {
  Hold desk;
  desk.config.wait_for_plate_cleared = false;
  desk.hold->set_plate_occupant("part");
  CHECK(desk.hold->reason_to_wait().empty());
}

TEST_CASE("A print that did not end holds the queue, has its part on the plate and is in failed/") {
  Hold desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  desk.adopt_left_jobs();
  CHECK(desk.hold->reason() == "part was interrupted: the power was cut, or contourd was killed or crashed");
  CHECK(desk.hold->plate_occupant() == "part");
  CHECK(desk.has("failed/part.stl"));
  CHECK(desk.has("failed/part.reason.txt"));
  CHECK(desk.has_record(kHeld));
  CHECK(desk.has_record(kOccupied));
}

TEST_CASE("A print that ended and was not filed is filed by its end, which holds the queue if it failed") {
  Hold desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  SECTION("done") {
    desk.spool.records().keep_end_of_print(record_of(PrintOutcome::Done, ""));
    desk.adopt_left_jobs();
    CHECK(desk.has("done/part.stl"));
    CHECK_FALSE(desk.hold->reason());
  }
  SECTION("failed") {
    desk.spool.records().keep_end_of_print(record_of(PrintOutcome::Failed, "the sky fell"));
    desk.adopt_left_jobs();
    CHECK(desk.has("failed/part.stl"));
    CHECK(desk.hold->reason() == "part failed: the sky fell");
  }
  CHECK_FALSE(desk.hold->plate_occupant());
}

TEST_CASE("How a print ended is forgotten once it is filed, also by the process before") {
  Hold desk;
  desk.spool.records().keep_end_of_print(record_of(PrintOutcome::Done, ""));
  REQUIRE(desk.has_record(kEnded));
  desk.adopt_left_jobs();
  CHECK_FALSE(desk.has_record(kEnded));
}

TEST_CASE("A job whose reading ended the process had not begun: it failed, and nothing is held") {
  Hold desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  desk.adopt_left_jobs(true);
  CHECK(desk.has("failed/part.stl"));
  CHECK(desk.log.has(std::string("error: part: ") + std::string(kEndedAProcess)));
  CHECK_FALSE(desk.hold->reason());
  CHECK_FALSE(desk.hold->plate_occupant());
}

TEST_CASE("A job whose part is on the plate had begun, whatever was being read") {
  Hold desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  desk.hold->set_plate_occupant("part");
  desk.adopt_left_jobs(true);
  CHECK(desk.hold->reason());
}

TEST_CASE("A print that did not end stays in printing/ until the disk has what it tells") {
  Hold desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  desk.obstruct(kHeld);
  desk.adopt_left_jobs();
  CHECK(desk.has("printing/part.stl"));
  CHECK(desk.hold->failed());
  CHECK(desk.log.count("the state for the next start is not on the disk") == 1);
  CHECK(desk.log.has("error: part: stays in printing until then"));
  desk.hold->keep();
  CHECK(desk.log.count("the state for the next start is not on the disk") == 1);
  desk.clear_away(kHeld);
  desk.hold->keep();
  CHECK_FALSE(desk.hold->failed());
  CHECK(desk.has_record(kHeld));
  CHECK(desk.has("failed/part.stl"));
}
