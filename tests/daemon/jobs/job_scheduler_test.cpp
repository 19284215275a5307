#include "daemon/jobs/job_scheduler.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

// A scheduler whose jobs end when a test ends them. Its checks succeed at once.
class SchedulerFixture : public testing::PrinterFixture {
 public:
  SchedulerFixture() {
    queue_observer.on_change = [this] { scheduler.run(); };
    hold.load();
    work.check_result = JobOutlook{};
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
  testing::BlockingClaims claims{spool, config};
  JobScheduler scheduler{context, spool, claims, queue, hold, printer};
};

// A scheduler with ask_before for islands.
class AskingSchedulerFixture : public SchedulerFixture {
 public:
  AskingSchedulerFixture() { config.ask_before = {"islands"}; }
};

}  // namespace

TEST_CASE_METHOD(SchedulerFixture,
                 "A job that arrives at an idle printer begins at once, in printing/ and with its settings") {
  arrive("part.stl");
  CHECK(begun() == Names{"part"});
  CHECK(has("printing/part.stl"));
  CHECK(printer.jobs[0].settings);
  CHECK(scheduler.waiting_for().empty());
}

TEST_CASE_METHOD(SchedulerFixture, "A job is checked before it begins, because it may need confirmation") {
  config.supports = GENERATE(SupportPolicy::Auto, SupportPolicy::Off);
  work.check_result.reset();
  arrive("part.stl");
  CHECK(begun().empty());
  REQUIRE(checked() == Names{"part.stl"});
  CHECK(has("incoming/part.stl"));
  SECTION("all places are held") {
    end_check(JobOutlook{});
    CHECK(begun() == Names{"part"});
    CHECK(printer.jobs[0].accepted.empty());
  }
  SECTION("places that cannot be held are accepted") {
    find_unheld("part.stl");
    CHECK(begun().empty());
    arrive("other.stl");
    end_check(JobOutlook{});
    CHECK(begun() == Names{"other"});
    queue.accept("part.stl", "user me");
    end_job();
    REQUIRE(begun() == Names{"other", "part"});
    CHECK(printer.jobs[1].accepted == Names{"unheld_places"});
  }
  SECTION("the job has changed since it was accepted") {
    find_unheld("part.stl");
    put_text(Spool::Folder::Incoming, "part.json", "{}");
    queue.accept("part.stl", "user me");
    CHECK(begun().empty());
    CHECK(run_until([&] { return checked() == Names{"part.stl", "part.stl"}; }));
  }
}

TEST_CASE_METHOD(
    SchedulerFixture,
    "A job whose profile could not be used when it was checked is checked again before it begins") {
  const std::string resin = std::exchange(config.resin, "none-such");
  arrive("part.stl");
  CHECK(checked().empty());
  config.resin = resin;
  work.check_result.reset();
  scheduler.run();
  CHECK(begun().empty());
  REQUIRE(checked() == Names{"part.stl"});
  end_check(JobOutlook{});
  CHECK(begun() == Names{"part"});
}

TEST_CASE_METHOD(SchedulerFixture, "A look at the next job is void if something has changed meanwhile") {
  SECTION("the queue is held") {
    claims.after_look = [&] { hold.hold("part failed"); };
    arrive("part.stl");
    CHECK(begun().empty());
    CHECK(scheduler.waiting_for().starts_with("the queue is held"));
  }
  SECTION("the job is gone") {
    claims.after_look = [&] { queue.withdrawn("part.stl"); };
    arrive("part.stl");
    CHECK(begun().empty());
    CHECK(queue.empty());
  }
  SECTION("a stop was requested") {
    claims.after_look = [&] { scheduler.stop(); };
    arrive("part.stl");
    CHECK(begun().empty());
  }
}

TEST_CASE_METHOD(SchedulerFixture, "The reason of the disk stays while the next job is looked at again") {
  config.min_free_disk_bytes = ~std::uintmax_t{0};
  arrive("part.stl");
  claims.after_look = [&] { CHECK(scheduler.waiting_for().starts_with("the spool's disk has ")); };
  scheduler.run();
  claims.after_look = nullptr;
  config.min_free_disk_bytes = 0;
  scheduler.run();
  CHECK(begun() == Names{"part"});
}

TEST_CASE_METHOD(SchedulerFixture, "Jobs begin one after the other, in the order of the queue") {
  for (const char* file : {"b.stl", "a.stl", "c.stl"})
    arrive(file);
  CHECK(begun() == Names{"b"});
  CHECK(checked() == Names{"b.stl", "a.stl", "c.stl"});
}

