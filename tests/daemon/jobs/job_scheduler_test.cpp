#include "daemon/jobs/job_scheduler.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using Names = std::vector<std::string>;
namespace fs = std::filesystem;

namespace {

// A scheduler whose jobs begin, end and are checked when a test says so.
class Desk : public testing::PrinterFixture {
 public:
  // `asks`: of a printer whose owner is asked about islands.
  explicit Desk(bool asks = false) : asking(asks) { hold.load(); }

  void arrive(const std::string& file) {
    put(Spool::Folder::Incoming, file);
    queue.arrived(file);
  }
  void end_job() {
    has_job = false;
    scheduler.run();
  }
  [[nodiscard]] Names begun() const {
    Names names;
    for (const ClaimedJob& job : jobs)
      names.push_back(job.files.name);
    return names;
  }

  bool has_job = false, lit = false, by_hand = false;
  std::vector<ClaimedJob> jobs;
  Names checked;
  QueueHold hold{
      context, spool, {.light_may_be_on = [this] { return lit; }, .retry = [this] { scheduler.run(); }}};
  bool asking;
  std::function<void(const CheckedJob&)> check_done;  // ends the last check
  // What a check finds in the job as it is now.
  [[nodiscard]] JobOutlook unheld(const std::string& file) const {
    const JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
    JobOutlook outlook;
    outlook.question = AnalyzedJob{{.resin_ml = {}, .findings = {"unheld_places"}, .warnings = {}},
                                   content_mark(files),
                                   read_settings(files, config)};
    return outlook;
  }
  std::vector<std::function<void(const JobAnalysisOutcome&)>> analyses;  // under way, by when they were begun
  // The last one ends: the job as it is now has these.
  void find(const std::string& file, const Names& findings) {
    const JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
    PreprintAnalysis analysis;
    analysis.findings = findings;
    analyses.back()(AnalyzedJob{analysis, content_mark(files), read_settings(files, config)});
  }
  PrintQueue::Calls queue_calls() {
    PrintQueue::Calls calls{.check =
                                [this](const std::string& file, JobReader::Keep, const auto& done) {
                                  checked.push_back(file);
                                  if (asking) return done(JobOutlook{});
                                  check_done = done;
                                },
                            .forget = [](const std::string&) {},
                            .reject = [](const std::string&, const std::string&, const Spool::Rejected&) {},
                            .changed = [this] { scheduler.run(); },
                            .refused = [](const std::string&, const std::string&) {},
                            .removed = [](const std::string&, const std::string&) {},
                            .keep_order = [](const QueueOrder::Names&, const auto&) {}};
    calls.questions.changed = [] {};
    calls.questions.asked = [](const PreprintAnalysis& analysis) { return analysis.findings; };
    calls.questions.keep_accepted = [](const Acceptances::Lines&, const auto& done) { done(""); };
    if (!asking) return calls;
    calls.questions.analyze = [this](const std::string&, JobReader::Keep, const auto& done) {
      analyses.push_back(done);
    };
    return calls;
  }
  PrintQueue queue{log.log, queue_calls()};
  JobScheduler scheduler{context,
                         spool,
                         queue,
                         hold,
                         {.has_job = [this] { return has_job; },
                          .prints = [this] { return has_job; },
                          .controlled_by_hand = [this] { return by_hand; },
                          .begin =
                              [this](ClaimedJob job) {
                                has_job = true;
                                jobs.push_back(std::move(job));
                              },
                          .copy_over = [] {}}};
};

}  // namespace

TEST_CASE("A job that arrives at an idle printer begins at once, in printing/ and with its settings") {
  Desk desk;
  desk.arrive("part.stl");
  CHECK(desk.begun() == Names{"part"});
  CHECK(desk.has("printing/part.stl"));
  CHECK(desk.jobs[0].settings);
  CHECK(desk.scheduler.waiting_for().empty());
  CHECK(desk.checked.empty());
}

TEST_CASE("A job with supports is checked before it begins, since its owner may have to be asked") {
  Desk desk;
  desk.config.supports = SupportPolicy::Auto;
  desk.arrive("part.stl");
  CHECK(desk.begun().empty());
  REQUIRE(desk.checked == Names{"part.stl"});
  CHECK(desk.has("incoming/part.stl"));
  SECTION("it is held") {
    desk.check_done(JobOutlook{});
    CHECK(desk.begun() == Names{"part"});
    CHECK_FALSE(desk.jobs[0].unheld_accepted);
  }
  SECTION("what cannot be held is accepted") {
    desk.check_done(desk.unheld("part.stl"));
    CHECK(desk.begun().empty());
    desk.arrive("other.stl");
    desk.check_done(JobOutlook{});
    CHECK(desk.begun() == Names{"other"});
    desk.queue.accept("part.stl", "user me");
    desk.end_job();
    REQUIRE(desk.begun() == Names{"other", "part"});
    CHECK(desk.jobs[1].unheld_accepted);
  }
  SECTION("what was accepted is not what lies there when its turn comes") {
    desk.check_done(desk.unheld("part.stl"));
    desk.put_text(Spool::Folder::Incoming, "part.json", "{}");
    desk.queue.accept("part.stl", "user me");
    CHECK(desk.begun().empty());
    CHECK(desk.run_until([&] { return desk.checked == Names{"part.stl", "part.stl"}; }));
  }
}

