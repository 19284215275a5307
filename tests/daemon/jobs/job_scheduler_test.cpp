#include "daemon/jobs/job_scheduler.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

// A scheduler whose jobs and checks end when a test ends them.
class SchedulerFixture : public testing::PrinterFixture {
 public:
  SchedulerFixture() {
    queue_observer.on_change = [this] { scheduler.run(); };
    hold.load();
  }

  void arrive(const std::string& file) {
    put(Spool::Folder::Incoming, file);
    queue.arrived(file);
  }
  void end_job() {
    printer.job = false;
    scheduler.run();
  }
  [[nodiscard]] Names begun() const {
    Names names;
    for (const ClaimedJob& job : printer.jobs)
      names.push_back(job.files.name);
    return names;
  }
  [[nodiscard]] Names checked() const {
    Names files;
    for (const auto& check : work.checks)
      files.push_back(check.file);
    return files;
  }
  // Returns an analysis of the job as it is now, with these findings.
  [[nodiscard]] AnalyzedJob analysis(const std::string& file, const Names& findings) const {
    const JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
    return {{.resin_ml = {}, .findings = findings, .warnings = {}},
            content_mark(files),
            read_settings(files, config)};
  }
  void end_check(const CheckedJob& found) { work.checks.back().done(found); }
  // Ends the last check: the job has places that cannot be held.
  void find_unheld(const std::string& file) {
    JobOutlook outlook;
    outlook.question = analysis(file, {"unheld_places"});
    end_check(outlook);
  }
  // Ends the last analysis with these findings.
  void find(const std::string& file, const Names& findings) {
    work.analyses.back().done(analysis(file, findings));
  }

  testing::FakePrinter printer;
  testing::FakeChecks work;
  testing::FakeQueueObserver queue_observer;
  QueueHold hold{context, spool, printer};
  PrintQueue queue{config, work, queue_observer, log.log};
  JobScheduler scheduler{context, spool, queue, hold, printer};
};

// A scheduler with ask_before for islands, whose checks succeed at once.
class AskingSchedulerFixture : public SchedulerFixture {
 public:
  AskingSchedulerFixture() {
    config.ask_before = {"islands"};
    work.check_result = JobOutlook{};
  }
};

}  // namespace

TEST_CASE("A job that arrives at an idle printer begins at once, in printing/ and with its settings") {
  SchedulerFixture fixture;
  fixture.arrive("part.stl");
  CHECK(fixture.begun() == Names{"part"});
  CHECK(fixture.has("printing/part.stl"));
  CHECK(fixture.printer.jobs[0].settings);
  CHECK(fixture.scheduler.waiting_for().empty());
  CHECK(fixture.checked().empty());
}

TEST_CASE("A job with supports is checked before it begins, because it may need confirmation") {
  SchedulerFixture fixture;
  fixture.config.supports = SupportPolicy::Auto;
  fixture.arrive("part.stl");
  CHECK(fixture.begun().empty());
  REQUIRE(fixture.checked() == Names{"part.stl"});
  CHECK(fixture.has("incoming/part.stl"));
  SECTION("all places are held") {
    fixture.end_check(JobOutlook{});
    CHECK(fixture.begun() == Names{"part"});
    CHECK_FALSE(fixture.printer.jobs[0].unheld_accepted);
  }
  SECTION("places that cannot be held are accepted") {
    fixture.find_unheld("part.stl");
    CHECK(fixture.begun().empty());
    fixture.arrive("other.stl");
    fixture.end_check(JobOutlook{});
    CHECK(fixture.begun() == Names{"other"});
    fixture.queue.accept("part.stl", "user me");
    fixture.end_job();
    REQUIRE(fixture.begun() == Names{"other", "part"});
    CHECK(fixture.printer.jobs[1].unheld_accepted);
  }
  SECTION("the job has changed since it was accepted") {
    fixture.find_unheld("part.stl");
    fixture.put_text(Spool::Folder::Incoming, "part.json", "{}");
    fixture.queue.accept("part.stl", "user me");
    CHECK(fixture.begun().empty());
    CHECK(fixture.run_until([&] { return fixture.checked() == Names{"part.stl", "part.stl"}; }));
  }
}

TEST_CASE("Jobs begin one after the other, in the order of the queue") {
  SchedulerFixture fixture;
  for (const char* file : {"b.stl", "a.stl", "c.stl"})
    fixture.arrive(file);
  CHECK(fixture.begun() == Names{"b"});
  CHECK(fixture.checked() == Names{"a.stl", "c.stl"});
}

TEST_CASE("The time to the first light counts from the arrival, or from the end of the wait") {
  SchedulerFixture fixture;
  fixture.arrive("one.stl");
  const TimePoint between = std::chrono::steady_clock::now();
  fixture.arrive("two.stl");
  const TimePoint end_of_wait = std::chrono::steady_clock::now();
  (void)fixture.queue.take_first();  // it is still being checked
  CHECK(fixture.printer.jobs[0].turn_came <= between);
  fixture.queue.put_last({.file = "two.stl", .arrived = between, .waited = true});
  fixture.end_job();
  REQUIRE(fixture.printer.jobs.size() == 2);
  CHECK(fixture.printer.jobs[1].turn_came >= end_of_wait);
}

