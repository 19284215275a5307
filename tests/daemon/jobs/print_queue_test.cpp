#include "daemon/jobs/print_queue.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using Check = WaitingJob::Check;
using Keep = JobChecks::Keep;

namespace {

// A queue whose checks and refusals end when a test ends them.
class QueueFixture {
 public:
  explicit QueueFixture(const Names& ask_before = {}) { config.ask_before = ask_before; }

  void arrive(const Names& files) {
    for (const std::string& file : files)
      queue.arrived(file);
  }
  // Lets the next check refuse its job, whose files are then on their way to failed/.
  void begin_to_refuse(const std::string& reason) {
    queue.check_next();
    work.checks.back().done(JobRefusal{reason});
  }
  [[nodiscard]] Names order() const {
    Names files;
    for (const WaitingJob& job : queue.jobs())
      files.push_back(job.file);
    return files;
  }

  EventLoop loop;
  testing::LogText log{loop};
  PrinterConfig config;
  testing::FakeChecks work;
  testing::FakeQueueObserver observer;
  Names& reported = observer.reported;
  PrintQueue queue{config, work, observer, log.log};
};

// A queue with ask_before for islands and cracks. The checks succeed at once; find() sets the findings of an
// analysis.
class AskingQueueFixture : public QueueFixture {
 public:
  AskingQueueFixture() : QueueFixture({"islands", "cracks"}) {
    work.check_result = JobOutlook{};
    work.saves_end = true;
  }

  void arrive(const Names& files) {
    for (const std::string& file : files) {
      queue.arrived(file);
      queue.check_next();
      queue.check_next();
    }
  }
  // Ends the analysis under way with these findings.
  void find(const Names& findings, const std::string& content = "a1") {
    REQUIRE_FALSE(work.analyses.empty());
    PreprintAnalysis analysis;
    analysis.findings = findings;
    for (const std::string& each : findings)
      analysis.warnings.push_back("it has " + each);
    work.analyses.back().done(AnalyzedJob{analysis, content, {}});
  }
  // Analyzes one job after the other in the queue's order, each with its findings.
  void analyze(const std::vector<Names>& findings) {
    for (const Names& each : findings) {
      queue.check_next();
      find(each, std::to_string(work.analyses.size()));
    }
  }
};

}  // namespace

TEST_CASE("Jobs wait in order of arrival, and the first one is next") {
  QueueFixture fixture;
  fixture.arrive({"b.stl", "a.stl", "c.stl"});
  CHECK(fixture.order() == Names{"b.stl", "a.stl", "c.stl"});
  CHECK(fixture.log.has("info: c.stl: arrived, number 3 in the queue"));
  CHECK(fixture.reported == Names{"changed", "changed", "changed"});
  CHECK(fixture.queue.take_first().file == "b.stl");
  CHECK(fixture.order() == Names{"a.stl", "c.stl"});
}

TEST_CASE("A check that was given up is repeated") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.work.checks[0].done(ReadingGivenUp{});
  CHECK(fixture.queue.jobs().front().check == Check::Wanted);
  fixture.queue.check_next();
  CHECK(fixture.work.checks.size() == 2);
}

TEST_CASE("A rewritten job keeps its place and is checked again") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.queue.check_next();
  fixture.work.checks[0].done(JobOutlook{});
  REQUIRE(fixture.queue.jobs().front().check == Check::Passed);
  fixture.queue.arrived("a.stl");
  CHECK(fixture.order() == Names{"a.stl", "b.stl"});
  CHECK(fixture.queue.jobs().front().check == Check::Wanted);
  CHECK(fixture.log.count("a.stl: arrived") == 1);
}

