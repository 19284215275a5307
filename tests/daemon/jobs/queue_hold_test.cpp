#include "daemon/jobs/queue_hold.hpp"

#include <filesystem>

#include "daemon/spool/reading_record.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class QueueHoldFixture : public testing::PrinterFixture {
 public:
  QueueHoldFixture() { restart(); }

  // Replaces the hold by one of a process that starts now.
  void restart() {
    hold = std::make_unique<QueueHold>(context, spool, printer);
    hold->load();
  }
  void adopt_left_jobs(bool ended_in_reading = false) {
    hold->adopt_left_jobs([=](const JobFiles&) { return ended_in_reading; });
  }
  // Makes every attempt to save this record fail.
  void obstruct(const std::string& record) const { fs::create_directories(state() / record / "full"); }
  void remove_obstacle(const std::string& record) const { fs::remove_all(state() / record); }

  // Runs each step after the records of the last one are on the disk.
  bool run(const std::vector<std::function<void()>>& steps) {
    return run_steps([this] { return hold->saving(); }, steps);
  }

  testing::FakePrinter printer;
  std::unique_ptr<QueueHold> hold;
};

constexpr const char* kHeld = "queue-held";
constexpr const char* kOccupied = "plate-occupied";
}  // namespace

TEST_CASE("A held queue stays held in the next process, until it is released") {
  QueueHoldFixture fixture;
  CHECK_FALSE(fixture.hold->reason());
  fixture.hold->hold("the lid is broken");
  REQUIRE(fixture.run({[&] {
                         fixture.restart();
                         CHECK(fixture.hold->reason() == "the lid is broken");
                         fixture.hold->release();
                         CHECK(fixture.log.has("the queue continues: a user has released it"));
                       },
                       [&] {
                         fixture.restart();
                         CHECK_FALSE(fixture.hold->reason());
                       }}));
}

TEST_CASE("The queue is held for the first reason, which is logged once") {
  QueueHoldFixture fixture;
  fixture.hold->hold("one");
  fixture.hold->hold("two");
  CHECK(fixture.hold->reason() == "one");
  CHECK(fixture.log.count("the queue is held") == 1);
}

TEST_CASE("Records are saved by another thread, in the order of their changes") {
  QueueHoldFixture fixture;
  std::vector<std::string> saved;
  fixture.hold->set_plate_occupant("part",
                                   [&](const std::string& trouble) { saved.push_back("part" + trouble); });
  fixture.hold->set_plate_occupant(std::nullopt,
                                   [&](const std::string& trouble) { saved.push_back("clear" + trouble); });
  CHECK(fixture.hold->saving());
  CHECK(saved.empty());
  REQUIRE(fixture.run({}));
  CHECK(saved == std::vector<std::string>{"part", "clear"});
  CHECK_FALSE(fixture.has_record(kOccupied));
}

TEST_CASE("The sentence names the command: plate-cleared if the plate must be cleared too, else resume") {
  QueueHoldFixture fixture;
  fixture.hold->hold("part failed");
  CHECK(fixture.hold->sentence() ==
        "the queue is held: part failed; check the printer, then run \"contourctl resume\"");
  fixture.hold->set_plate_occupant("part");
  CHECK(fixture.hold->sentence() ==
        "the queue is held: part failed; check the printer and clear the plate, then run \"contourctl "
        "plate-cleared\"");
  fixture.config.wait_for_plate_cleared = false;
  CHECK(fixture.hold->sentence().ends_with("then run \"contourctl resume\""));
}