TEST_CASE("A job that becomes the next one when another begins has waited") {
  SchedulerFixture fixture;
  fixture.printer.job = true;
  fixture.put(Spool::Folder::Incoming, "one.stl");
  fixture.put(Spool::Folder::Incoming, "two.stl");
  fixture.queue.put_last({.file = "one.stl", .arrived = {}});
  fixture.queue.put_last({.file = "two.stl", .arrived = {}});
  fixture.printer.job = false;
  fixture.scheduler.run_soon();
  CHECK(fixture.run_until([&] { return fixture.printer.job; }));
  CHECK(fixture.begun() == Names{"one"});
  CHECK(fixture.queue.jobs().front().waited);
}

TEST_CASE("A job waits for the machine first, then for the hold, then for the disk") {
  SchedulerFixture fixture;
  fixture.config.min_free_disk_bytes = ~std::uintmax_t{0};
  fixture.machine.open_lid();
  fixture.hold.hold("part failed");
  fixture.arrive("part.stl");
  CHECK(fixture.scheduler.waiting_for() == "the lid is open");
  CHECK(fixture.log.has("info: part.stl waits: the lid is open"));
  fixture.machine.close_lid();
  fixture.scheduler.run();
  CHECK(fixture.scheduler.waiting_for().starts_with("the queue is held: part failed"));
  fixture.hold.release();
  fixture.scheduler.run();
  CHECK(fixture.scheduler.waiting_for().starts_with("the spool's disk has "));
  fixture.config.min_free_disk_bytes = 0;
  CHECK(fixture.begun().empty());
  CHECK(fixture.checked() == Names{"part.stl"});
}

TEST_CASE("The reason why a job waits is logged once") {
  SchedulerFixture fixture;
  fixture.machine.open_lid();
  fixture.arrive("part.stl");
  for (int i = 0; i < 3; ++i)
    fixture.scheduler.run();
  CHECK(fixture.log.count("part.stl waits") == 1);
}

TEST_CASE("A job that is gone when its turn comes is logged as removed, and the next one begins") {
  SchedulerFixture fixture;
  fixture.printer.job = true;
  fixture.queue.arrived("gone.stl");
  fixture.queue.arrived("gone-too.stl");
  fixture.put(Spool::Folder::Incoming, "part.stl");
  fixture.queue.put_last({.file = "part.stl", .arrived = {}});
  // No check of this fixture ends by itself.
  WaitingJob gone = fixture.queue.take_first(), gone_too = fixture.queue.take_first();
  gone.check = gone_too.check = WaitingJob::Check::Passed;
  fixture.queue.put_first(std::move(gone_too));
  fixture.queue.put_first(std::move(gone));
  fixture.printer.job = false;
  fixture.scheduler.run_soon();
  CHECK(fixture.run_until([&] { return fixture.printer.job; }));
  CHECK(fixture.begun() == Names{"part"});
  CHECK(fixture.log.has("gone.stl: removed from incoming by a user"));
  CHECK(fixture.log.has("gone-too.stl: removed from incoming by a user"));
}

TEST_CASE("A job that cannot be claimed keeps its turn, and the reason is logged once") {
  SchedulerFixture fixture;
  fs::remove_all(fixture.spool.folder(Spool::Folder::Printing));
  for (int i = 0; i < 2; ++i) {
    fixture.arrive("part.stl");
    CHECK(fixture.scheduler.waiting_for().starts_with("part.stl cannot be claimed: "));
  }
  CHECK(fixture.queue.jobs().size() == 1);
  CHECK(fixture.queue.jobs().front().waited);
  CHECK(fixture.log.count("error: part.stl cannot be claimed") == 1);
  CHECK(fixture.has("incoming/part.stl"));
}

TEST_CASE("A job waits for a broken profile, and the others are checked meanwhile") {
  SchedulerFixture fixture;
  const std::string resin = std::exchange(fixture.config.resin, "none-such");
  fixture.arrive("part.stl");
  CHECK(fixture.begun().empty());
  CHECK(fixture.scheduler.waiting_for().ends_with("; the queue continues when the profile is fixed"));
  CHECK(fixture.has("incoming/part.stl"));
  fixture.arrive("other.stl");
  CHECK(fixture.checked() == Names{"other.stl"});
  fixture.config.resin = resin;
  fixture.scheduler.run();
  CHECK(fixture.begun() == Names{"part"});
  CHECK(fixture.log.count("part.stl waits") == 1);
}

TEST_CASE("A job with an invalid ticket begins, because its reading says why it is refused") {
  SchedulerFixture fixture;
  fixture.put_text(Spool::Folder::Incoming, "part.json", "no ticket");
  fixture.arrive("part.stl");
  REQUIRE(fixture.begun() == Names{"part"});
  CHECK_FALSE(fixture.printer.jobs[0].settings);
}