TEST_CASE("A job that keeps changing while being read moves to the end of the queue") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl", "c.stl"});
  const auto interrupt = [&](int times) {
    for (int i = 0; i < times; ++i) {
      fixture.queue.check_next();
      REQUIRE(fixture.work.checks.back().file == "a.stl");
      fixture.queue.arrived("a.stl");
      // A second write, while no check is running, does not count as an interruption.
      fixture.queue.arrived("a.stl");
    }
  };
  interrupt(3);
  CHECK(fixture.order() == Names{"a.stl", "b.stl", "c.stl"});
  interrupt(1);
  CHECK(fixture.order() == Names{"b.stl", "c.stl", "a.stl"});
  CHECK(fixture.log.count("a.stl: keeps changing while being read; moved to the end of the queue") == 1);
  fixture.queue.check_next();
  CHECK(fixture.work.checks.back().file == "b.stl");
  // It stays in the queue after the others have begun.
  CHECK(fixture.queue.take_first().file == "b.stl");
  CHECK(fixture.queue.take_first().file == "c.stl");
  interrupt(2);
  CHECK(fixture.order() == Names{"a.stl"});
  CHECK(fixture.log.count("moved to the end of the queue") == 1);
}

TEST_CASE("A rewritten job starts a new wait, and its trouble is not logged again") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  WaitingJob job = fixture.queue.take_first();
  job.trouble = "it cannot be claimed";
  job.waited = true;
  fixture.queue.put_first(std::move(job));
  fixture.queue.arrived("a.stl");
  CHECK(fixture.queue.jobs().front().trouble == "it cannot be claimed");
  CHECK_FALSE(fixture.queue.jobs().front().waited);
}

TEST_CASE("Each call checks the first unchecked job, so that each job is checked once") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i)
    fixture.queue.check_next();
  REQUIRE(fixture.work.checks.size() == 2);
  CHECK(fixture.work.checks[0].file == "a.stl");
  CHECK(fixture.work.checks[1].file == "b.stl");
}

TEST_CASE("Only the check of the next job keeps the prepared job") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.queue.check_next();
  fixture.queue.check_next();
  REQUIRE(fixture.work.checks.size() == 2);
  CHECK(fixture.work.checks[0].keep == Keep::Prepared);
  CHECK(fixture.work.checks[1].keep == Keep::Nothing);
}

TEST_CASE("The cached preparation of a job that is rewritten, removed or put last is discarded") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  CHECK(fixture.work.forgotten.empty());
  fixture.queue.arrived("a.stl");
  CHECK(fixture.work.forgotten == Names{"a.stl"});
  fixture.queue.put_last(fixture.queue.take_first());
  CHECK(fixture.work.forgotten == Names{"a.stl", "a.stl"});
  fixture.queue.withdrawn("b.stl");
  CHECK(fixture.work.forgotten == Names{"a.stl", "a.stl", "b.stl"});
}

TEST_CASE("The result of a check is ignored if the file was rewritten meanwhile") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.queue.arrived("a.stl");
  fixture.work.checks[0].done(JobRefusal{"no model"});
  CHECK(fixture.work.rejections.empty());
  CHECK(fixture.queue.jobs().front().check == Check::Wanted);
}

TEST_CASE("The result of a check is ignored if the rewritten file is already being checked") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.queue.arrived("a.stl");
  fixture.queue.check_next();
  REQUIRE(fixture.work.checks.size() == 2);
  fixture.work.checks[0].done(JobRefusal{"no model"});
  CHECK(fixture.work.rejections.empty());
  CHECK(fixture.queue.jobs().front().check == Check::Running);
  fixture.work.checks[1].done(JobOutlook{});
  CHECK(fixture.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("The result of a check is ignored if the job is gone") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.queue.withdrawn("a.stl");
  fixture.reported.clear();
  fixture.work.checks[0].done(JobRefusal{"no model"});
  CHECK(fixture.work.rejections.empty());
  CHECK(fixture.reported == Names{"changed"});
}

TEST_CASE("A job whose file is removed leaves the queue, and the removal of other files changes nothing") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.reported.clear();
  fixture.queue.withdrawn("c.stl");
  CHECK(fixture.reported.empty());
  fixture.queue.withdrawn("a.stl");
  CHECK(fixture.order() == Names{"b.stl"});
  CHECK(fixture.log.has("info: a.stl: removed from incoming by a user"));
  CHECK(fixture.reported == Names{"changed"});
}