TEST_CASE("One job begins after the other, in their order") {
  Desk desk;
  for (const char* file : {"b.stl", "a.stl", "c.stl"})
    desk.arrive(file);
  CHECK(desk.begun() == Names{"b"});
  CHECK(desk.checked == Names{"a.stl", "c.stl"});
}

TEST_CASE("The time to the first light counts from the arrival, or from the end of the wait") {
  Desk desk;
  desk.arrive("one.stl");
  const TimePoint between = std::chrono::steady_clock::now();
  desk.arrive("two.stl");
  const TimePoint end_of_wait = std::chrono::steady_clock::now();
  (void)desk.queue.take_first();  // its check does not end here
  CHECK(desk.jobs[0].turn_came <= between);
  desk.queue.put_last({.file = "two.stl", .arrived = between, .waited = true});
  desk.end_job();
  REQUIRE(desk.jobs.size() == 2);
  CHECK(desk.jobs[1].turn_came >= end_of_wait);
}

TEST_CASE("A job that becomes the next one while another begins waits for it") {
  Desk desk;
  desk.has_job = true;
  desk.put(Spool::Folder::Incoming, "one.stl");
  desk.put(Spool::Folder::Incoming, "two.stl");
  desk.queue.put_last({.file = "one.stl", .arrived = {}});
  desk.queue.put_last({.file = "two.stl", .arrived = {}});
  desk.has_job = false;
  desk.scheduler.run_soon();
  CHECK(desk.run_until([&] { return desk.has_job; }));
  CHECK(desk.begun() == Names{"one"});
  CHECK(desk.queue.jobs().front().waited);
}

TEST_CASE("The machine comes before the hold in what a job waits for, and the hold before the disk") {
  Desk desk;
  desk.config.min_free_disk_bytes = ~std::uintmax_t{0};
  desk.machine.open_lid();
  desk.hold.hold("part failed");
  desk.arrive("part.stl");
  CHECK(desk.scheduler.waiting_for() == "the lid is open");
  CHECK(desk.log.has("info: part.stl waits: the lid is open"));
  desk.machine.close_lid();
  desk.scheduler.run();
  CHECK(desk.scheduler.waiting_for().starts_with("the queue is held: part failed"));
  desk.hold.release();
  desk.scheduler.run();
  CHECK(desk.scheduler.waiting_for().starts_with("the spool's disk has "));
  desk.config.min_free_disk_bytes = 0;
  CHECK(desk.begun().empty());
  CHECK(desk.checked == Names{"part.stl"});
}

TEST_CASE("Why a job waits is told once") {
  Desk desk;
  desk.machine.open_lid();
  desk.arrive("part.stl");
  for (int i = 0; i < 3; ++i)
    desk.scheduler.run();
  CHECK(desk.log.count("part.stl waits") == 1);
}

TEST_CASE("A job that is gone when its turn comes was taken away, and the next one begins") {
  Desk desk;
  desk.has_job = true;
  desk.queue.arrived("gone.stl");
  desk.queue.arrived("gone-too.stl");
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.queue.put_last({.file = "part.stl", .arrived = {}});
  // Their checks go on for ever here.
  WaitingJob gone = desk.queue.take_first(), gone_too = desk.queue.take_first();
  gone.check = gone_too.check = WaitingJob::Check::Passed;
  desk.queue.put_first(std::move(gone_too));
  desk.queue.put_first(std::move(gone));
  desk.has_job = false;
  desk.scheduler.run_soon();
  CHECK(desk.run_until([&] { return desk.has_job; }));
  CHECK(desk.begun() == Names{"part"});
  CHECK(desk.log.has("gone.stl: taken away by the owner"));
  CHECK(desk.log.has("gone-too.stl: taken away by the owner"));
}

TEST_CASE("A job that cannot be claimed keeps its turn, and why is told once") {
  Desk desk;
  fs::remove_all(desk.spool.folder(Spool::Folder::Printing));
  for (int i = 0; i < 2; ++i) {
    desk.arrive("part.stl");
    CHECK(desk.scheduler.waiting_for().starts_with("part.stl cannot be claimed: "));
  }
  CHECK(desk.queue.jobs().size() == 1);
  CHECK(desk.queue.jobs().front().waited);
  CHECK(desk.log.count("error: part.stl cannot be claimed") == 1);
  CHECK(desk.has("incoming/part.stl"));
}

TEST_CASE("A job waits for a profile that is broken, and the others are checked meanwhile") {
  Desk desk;
  const std::string resin = std::exchange(desk.config.resin, "none-such");
  desk.arrive("part.stl");
  CHECK(desk.begun().empty());
  CHECK(desk.scheduler.waiting_for().ends_with("; the queue goes on when it is mended"));
  CHECK(desk.has("incoming/part.stl"));
  desk.arrive("other.stl");
  CHECK(desk.checked == Names{"other.stl"});
  desk.config.resin = resin;
  desk.scheduler.run();
  CHECK(desk.begun() == Names{"part"});
  CHECK(desk.log.count("part.stl waits") == 1);
}