TEST_CASE("The queue waits for the hold first, then for an unfiled job, then for the plate") {
  QueueHoldFixture fixture;
  fixture.hold->set_plate_occupant("old");
  fixture.put(Spool::Folder::Printing, "part.stl");
  fs::create_directories(fixture.spool.folder(Spool::Folder::Done) / "part.stl" / "full");
  fixture.hold->add_unfiled(fixture.spool.files_of(Spool::Folder::Printing, "part.stl"),
                            {.key = 1, .job = "part", .outcome = "done"});
  fixture.hold->hold("the lid is broken");
  CHECK(fixture.hold->reason_to_wait().starts_with("the queue is held: the lid is broken"));
  fixture.hold->release();
  CHECK(fixture.hold->reason_to_wait() == "part is not filed yet");
  REQUIRE(fixture.run({[&] {
                         CHECK(fixture.hold->reason_to_wait().starts_with("part is not filed yet: "));
                         fs::remove_all(fixture.spool.folder(Spool::Folder::Done) / "part.stl");
                         fixture.hold->retry();
                       },
                       [&] {
                         CHECK(fixture.hold->reason_to_wait() ==
                               "the plate holds old; run \"contourctl plate-cleared\" when it is clear");
                         fixture.hold->set_plate_occupant(std::nullopt);
                         CHECK(fixture.hold->reason_to_wait().empty());
                       }}));
}

TEST_CASE("An occupied plate keeps no job waiting if wait_for_plate_cleared is off") {
  QueueHoldFixture fixture;
  fixture.config.wait_for_plate_cleared = false;
  fixture.hold->set_plate_occupant("part");
  CHECK(fixture.hold->reason_to_wait().empty());
}

TEST_CASE("A print that did not end holds the queue, occupies the plate and goes to failed/") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.adopt_left_jobs();
  REQUIRE(fixture.run({}));
  CHECK(fixture.hold->reason() ==
        "part was interrupted: the power was cut, or contourd was killed or crashed");
  CHECK(fixture.hold->plate_occupant() == "part");
  CHECK(fixture.has("failed/part.stl"));
  CHECK(fixture.has("failed/part.reason.txt"));
  CHECK(fixture.has_record(kHeld));
  CHECK(fixture.has_record(kOccupied));
}

TEST_CASE("A print that is cut while it is read to go on is no model that ended its process") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.hold->set_plate_occupant("part");
  int asked = 0;
  fixture.hold->adopt_left_jobs([&](const JobFiles& files) {
    CHECK(files.name == "part");
    return ++asked > 0;
  });
  REQUIRE(fixture.run({}));
  CHECK(asked == 1);  // the job is no longer in the record, so that the user can resume its print
  CHECK(fixture.hold->reason() ==
        "part was interrupted: the power was cut, or contourd was killed or crashed");
}

TEST_CASE(
    "An interrupted print holds the queue whatever held it before, and only a clear plate releases it") {
  QueueHoldFixture fixture;
  fixture.config.wait_for_plate_cleared = false;
  fixture.hold->hold("the lid is broken");
  CHECK_FALSE(fixture.hold->part_may_hang());
  REQUIRE(fixture.run(
      {[&] {
         fixture.put(Spool::Folder::Printing, "part.stl");
         fixture.restart();
         fixture.adopt_left_jobs();
         CHECK(fixture.hold->reason()->starts_with("part was interrupted: "));
         CHECK(fixture.hold->part_may_hang());
         CHECK(
             testing::lacking(fixture.hold->sentence(), {"may hang on the plate", "plate-cleared"}).empty());
       },
       [&] {
         fixture.restart();
         CHECK(fixture.hold->part_may_hang());
         // This setting keeps the next job from the part in any case.
         fixture.config.wait_for_plate_cleared = true;
         CHECK_FALSE(fixture.hold->part_may_hang());
       }}));
}