TEST_CASE("A refused job stays until its files are in failed/, and is reported before the queue continues") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.begin_to_refuse("no model");
  REQUIRE(fixture.work.rejections.size() == 1);
  CHECK(fixture.work.rejections[0].reason == "no model\n");
  CHECK(fixture.order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(fixture.log.has("no model"));
  fixture.reported.clear();
  fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(fixture.order() == Names{"b.stl"});
  CHECK(fixture.reported == Names{"a failed: no model", "changed"});
  CHECK(fixture.log.has("error: a.stl: no model"));
}

TEST_CASE("A file that the spool moves to failed/ is not logged as removed by a user") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.begin_to_refuse("no model");
  fixture.queue.withdrawn("a.stl");
  CHECK(fixture.order() == Names{"a.stl"});
  fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(fixture.order().empty());
  CHECK_FALSE(fixture.log.has("removed from incoming"));
}

TEST_CASE("A job that a user removes during its refusal leaves the queue") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.begin_to_refuse("no model");
  fixture.queue.withdrawn("a.stl");
  fixture.reported.clear();
  fixture.work.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(fixture.order() == Names{"b.stl"});
  CHECK(fixture.log.has("a.stl: removed from incoming by a user"));
  CHECK(fixture.reported == Names{"changed"});
}

TEST_CASE("A job that a user rewrites during its refusal keeps its place") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.begin_to_refuse("no model");
  fixture.reported.clear();
  fixture.work.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(fixture.order() == Names{"a.stl", "b.stl"});
  CHECK(fixture.reported == Names{"changed"});
  CHECK_FALSE(fixture.log.has("no model"));
}

TEST_CASE("A file that arrives again during its refusal went to failed/ or was rewritten") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.begin_to_refuse("no model");
  fixture.queue.arrived("a.stl");
  SECTION("it went to failed/, and no user removed it") {
    fixture.queue.withdrawn("a.stl");
    fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
    CHECK(fixture.order().empty());
    CHECK_FALSE(fixture.log.has("removed from incoming"));
  }
  SECTION("it was rewritten, and is checked") {
    fixture.work.rejections[0].done(Spool::Rejection::Unfinished, "");
    fixture.queue.check_next();
    CHECK(fixture.work.checks.size() == 2);
  }
  SECTION("a user removed it before") {
    fixture.queue.withdrawn("a.stl");
    fixture.queue.arrived("a.stl");
    fixture.work.rejections[0].done(Spool::Rejection::Unfinished, "");
    CHECK(fixture.order() == Names{"a.stl"});
    CHECK_FALSE(fixture.log.has("removed from incoming"));
  }
}

TEST_CASE("A file that arrives after the refusal of another with its name is a new job") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.begin_to_refuse("no model");
  fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
  fixture.queue.arrived("a.stl");
  CHECK(fixture.order() == Names{"a.stl"});
  CHECK(fixture.queue.first_may_begin());
}

TEST_CASE("A refused job whose files cannot be moved leaves the queue, and the log says so") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.begin_to_refuse("no model");
  SECTION("its files may be deleted") {
    fixture.work.rejections[0].done(Spool::Rejection::LeftThere, "");
    CHECK(
        fixture.log.has("warning: a.stl: stays in incoming, because it cannot be moved; it may be deleted"));
  }
  SECTION("the move has failed") {
    fixture.work.rejections[0].done(Spool::Rejection::Impossible, "no room");
    CHECK(fixture.log.has("error: a.stl: cannot be moved to failed: no room"));
  }
  CHECK(fixture.order().empty());
}