TEST_CASE_METHOD(SchedulerFixture,
                 "The time to the first light counts from the arrival, or from the end of the wait") {
  arrive("one.stl");
  const TimePoint between = std::chrono::steady_clock::now();
  arrive("two.stl");
  const TimePoint end_of_wait = std::chrono::steady_clock::now();
  (void)queue.take_first();
  CHECK(printer.jobs[0].turn_came <= between);
  queue.put_last({.file = "two.stl", .arrived = between, .waited = true});
  end_job();
  REQUIRE(printer.jobs.size() == 2);
  CHECK(printer.jobs[1].turn_came >= end_of_wait);
}

TEST_CASE_METHOD(SchedulerFixture, "A job that becomes the next one when another begins has waited") {
  printer.job = true;
  put(Spool::Folder::Incoming, "one.stl");
  put(Spool::Folder::Incoming, "two.stl");
  queue.put_last({.file = "one.stl", .arrived = {}});
  queue.put_last({.file = "two.stl", .arrived = {}});
  printer.job = false;
  scheduler.run_soon();
  CHECK(run_until([&] { return printer.job; }));
  CHECK(begun() == Names{"one"});
  CHECK(queue.jobs().front().waited);
}

TEST_CASE_METHOD(SchedulerFixture,
                 "A job waits for the machine first, then for the hold, then for the disk") {
  config.min_free_disk_bytes = ~std::uintmax_t{0};
  machine.open_lid();
  hold.hold("part failed");
  arrive("part.stl");
  CHECK(scheduler.waiting_for() == "the lid is open");
  CHECK(log.has("info: part.stl waits: the lid is open"));
  machine.close_lid();
  scheduler.run();
  CHECK(scheduler.waiting_for().starts_with("the queue is held: part failed"));
  hold.release();
  scheduler.run();
  CHECK(scheduler.waiting_for().starts_with("the spool's disk has "));
  config.min_free_disk_bytes = 0;
  CHECK(begun().empty());
  CHECK(checked() == Names{"part.stl"});
}

TEST_CASE_METHOD(SchedulerFixture, "The reason why a job waits is logged once") {
  machine.open_lid();
  arrive("part.stl");
  for (int i = 0; i < 3; ++i)
    scheduler.run();
  CHECK(log.count("part.stl waits") == 1);
}

TEST_CASE_METHOD(SchedulerFixture,
                 "A job that is gone when its turn comes is logged as removed, and the next one begins") {
  printer.job = true;
  queue.arrived("gone.stl");
  queue.arrived("gone-too.stl");
  put(Spool::Folder::Incoming, "part.stl");
  queue.put_last({.file = "part.stl", .arrived = {}});
  printer.job = false;
  scheduler.run_soon();
  CHECK(run_until([&] { return printer.job; }));
  CHECK(begun() == Names{"part"});
  CHECK(log.has("gone.stl: removed from incoming by a user"));
  CHECK(log.has("gone-too.stl: removed from incoming by a user"));
}

TEST_CASE_METHOD(SchedulerFixture,
                 "A job that cannot be claimed keeps its turn, and the reason is logged once") {
  fs::remove_all(spool.folder(Spool::Folder::Printing));
  for (int i = 0; i < 2; ++i) {
    arrive("part.stl");
    CHECK(scheduler.waiting_for().starts_with("part.stl cannot be claimed: "));
  }
  CHECK(queue.jobs().size() == 1);
  CHECK(queue.jobs().front().waited);
  CHECK(log.count("error: part.stl cannot be claimed") == 1);
  CHECK(has("incoming/part.stl"));
}

TEST_CASE_METHOD(SchedulerFixture, "A job waits for a broken profile, and the others are checked meanwhile") {
  const std::string resin = std::exchange(config.resin, "none-such");
  arrive("part.stl");
  CHECK(begun().empty());
  CHECK(scheduler.waiting_for().ends_with("; the queue continues when the profile is fixed"));
  CHECK(has("incoming/part.stl"));
  arrive("other.stl");
  CHECK(checked() == Names{"other.stl"});
  // The reason stays while the job is looked at again.
  claims.after_look = [&] { CHECK(scheduler.waiting_for().ends_with("when the profile is fixed")); };
  scheduler.run();
  claims.after_look = nullptr;
  config.resin = resin;
  scheduler.run();
  CHECK(begun() == Names{"part"});
  CHECK(log.count("part.stl waits") == 1);
}

TEST_CASE_METHOD(
    SchedulerFixture,
    "An unchecked job with an invalid ticket begins, because its reading says why it is refused") {
  put_text(Spool::Folder::Incoming, "part.json", "no ticket");
  work.check_result = JobRefusal{.reason = "too little memory", .for_now = true};
  arrive("part.stl");
  REQUIRE(begun() == Names{"part"});
  CHECK_FALSE(printer.jobs[0].settings);
}

TEST_CASE_METHOD(SchedulerFixture, "A job whose name is taken gets a number after its name") {
  put(Spool::Folder::Done, "part.stl");
  arrive("part.stl");
  REQUIRE(printer.jobs.size() == 1);
  CHECK(printer.jobs[0].files.name != "part");
  CHECK(has("done/part.stl"));
}