TEST_CASE("A job begins whose ticket is a reason to refuse it: its reading says why") {
  Desk desk;
  desk.put_text(Spool::Folder::Incoming, "part.json", "no ticket");
  desk.arrive("part.stl");
  REQUIRE(desk.begun() == Names{"part"});
  CHECK_FALSE(desk.jobs[0].settings);
}

TEST_CASE("A name that a job has had gets a number behind it") {
  Desk desk;
  desk.put(Spool::Folder::Done, "part.stl");
  desk.arrive("part.stl");
  REQUIRE(desk.jobs.size() == 1);
  CHECK(desk.jobs[0].files.name != "part");
  CHECK(desk.has("done/part.stl"));
}

TEST_CASE("Nothing begins behind a stop, but records are kept") {
  Desk desk;
  desk.scheduler.stop();
  desk.lit = true;
  desk.hold.hold("part failed");
  desk.lit = false;
  desk.arrive("part.stl");
  CHECK(desk.begun().empty());
  CHECK(desk.has("incoming/part.stl"));
  CHECK(desk.has_record("queue-held"));
}

TEST_CASE("What the disk did not take is tried again when nothing is printed") {
  Desk desk;
  const fs::path obstacle = desk.state() / "queue-held";
  fs::create_directories(obstacle / "full");
  desk.hold.hold("part failed");
  REQUIRE(desk.hold.failed());
  fs::remove_all(obstacle);
  desk.has_job = true;
  desk.scheduler.run();
  CHECK(desk.hold.failed());
  desk.end_job();
  CHECK_FALSE(desk.hold.failed());
}

TEST_CASE("No job begins while the printer is controlled by hand, and the reason is told") {
  Desk desk;
  desk.by_hand = true;
  desk.arrive("part.stl");
  CHECK(desk.begun().empty());
  CHECK(desk.scheduler.waiting_for() == "the printer is controlled by hand; \"contourctl stop\" ends that");
  desk.by_hand = false;
  desk.scheduler.run();
  CHECK(desk.scheduler.waiting_for().empty());
}

TEST_CASE("A job at an idle printer that asks is looked through first, and begins when nothing is found") {
  Desk desk(true);
  desk.arrive("part.stl");
  CHECK(desk.begun().empty());
  CHECK(desk.scheduler.waiting_for() == "its layers are looked through first, as ask_before demands");
  REQUIRE(desk.analyses.size() == 1);
  desk.find("part.stl", {});
  CHECK(desk.begun() == Names{"part"});
  CHECK(desk.scheduler.waiting_for().empty());
}

TEST_CASE("Jobs behind one that asks go on in their order, and it is the next one when it is accepted") {
  Desk desk(true);
  for (const char* file : {"a.stl", "b.stl", "c.stl"})
    desk.arrive(file);
  desk.find("a.stl", {"islands"});
  CHECK(desk.begun().empty());
  desk.find("b.stl", {});
  CHECK(desk.begun() == Names{"b"});
  CHECK(desk.run_until([&] { return desk.analyses.size() == 3; }));  // beside the print
  desk.find("c.stl", {});
  desk.queue.accept("a.stl", "user me");
  desk.end_job();
  CHECK(desk.begun() == Names{"b", "a"});
  desk.end_job();
  CHECK(desk.begun() == Names{"b", "a", "c"});
}

TEST_CASE("When all jobs ask, the queue says which command goes on, and goes on with it") {
  Desk desk(true);
  desk.arrive("part.stl");
  desk.find("part.stl", {"islands"});
  CHECK(desk.begun().empty());
  CHECK(desk.scheduler.waiting_for() == "islands; \"contourctl accept part\" has it printed as it is");
  CHECK(desk.log.count("contourctl accept part") == 1);
  desk.queue.accept("part.stl", "user me");
  CHECK(desk.begun() == Names{"part"});
}

TEST_CASE("A job that is still looked through keeps those behind it waiting") {
  Desk desk(true);
  desk.arrive("a.stl");
  desk.arrive("b.stl");
  REQUIRE(desk.analyses.size() == 1);
  desk.scheduler.run();
  CHECK(desk.begun().empty());
}

TEST_CASE("A job that is not as it was looked through is looked through again") {
  Desk desk(true);
  desk.has_job = true;
  desk.arrive("part.stl");
  desk.find("part.stl", {});
  SECTION("its file is another") {
    fs::last_write_time(desk.config.spool_folder / "incoming/part.stl",
                        fs::file_time_type::clock::now() + std::chrono::hours{1});
  }
  SECTION("it has a ticket") {
    desk.put_text(Spool::Folder::Incoming, "part.json", R"({"copies": 2})");
  }
  desk.has_job = false;
  desk.scheduler.run();
  CHECK(desk.begun().empty());
  CHECK(desk.run_until([&] { return desk.analyses.size() == 2; }));
  desk.find("part.stl", {});
  CHECK(desk.begun() == Names{"part"});
}