TEST_CASE("A job for which memory is short is logged once, and checked again later") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  for (const char* why : {"it takes 900 MB", "it takes 901 MB"}) {
    fixture.queue.check_next();
    fixture.work.checks.back().done(JobRefusal{why, true});
    CHECK(fixture.queue.jobs().front().postponed == why);
    fixture.queue.check_next();  // starts no check before check_postponed()
    fixture.queue.check_postponed();
  }
  CHECK(fixture.work.checks.size() == 2);
  CHECK(fixture.log.count("a.stl: will be read later") == 1);
  fixture.queue.check_next();
  fixture.work.checks.back().done(JobOutlook{});
  CHECK(fixture.queue.jobs().front().postponed.empty());
  CHECK(fixture.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("A job is not refused because its resin profile is broken") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.work.checks[0].done(JobRefusal{"the profile is broken", false, "standard.json: it is broken"});
  CHECK(fixture.work.rejections.empty());
  CHECK(fixture.log.has("warning: a.stl: standard.json: it is broken"));
  CHECK(fixture.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("The first job does not begin during its check, nor while any job is being refused") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  CHECK(fixture.queue.first_may_begin());
  fixture.queue.check_next();
  CHECK_FALSE(fixture.queue.first_may_begin());
  fixture.work.checks[0].done(JobOutlook{});
  CHECK(fixture.queue.first_may_begin());
  fixture.begin_to_refuse("no model");
  CHECK(fixture.work.rejections[0].file == "b.stl");
  CHECK_FALSE(fixture.queue.first_may_begin());
  fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(fixture.queue.first_may_begin());
}

TEST_CASE("A job can be moved to any place, and the order is saved up to its old or new place") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  fixture.reported.clear();
  fixture.queue.move("c.stl", 0);
  CHECK(fixture.order() == Names{"c.stl", "a.stl", "b.stl", "d.stl"});
  CHECK(fixture.work.saved.back() == Names{"c.stl", "a.stl", "b.stl"});
  CHECK(fixture.reported == Names{"changed"});
  CHECK(fixture.log.has("info: c.stl: number 1 in the queue now"));
  fixture.work.save_done("");
  fixture.queue.move("a.stl", 99);
  CHECK(fixture.order() == Names{"c.stl", "b.stl", "d.stl", "a.stl"});
  CHECK(fixture.work.saved.back() == fixture.order());
  fixture.work.save_done("");
  fixture.queue.move("b.stl", 2);
  CHECK(fixture.order() == Names{"c.stl", "d.stl", "b.stl", "a.stl"});
  CHECK(fixture.work.saved.back() == fixture.order());
}

TEST_CASE("Moving a job to its own place changes nothing") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.reported.clear();
  fixture.queue.move("b.stl", 1);
  CHECK(fixture.work.saved.empty());
  CHECK(fixture.reported.empty());
}

TEST_CASE("The order is saved one write at a time, and the latest one is written last") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl", "c.stl"});
  fixture.queue.move("c.stl", 0);
  fixture.queue.move("b.stl", 0);
  fixture.queue.move("a.stl", 0);
  CHECK(fixture.work.saved.size() == 1);
  fixture.work.save_done("");
  REQUIRE(fixture.work.saved.size() == 2);
  CHECK(fixture.work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  fixture.work.save_done("");
  CHECK(fixture.work.saved.size() == 2);
}