TEST_CASE("A job whose name is taken gets a number after its name") {
  SchedulerFixture fixture;
  fixture.put(Spool::Folder::Done, "part.stl");
  fixture.arrive("part.stl");
  REQUIRE(fixture.printer.jobs.size() == 1);
  CHECK(fixture.printer.jobs[0].files.name != "part");
  CHECK(fixture.has("done/part.stl"));
}

TEST_CASE("No job begins after a stop") {
  SchedulerFixture fixture;
  fixture.scheduler.stop();
  fixture.arrive("part.stl");
  CHECK(fixture.begun().empty());
  CHECK(fixture.has("incoming/part.stl"));
}

TEST_CASE("A failed save is tried again") {
  SchedulerFixture fixture;
  const fs::path obstacle = fixture.state() / "queue-held";
  fs::create_directories(obstacle / "full");
  fixture.hold.hold("part failed");
  REQUIRE(fixture.run_steps([&] { return fixture.hold.saving(); },
                            {[&] {
                               CHECK(fixture.hold.failed());
                               fs::remove_all(obstacle);
                               fixture.scheduler.run();
                             },
                             [&] { CHECK_FALSE(fixture.hold.failed()); }}));
}

TEST_CASE("No job begins while the printer is controlled by hand, and the reason is reported") {
  SchedulerFixture fixture;
  fixture.printer.by_hand = true;
  fixture.arrive("part.stl");
  CHECK(fixture.begun().empty());
  CHECK(fixture.scheduler.waiting_for() ==
        "the printer is controlled by hand; \"contourctl stop\" ends that");
  fixture.printer.by_hand = false;
  fixture.scheduler.run();
  CHECK(fixture.scheduler.waiting_for().empty());
}

TEST_CASE("With ask_before a job is analyzed first, and begins if nothing is found") {
  AskingSchedulerFixture fixture;
  fixture.arrive("part.stl");
  CHECK(fixture.begun().empty());
  CHECK(fixture.scheduler.waiting_for() == "its layers must be analyzed first, as ask_before requires");
  REQUIRE(fixture.work.analyses.size() == 1);
  fixture.find("part.stl", {});
  CHECK(fixture.begun() == Names{"part"});
  CHECK(fixture.scheduler.waiting_for().empty());
}

TEST_CASE("Jobs after one that waits for confirmation begin in their order, and it is next when accepted") {
  AskingSchedulerFixture fixture;
  for (const char* file : {"a.stl", "b.stl", "c.stl"})
    fixture.arrive(file);
  fixture.find("a.stl", {"islands"});
  CHECK(fixture.begun().empty());
  fixture.find("b.stl", {});
  CHECK(fixture.begun() == Names{"b"});
  CHECK(fixture.run_until([&] { return fixture.work.analyses.size() == 3; }));  // during the print
  fixture.find("c.stl", {});
  fixture.queue.accept("a.stl", "user me");
  fixture.end_job();
  CHECK(fixture.begun() == Names{"b", "a"});
  fixture.end_job();
  CHECK(fixture.begun() == Names{"b", "a", "c"});
}

TEST_CASE(
    "When all jobs wait for confirmation, the queue names the command that accepts, and continues after it") {
  AskingSchedulerFixture fixture;
  fixture.arrive("part.stl");
  fixture.find("part.stl", {"islands"});
  CHECK(fixture.begun().empty());
  CHECK(fixture.scheduler.waiting_for() == "islands; run \"contourctl accept part\" to print it as it is");
  CHECK(fixture.log.count("contourctl accept part") == 1);
  fixture.queue.accept("part.stl", "user me");
  CHECK(fixture.begun() == Names{"part"});
}

TEST_CASE("A job that is being analyzed keeps the jobs after it waiting") {
  AskingSchedulerFixture fixture;
  fixture.arrive("a.stl");
  fixture.arrive("b.stl");
  REQUIRE(fixture.work.analyses.size() == 1);
  fixture.scheduler.run();
  CHECK(fixture.begun().empty());
}

TEST_CASE("A job that has changed since its analysis is analyzed again") {
  AskingSchedulerFixture fixture;
  fixture.printer.job = true;
  fixture.arrive("part.stl");
  fixture.find("part.stl", {});
  SECTION("its model has changed") {
    fs::last_write_time(fixture.config.spool_folder / "incoming/part.stl",
                        fs::file_time_type::clock::now() + std::chrono::hours{1});
  }
  SECTION("it has got a ticket") {
    fixture.put_text(Spool::Folder::Incoming, "part.json", R"({"copies": 2})");
  }
  fixture.printer.job = false;
  fixture.scheduler.run();
  CHECK(fixture.begun().empty());
  CHECK(fixture.run_until([&] { return fixture.work.analyses.size() == 2; }));
  fixture.find("part.stl", {});
  CHECK(fixture.begun() == Names{"part"});
}