TEST_CASE("A print that ended but was not filed is filed by its end, and holds the queue if it failed") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  SECTION("done") {
    fixture.spool.ends().add({.key = 1, .job = "part", .outcome = "done"});
    fixture.adopt_left_jobs();
    REQUIRE(fixture.run({}));
    CHECK(fixture.has("done/part.stl"));
    CHECK_FALSE(fixture.hold->reason());
  }
  SECTION("failed") {
    fixture.spool.ends().add({.key = 1, .job = "part", .outcome = "failed", .reason = "the sky fell"});
    fixture.adopt_left_jobs();
    REQUIRE(fixture.run({}));
    CHECK(fixture.has("failed/part.stl"));
    CHECK(fixture.hold->reason() == "part failed: the sky fell");
  }
  SECTION("refused before it began") {
    fixture.spool.ends().add(
        {.key = 1, .job = "part", .outcome = "failed", .reason = "no model", .kind = JobEnd::Kind::Refused});
    fixture.adopt_left_jobs();
    REQUIRE(fixture.run({}));
    CHECK(fixture.has("failed/part.stl"));
    CHECK(fixture.log.has("error: part: no model"));
    CHECK_FALSE(fixture.hold->reason());
  }
  SECTION("cancelled before it began") {
    fixture.spool.ends().add({.key = 1,
                              .job = "part",
                              .outcome = "cancelled",
                              .reason = "cancelled before it started",
                              .kind = JobEnd::Kind::Refused});
    fixture.adopt_left_jobs();
    REQUIRE(fixture.run({}));
    CHECK(fixture.has("failed/part.stl"));
    CHECK(fixture.log.has("info: part: cancelled before it started"));
    CHECK_FALSE(fixture.hold->reason());
  }
  CHECK_FALSE(fixture.hold->plate_occupant());
}

TEST_CASE("The end of a print that the last process has filed does not wait for files") {
  QueueHoldFixture fixture;
  fixture.spool.ends().add({.key = 1, .job = "part", .outcome = "done"});
  fixture.adopt_left_jobs();
  CHECK_FALSE(fixture.spool.ends().end_of("part"));
  CHECK(fixture.spool.ends().pending()[0].awaits(EndConsumer::History));
}

TEST_CASE("The end of an interrupted print is recorded once, and remains for the history when it is filed") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.obstruct(kHeld);
  fixture.adopt_left_jobs();
  const std::optional<JobEnd> first = fixture.spool.ends().end_of("part");
  REQUIRE(first);
  CHECK(first->kind == JobEnd::Kind::Interrupted);
  REQUIRE(fixture.run({[&] {
    fixture.remove_obstacle(kHeld);
    fixture.restart();
    fixture.adopt_left_jobs();
  }}));
  const std::vector<JobEndRecord::Pending> pending = fixture.spool.ends().pending();
  REQUIRE(pending.size() == 1);
  CHECK(pending[0].end.key == first->key);
  CHECK_FALSE(pending[0].awaits(EndConsumer::Files));
  CHECK(pending[0].awaits(EndConsumer::History));
}

TEST_CASE("A job whose reading ended the process had not begun: it failed, and nothing is held") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.adopt_left_jobs(true);
  REQUIRE(fixture.run({}));
  CHECK(fixture.has("failed/part.stl"));
  CHECK(fixture.log.has(std::string("error: part: ") + std::string(kEndedAProcess)));
  CHECK_FALSE(fixture.hold->reason());
  CHECK_FALSE(fixture.hold->plate_occupant());
}

TEST_CASE("A job whose part is on the plate had begun, even if reading it ended the process") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.hold->set_plate_occupant("part");
  fixture.adopt_left_jobs(true);
  CHECK(fixture.hold->reason());
}

TEST_CASE("A print that did not end stays in printing/ until its records are saved") {
  QueueHoldFixture fixture;
  fixture.put(Spool::Folder::Printing, "part.stl");
  fixture.obstruct(kHeld);
  fixture.adopt_left_jobs();
  REQUIRE(fixture.run({[&] {
                         CHECK(fixture.has("printing/part.stl"));
                         CHECK(fixture.hold->failed());
                         CHECK(fixture.log.count("cannot save the state for the next start") == 1);
                         CHECK(fixture.log.has("error: part: stays in printing until the state is saved"));
                         fixture.hold->retry();
                       },
                       [&] {
                         CHECK(fixture.log.count("cannot save the state for the next start") == 1);
                         fixture.remove_obstacle(kHeld);
                         fixture.hold->retry();
                       }}));
  CHECK_FALSE(fixture.hold->failed());
  CHECK(fixture.has_record(kHeld));
  CHECK(fixture.has("failed/part.stl"));
}