TEST_CASE("A job that has left the queue is removed from the saved order") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  fixture.queue.move("d.stl", 0);
  fixture.work.save_done("");
  SECTION("claimed") {
    const WaitingJob job = fixture.queue.take_first();
    CHECK(fixture.work.saved.size() == 1);
    fixture.queue.begun(job);
    CHECK(fixture.work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("put last") {
    fixture.queue.put_last(fixture.queue.take_first());
    CHECK(fixture.work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("removed") {
    fixture.queue.withdrawn("b.stl");
    CHECK(fixture.work.saved.back() == Names{"d.stl", "a.stl", "c.stl"});
  }
  SECTION("refused") {
    fixture.queue.refuse_first("no");
    fixture.work.rejections.back().done(Spool::Rejection::Filed, "");
    CHECK(fixture.work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
}

TEST_CASE("A job that could not be claimed keeps its place") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.queue.move("b.stl", 0);
  fixture.queue.put_first(fixture.queue.take_first());
  CHECK(fixture.order() == Names{"b.stl", "a.stl"});
  CHECK(fixture.work.saved.size() == 1);
}

TEST_CASE(
    "After a restart jobs have their saved places, in whatever order they arrive, and new ones come last") {
  QueueFixture fixture;
  fixture.queue.load_order({"c.stl", "gone.stl", "a.stl", "b.stl"});
  fixture.arrive({"a.stl", "new.stl", "b.stl", "c.stl"});
  CHECK(fixture.order() == Names{"c.stl", "a.stl", "b.stl", "new.stl"});
  CHECK(fixture.log.has("info: c.stl: arrived, number 1 in the queue"));
  CHECK(fixture.work.saved.empty());
  fixture.queue.move("new.stl", 1);
  CHECK(fixture.order() == Names{"c.stl", "new.stl", "a.stl", "b.stl"});
  CHECK(fixture.work.saved.back() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
  fixture.queue.arrived("gone.stl");
  CHECK(fixture.order() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
}

TEST_CASE("A failure to save the order is logged once, and the next order is tried") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i) {
    fixture.queue.move("b.stl", i == 1 ? 1 : 0);
    fixture.work.save_done("no room");
  }
  CHECK(fixture.work.saved.size() == 3);
  CHECK(fixture.log.count("warning: cannot save the order of the queue; a restart will lose it: no room") ==
        1);
}

TEST_CASE(
    "A removed job goes to failed/ with its reason and without an error, and no job begins until then") {
  QueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.queue.check_next();
  fixture.reported.clear();
  fixture.queue.remove("a.stl", "removed by me");
  CHECK(fixture.work.forgotten == Names{"a.stl"});
  CHECK(fixture.order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(fixture.queue.first_may_begin());
  fixture.work.checks[0].done(JobRefusal{"no model"});  // ignored
  REQUIRE(fixture.work.rejections.size() == 1);
  CHECK(fixture.work.rejections[0].reason == "removed by me\n");
  fixture.reported.clear();
  fixture.work.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(fixture.order() == Names{"b.stl"});
  CHECK(fixture.reported == Names{"a cancelled: removed by me", "changed"});
  CHECK(fixture.log.has("info: a.stl: removed by me"));
}

TEST_CASE("A job that is being rewritten is not removed, and the log says so") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.remove("a.stl", "removed by me");
  fixture.queue.arrived("a.stl");
  fixture.work.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(fixture.order() == Names{"a.stl"});
  CHECK(fixture.queue.jobs().front().check == Check::Wanted);
  CHECK(fixture.log.has("warning: a.stl: stays in the queue, because it is being rewritten"));
}

TEST_CASE("The result of a check is valid until the file is rewritten") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  fixture.work.checks[0].done(JobOutlook{.layers = 7});
  REQUIRE(fixture.queue.jobs().front().outlook);
  CHECK(fixture.queue.jobs().front().outlook->layers == 7);
  fixture.queue.arrived("a.stl");
  CHECK_FALSE(fixture.queue.jobs().front().outlook);
}

TEST_CASE("Without ask_before no job is analyzed") {
  QueueFixture fixture;
  fixture.arrive({"a.stl"});
  CHECK_FALSE(fixture.queue.questions().wanted());
  CHECK(fixture.queue.first_unanalyzed().empty());
  CHECK(fixture.queue.questions().knows(std::nullopt, {}, std::nullopt));
}

TEST_CASE("Jobs are analyzed one at a time after all checks, and only the next one is kept") {
  AskingQueueFixture fixture;
  fixture.work.check_result.reset();
  fixture.arrive({"a.stl"});
  fixture.queue.check_next();
  CHECK(fixture.work.analyses.empty());
  fixture.work.check_result = JobOutlook{};
  fixture.arrive({"b.stl", "c.stl"});
  CHECK(fixture.work.analyses.empty());  // the check of a.stl has not ended
  fixture.queue.arrived("a.stl");
  fixture.queue.check_next();
  for (int i = 0; i < 3; ++i)
    fixture.queue.check_next();
  REQUIRE(fixture.work.analyses.size() == 1);
  CHECK(fixture.work.analyses[0].file == "a.stl");
  CHECK(fixture.work.analyses[0].keep == Keep::Prepared);
  CHECK(fixture.queue.first_unanalyzed() == "its layers must be analyzed first, as ask_before requires");
  fixture.find({});
  CHECK(fixture.queue.first_unanalyzed().empty());
  fixture.queue.check_next();
  REQUIRE(fixture.work.analyses.size() == 2);
  CHECK(fixture.work.analyses[1].file == "b.stl");
  CHECK(fixture.work.analyses[1].keep == Keep::Nothing);
}

TEST_CASE("A job that waits for confirmation is skipped and keeps its place") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.analyze({{"islands", "empty_layers"}, {}});
  CHECK(fixture.queue.jobs()[0].asks == Names{"islands"});
  CHECK(fixture.log.has("warning: a.stl waits: islands; run \"contourctl accept a\" to print it as it is"));
  CHECK(fixture.log.has("warning: a.stl: it has islands"));
  REQUIRE(fixture.queue.has_first());
  CHECK(fixture.queue.first() == 1);
  WaitingJob next = fixture.queue.take_first();
  CHECK(next.file == "b.stl");
  CHECK_FALSE(fixture.queue.has_first());
  fixture.queue.put_first(std::move(next));
  REQUIRE(fixture.queue.jobs().size() == 2);
  CHECK(fixture.queue.jobs()[0].file == "a.stl");
  CHECK(fixture.queue.jobs()[1].file == "b.stl");
}

TEST_CASE("An accepted job is the next one again, and the log says who accepted it") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl", "b.stl"});
  fixture.analyze({{"islands"}, {}});
  fixture.queue.accept("a.stl", "user me");
  CHECK(fixture.queue.first() == 0);
  CHECK(fixture.observer.question_changes == 2);  // the question, then its acceptance
  CHECK(fixture.log.has("info: a.stl: accepted by user me with islands"));
  CHECK(fixture.work.saved == std::vector<Names>{{"1 islands"}});
}

TEST_CASE(
    "An accepted finding needs no second confirmation for the same content, but one for other content") {
  AskingQueueFixture fixture;
  fixture.queue.questions().load_accepted({"a1 islands"});
  fixture.arrive({"a.stl", "b.stl", "c.stl"});
  fixture.find({"islands"}, "a1");
  CHECK(fixture.queue.jobs()[0].asks.empty());
  fixture.queue.check_next();
  fixture.find({"islands"}, "b1");
  CHECK(fixture.queue.jobs()[1].asks == Names{"islands"});
  fixture.queue.check_next();
  fixture.find({"islands", "cracks"}, "a1");
  CHECK(fixture.queue.jobs()[2].asks == Names{"cracks"});
}

TEST_CASE("A checked job with places that cannot be held waits for confirmation") {
  AskingQueueFixture fixture;
  JobOutlook outlook;
  outlook.question =
      AnalyzedJob{{.resin_ml = {}, .findings = {"unheld_places"}, .warnings = {"1 place"}}, "a1", {}};
  fixture.work.check_result = outlook;
  SECTION("without ask_before") {
    fixture.config.ask_before.clear();
    const PrintQueue& queue = fixture.queue;
    fixture.arrive({"a.stl"});
    CHECK_FALSE(queue.has_first());
    CHECK(queue.jobs()[0].asks == Names{"unheld_places"});
    CHECK(fixture.log.has("warning: a.stl waits: unheld places; run \"contourctl accept a\""));
    CHECK(fixture.log.has("warning: a.stl: 1 place"));
    fixture.queue.accept("a.stl", "user me");
    CHECK(queue.has_first());
    CHECK(queue.questions().has_accepted(queue.jobs()[0].analyzed, "unheld_places"));
  }
  SECTION("with ask_before, after its analysis") {
    fixture.arrive({"a.stl"});
    CHECK(fixture.queue.has_first());
    fixture.find({"unheld_places"});
    CHECK_FALSE(fixture.queue.has_first());
  }
}

TEST_CASE("Acceptances are forgotten when the job ends, not when it begins") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.find({"islands"}, "a1");
  fixture.queue.accept("a.stl", "user me");
  fixture.queue.questions().begun(fixture.queue.take_first().analyzed);
  CHECK(fixture.work.saved.back() == Names{"a1 islands"});
  fixture.queue.questions().ended();
  CHECK(fixture.work.saved.back().empty());
}