TEST_CASE_METHOD(SchedulerFixture,
                 "The spool claims a job on another thread, and reports an error of the disk") {
  put(Spool::Folder::Incoming, "part.stl");
  std::vector<Claim> results;
  const auto note = [&](const Claim& claim) { results.push_back(claim); };
  SpoolClaims on_disk{spool, config};
  on_disk.claim("part.stl", note);
  on_disk.claim("gone.stl", note);
  CHECK(results.empty());
  REQUIRE(run_until([&] { return results.size() == 2; }));
  REQUIRE(results[0].files);
  CHECK(results[0].files->name == "part");
  CHECK(has("printing/part.stl"));
  CHECK_FALSE(results[1].files);
  CHECK(results[1].code == std::errc::no_such_file_or_directory);
  CHECK(results[1].trouble.find("gone.stl") != std::string::npos);
  CHECK_FALSE(results[1].is_there);
}

TEST_CASE_METHOD(SchedulerFixture, "No job begins after a stop") {
  scheduler.stop();
  arrive("part.stl");
  CHECK(begun().empty());
  CHECK(has("incoming/part.stl"));
}

TEST_CASE_METHOD(SchedulerFixture, "A failed save is tried again") {
  const fs::path obstacle = state() / "queue-held";
  fs::create_directories(obstacle / "full");
  hold.hold("part failed");
  REQUIRE(run_steps([&] { return hold.saving(); }, {[&] {
                                                      CHECK(hold.failed());
                                                      fs::remove_all(obstacle);
                                                      scheduler.run();
                                                    },
                                                    [&] { CHECK_FALSE(hold.failed()); }}));
}

TEST_CASE_METHOD(SchedulerFixture,
                 "No job begins while the printer is controlled by hand, and the reason is reported") {
  printer.by_hand = true;
  arrive("part.stl");
  CHECK(begun().empty());
  CHECK(scheduler.waiting_for() == "the printer is controlled by hand; \"contourctl stop\" ends that");
  printer.by_hand = false;
  scheduler.run();
  CHECK(scheduler.waiting_for().empty());
}

TEST_CASE_METHOD(AskingSchedulerFixture,
                 "With ask_before a job is analyzed first, and begins if nothing is found") {
  arrive("part.stl");
  CHECK(begun().empty());
  CHECK(scheduler.waiting_for() == "its layers must be analyzed first, as ask_before requires");
  REQUIRE(work.analyses.size() == 1);
  find("part.stl", {});
  CHECK(begun() == Names{"part"});
  CHECK(scheduler.waiting_for().empty());
}

TEST_CASE_METHOD(
    AskingSchedulerFixture,
    "Jobs after one that waits for confirmation begin in their order, and it is next when accepted") {
  for (const char* file : {"a.stl", "b.stl", "c.stl"})
    arrive(file);
  find("a.stl", {"islands"});
  CHECK(begun().empty());
  find("b.stl", {});
  CHECK(begun() == Names{"b"});
  CHECK(run_until([&] { return work.analyses.size() == 3; }));  // during the print
  find("c.stl", {});
  queue.accept("a.stl", "user me");
  end_job();
  CHECK(begun() == Names{"b", "a"});
  end_job();
  CHECK(begun() == Names{"b", "a", "c"});
}

TEST_CASE_METHOD(
    AskingSchedulerFixture,
    "When all jobs wait for confirmation, the queue names the command that accepts, and continues after it") {
  arrive("part.stl");
  find("part.stl", {"islands"});
  CHECK(begun().empty());
  CHECK(scheduler.waiting_for() == "islands; run \"contourctl accept part\" to print it anyway");
  CHECK(log.count("contourctl accept part") == 1);
  queue.accept("part.stl", "user me");
  CHECK(begun() == Names{"part"});
}

TEST_CASE_METHOD(AskingSchedulerFixture, "A job that is being analyzed keeps the jobs after it waiting") {
  arrive("a.stl");
  arrive("b.stl");
  REQUIRE(work.analyses.size() == 1);
  scheduler.run();
  CHECK(begun().empty());
}

TEST_CASE_METHOD(AskingSchedulerFixture, "A job that has changed since its analysis is analyzed again") {
  printer.job = true;
  arrive("part.stl");
  find("part.stl", {});
  SECTION("its model has changed") {
    fs::last_write_time(config.spool_folder / "incoming/part.stl",
                        fs::file_time_type::clock::now() + std::chrono::hours{1});
  }
  SECTION("it has got a ticket") {
    put_text(Spool::Folder::Incoming, "part.json", R"({"copies": 2})");
  }
  printer.job = false;
  scheduler.run();
  CHECK(begun().empty());
  CHECK(run_until([&] { return work.analyses.size() == 2; }));
  find("part.stl", {});
  CHECK(begun() == Names{"part"});
}