TEST_CASE(
    "A job that is rewritten during its analysis, or while it waits for confirmation, is analyzed again") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl"});
  const auto late = fixture.work.analyses[0].done;
  fixture.queue.arrived("a.stl");
  late(AnalyzedJob{});
  CHECK_FALSE(fixture.queue.jobs()[0].analyzed);
  fixture.queue.check_next();
  fixture.queue.check_next();
  REQUIRE(fixture.work.analyses.size() == 2);
  fixture.find({"islands"});
  CHECK_FALSE(fixture.queue.has_first());
  fixture.queue.arrived("a.stl");
  CHECK(fixture.queue.has_first());
  CHECK_FALSE(fixture.queue.first_unanalyzed().empty());
}

TEST_CASE("An analysis that was given up is repeated, and one that finds a mistake refuses the job") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.work.analyses[0].done(ReadingGivenUp{});
  fixture.queue.check_next();
  REQUIRE(fixture.work.analyses.size() == 2);
  fixture.work.analyses[1].done(JobRefusal{"no model"});
  REQUIRE(fixture.work.rejections.size() == 1);
  CHECK(fixture.work.rejections[0].file == "a.stl");
  CHECK(fixture.work.rejections[0].reason == "no model\n");
}

TEST_CASE("Without enough memory, or with a broken profile, a job is analyzed later") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl"});
  SECTION("not enough memory") {
    fixture.work.analyses[0].done(JobRefusal{"100 MB", true});
    CHECK(fixture.queue.jobs()[0].check == Check::Postponed);
    CHECK(fixture.queue.first_unanalyzed() == "100 MB");
  }
  SECTION("a broken profile") {
    fixture.work.analyses[0].done(JobRefusal{"wrong", false, "the resin profile x cannot be used"});
    CHECK(fixture.queue.jobs()[0].analysis == WaitingJob::Analysis::Blocked);
    CHECK(fixture.queue.first_unanalyzed() ==
          "the resin profile x cannot be used; the queue continues when the profile is fixed");
  }
  fixture.queue.check_next();
  CHECK(fixture.work.analyses.size() == 1);
  fixture.queue.check_postponed();
  fixture.queue.check_next();
  fixture.queue.check_next();
  REQUIRE(fixture.work.analyses.size() == 2);
  fixture.find({});
  CHECK(fixture.queue.first_unanalyzed().empty());
}

TEST_CASE("A job that is removed during its analysis asks for no confirmation") {
  AskingQueueFixture fixture;
  fixture.arrive({"a.stl"});
  fixture.queue.remove("a.stl", "removed by me");
  fixture.find({"islands"});
  CHECK(fixture.queue.jobs()[0].check == Check::Refused);
  CHECK(fixture.queue.jobs()[0].asks.empty());
}

TEST_CASE("The command that accepts a job is valid in a shell for every job name") {
  const auto question = [](const char* file) { return question_about(file, {"cracks"}); };
  CHECK(question("a-1.b.stl") == "cracks; run \"contourctl accept a-1.b\" to print it as it is");
  CHECK(question("two words.stl").find("accept 'two words'\"") != std::string::npos);
  CHECK(question("it's.stl").find(R"(accept 'it'\''s'")") != std::string::npos);
  CHECK(question("-x.stl").find("accept -- -x\"") != std::string::npos);
  CHECK(question("\x1b[2J.stl").find('\x1b') == std::string::npos);
}
