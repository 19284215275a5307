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

TEST_CASE_METHOD(QueueFixture, "Jobs wait in order of arrival, and the first one is next") {
  arrive({"b.stl", "a.stl", "c.stl"});
  CHECK(order() == Names{"b.stl", "a.stl", "c.stl"});
  CHECK(log.has("info: c.stl: arrived, number 3 in the queue"));
  CHECK(reported == Names{"changed", "changed", "changed"});
  CHECK(queue.take_first().file == "b.stl");
  CHECK(order() == Names{"a.stl", "c.stl"});
}

TEST_CASE_METHOD(QueueFixture, "A check that was given up is repeated") {
  arrive({"a.stl"});
  queue.check_next();
  work.checks[0].done(ReadingGivenUp{});
  CHECK(queue.jobs().front().check == Check::Wanted);
  queue.check_next();
  CHECK(work.checks.size() == 2);
}

TEST_CASE_METHOD(QueueFixture, "A rewritten job keeps its place and is checked again") {
  arrive({"a.stl", "b.stl"});
  queue.check_next();
  work.checks[0].done(JobOutlook{});
  REQUIRE(queue.jobs().front().check == Check::Passed);
  queue.arrived("a.stl");
  CHECK(order() == Names{"a.stl", "b.stl"});
  CHECK(queue.jobs().front().check == Check::Wanted);
  CHECK(log.count("a.stl: arrived") == 1);
}

TEST_CASE_METHOD(QueueFixture, "A job that keeps changing while being read moves to the end of the queue") {
  arrive({"a.stl", "b.stl", "c.stl"});
  const auto interrupt = [&](int times) {
    for (int i = 0; i < times; ++i) {
      queue.check_next();
      REQUIRE(work.checks.back().file == "a.stl");
      queue.arrived("a.stl");
      // A second write, while no check is running, does not count as an interruption.
      queue.arrived("a.stl");
    }
  };
  interrupt(3);
  CHECK(order() == Names{"a.stl", "b.stl", "c.stl"});
  interrupt(1);
  CHECK(order() == Names{"b.stl", "c.stl", "a.stl"});
  CHECK(log.count("a.stl: keeps changing while being read; moved to the end of the queue") == 1);
  queue.check_next();
  CHECK(work.checks.back().file == "b.stl");
  // It stays in the queue after the others have begun.
  CHECK(queue.take_first().file == "b.stl");
  CHECK(queue.take_first().file == "c.stl");
  interrupt(2);
  CHECK(order() == Names{"a.stl"});
  CHECK(log.count("moved to the end of the queue") == 1);
}

TEST_CASE_METHOD(QueueFixture, "A rewritten job starts a new wait, and its trouble is not logged again") {
  arrive({"a.stl"});
  WaitingJob job = queue.take_first();
  job.trouble = "it cannot be claimed";
  job.waited = true;
  queue.put_first(std::move(job));
  queue.arrived("a.stl");
  CHECK(queue.jobs().front().trouble == "it cannot be claimed");
  CHECK_FALSE(queue.jobs().front().waited);
}

TEST_CASE_METHOD(QueueFixture, "Each call checks the first unchecked job, so that each job is checked once") {
  arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i)
    queue.check_next();
  REQUIRE(work.checks.size() == 2);
  CHECK(work.checks[0].file == "a.stl");
  CHECK(work.checks[1].file == "b.stl");
}

TEST_CASE_METHOD(QueueFixture, "Only the check of the next job keeps the prepared job") {
  arrive({"a.stl", "b.stl"});
  queue.check_next();
  queue.check_next();
  REQUIRE(work.checks.size() == 2);
  CHECK(work.checks[0].keep == Keep::Prepared);
  CHECK(work.checks[1].keep == Keep::Nothing);
}

TEST_CASE_METHOD(QueueFixture,
                 "The cached preparation of a job that is rewritten, removed or put last is discarded") {
  arrive({"a.stl", "b.stl"});
  CHECK(work.forgotten.empty());
  queue.arrived("a.stl");
  CHECK(work.forgotten == Names{"a.stl"});
  queue.put_last(queue.take_first());
  CHECK(work.forgotten == Names{"a.stl", "a.stl"});
  queue.withdrawn("b.stl");
  CHECK(work.forgotten == Names{"a.stl", "a.stl", "b.stl"});
}

TEST_CASE_METHOD(QueueFixture,
                 "The result of a check is ignored if the file was rewritten or removed meanwhile") {
  arrive({"a.stl"});
  queue.check_next();
  SECTION("rewritten") {
    queue.arrived("a.stl");
    work.checks[0].done(JobRefusal{"no model"});
    CHECK(queue.jobs().front().check == Check::Wanted);
  }
  SECTION("rewritten, and being checked again") {
    queue.arrived("a.stl");
    queue.check_next();
    REQUIRE(work.checks.size() == 2);
    work.checks[0].done(JobRefusal{"no model"});
    CHECK(queue.jobs().front().check == Check::Running);
    work.checks[1].done(JobOutlook{});
    CHECK(queue.jobs().front().check == Check::Passed);
  }
  SECTION("removed") {
    queue.withdrawn("a.stl");
    reported.clear();
    work.checks[0].done(JobRefusal{"no model"});
    CHECK(reported == Names{"changed"});
  }
  CHECK(work.rejections.empty());
}

TEST_CASE_METHOD(
    QueueFixture,
    "A job whose file is removed leaves the queue, and the removal of other files changes nothing") {
  arrive({"a.stl", "b.stl"});
  reported.clear();
  queue.withdrawn("c.stl");
  CHECK(reported.empty());
  queue.withdrawn("a.stl");
  CHECK(order() == Names{"b.stl"});
  CHECK(log.has("info: a.stl: removed from incoming by a user"));
  CHECK(reported == Names{"changed"});
}

TEST_CASE_METHOD(
    QueueFixture,
    "A refused job stays until its files are in failed/, and is reported before the queue continues") {
  arrive({"a.stl", "b.stl"});
  begin_to_refuse("no model");
  REQUIRE(work.rejections.size() == 1);
  CHECK(work.rejections[0].reason == "no model");
  CHECK(order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(log.has("no model"));
  reported.clear();
  work.rejections[0].done({Rejection::Filed, "", "a"});
  CHECK(order() == Names{"b.stl"});
  CHECK(reported == Names{"a failed: no model", "changed"});
  CHECK(log.has("error: a.stl: no model"));
}

TEST_CASE_METHOD(QueueFixture, "A file that the spool moves to failed/ is not logged as removed by a user") {
  arrive({"a.stl"});
  begin_to_refuse("no model");
  queue.withdrawn("a.stl");
  CHECK(order() == Names{"a.stl"});
  work.rejections[0].done({Rejection::Filed, "", "a"});
  CHECK(order().empty());
  CHECK_FALSE(log.has("removed from incoming"));
}

TEST_CASE_METHOD(
    QueueFixture,
    "A job that a user removes during its refusal leaves the queue, a rewritten one keeps its place") {
  arrive({"a.stl", "b.stl"});
  begin_to_refuse("no model");
  const bool removed = GENERATE(true, false);
  if (removed) queue.withdrawn("a.stl");
  reported.clear();
  work.rejections[0].done({Rejection::Unfinished, "", "a"});
  CHECK(order() == (removed ? Names{"b.stl"} : Names{"a.stl", "b.stl"}));
  CHECK(log.has("a.stl: removed from incoming by a user") == removed);
  CHECK(reported == Names{"changed"});
  CHECK_FALSE(log.has("no model"));
}

TEST_CASE_METHOD(QueueFixture,
                 "A file that arrives again during its refusal went to failed/ or was rewritten") {
  arrive({"a.stl"});
  begin_to_refuse("no model");
  queue.arrived("a.stl");
  SECTION("it went to failed/, and no user removed it") {
    queue.withdrawn("a.stl");
    work.rejections[0].done({Rejection::Filed, "", "a"});
    CHECK(order().empty());
    CHECK_FALSE(log.has("removed from incoming"));
  }
  SECTION("it was rewritten, and is checked") {
    work.rejections[0].done({Rejection::Unfinished, "", "a"});
    queue.check_next();
    CHECK(work.checks.size() == 2);
  }
  SECTION("a user removed it before") {
    queue.withdrawn("a.stl");
    queue.arrived("a.stl");
    work.rejections[0].done({Rejection::Unfinished, "", "a"});
    CHECK(order() == Names{"a.stl"});
    CHECK_FALSE(log.has("removed from incoming"));
  }
}

TEST_CASE_METHOD(QueueFixture,
                 "A file that arrives after the refusal of another with its name is a new job") {
  arrive({"a.stl"});
  begin_to_refuse("no model");
  work.rejections[0].done({Rejection::Filed, "", "a"});
  queue.arrived("a.stl");
  CHECK(order() == Names{"a.stl"});
  CHECK(queue.first_may_begin());
}

TEST_CASE_METHOD(QueueFixture,
                 "A refused job whose files cannot be moved leaves the queue, and the log says so") {
  arrive({"a.stl"});
  begin_to_refuse("no model");
  SECTION("its files may be deleted") {
    work.rejections[0].done({Rejection::LeftThere, "", "a"});
    CHECK(log.has("warning: a.stl: stays in incoming, because it cannot be moved; it may be deleted"));
  }
  SECTION("the move has failed") {
    work.rejections[0].done({Rejection::Impossible, "no room", "a"});
    CHECK(log.has("error: a.stl: cannot be moved to failed: no room"));
  }
  CHECK(order().empty());
}

TEST_CASE_METHOD(QueueFixture, "A job for which memory is short is logged once, and checked again later") {
  arrive({"a.stl"});
  for (const char* why : {"it takes 900 MB", "it takes 901 MB"}) {
    queue.check_next();
    work.checks.back().done(JobRefusal{why, true});
    CHECK(queue.jobs().front().postponed == why);
    queue.check_next();  // starts no check before check_postponed()
    queue.check_postponed();
  }
  CHECK(work.checks.size() == 2);
  CHECK(log.count("a.stl: will be read later") == 1);
  queue.check_next();
  work.checks.back().done(JobOutlook{});
  CHECK(queue.jobs().front().postponed.empty());
  CHECK(queue.jobs().front().check == Check::Passed);
}

TEST_CASE_METHOD(QueueFixture, "A job is not refused because its resin profile is broken") {
  arrive({"a.stl"});
  queue.check_next();
  work.checks[0].done(JobRefusal{"the profile is broken", false, "standard.json: it is broken"});
  CHECK(work.rejections.empty());
  CHECK(log.has("warning: a.stl: standard.json: it is broken"));
  CHECK(queue.jobs().front().check == Check::Passed);
}

TEST_CASE_METHOD(QueueFixture,
                 "The first job does not begin during its check, nor while any job is being refused") {
  arrive({"a.stl", "b.stl"});
  CHECK(queue.first_may_begin());
  queue.check_next();
  CHECK_FALSE(queue.first_may_begin());
  work.checks[0].done(JobOutlook{});
  CHECK(queue.first_may_begin());
  begin_to_refuse("no model");
  CHECK(work.rejections[0].file == "b.stl");
  CHECK_FALSE(queue.first_may_begin());
  work.rejections[0].done({Rejection::Filed, "", "a"});
  CHECK(queue.first_may_begin());
}

TEST_CASE_METHOD(QueueFixture,
                 "A job can be moved to any place, and the order is saved up to its old or new place") {
  arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  reported.clear();
  queue.move("c.stl", 0);
  CHECK(order() == Names{"c.stl", "a.stl", "b.stl", "d.stl"});
  CHECK(work.saved.back() == Names{"c.stl", "a.stl", "b.stl"});
  CHECK(reported == Names{"changed"});
  CHECK(log.has("info: c.stl: number 1 in the queue now"));
  work.save_done("");
  queue.move("a.stl", 99);
  CHECK(order() == Names{"c.stl", "b.stl", "d.stl", "a.stl"});
  CHECK(work.saved.back() == order());
  work.save_done("");
  queue.move("b.stl", 2);
  CHECK(order() == Names{"c.stl", "d.stl", "b.stl", "a.stl"});
  CHECK(work.saved.back() == order());
}

TEST_CASE_METHOD(QueueFixture, "Moving a job to its own place changes nothing") {
  arrive({"a.stl", "b.stl"});
  reported.clear();
  queue.move("b.stl", 1);
  CHECK(work.saved.empty());
  CHECK(reported.empty());
}

TEST_CASE_METHOD(QueueFixture, "The order is saved one write at a time, and the latest one is written last") {
  arrive({"a.stl", "b.stl", "c.stl"});
  queue.move("c.stl", 0);
  queue.move("b.stl", 0);
  queue.move("a.stl", 0);
  CHECK(work.saved.size() == 1);
  work.save_done("");
  REQUIRE(work.saved.size() == 2);
  CHECK(work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  work.save_done("");
  CHECK(work.saved.size() == 2);
}

TEST_CASE_METHOD(QueueFixture, "A job that has left the queue is removed from the saved order") {
  arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  queue.move("d.stl", 0);
  work.save_done("");
  SECTION("claimed") {
    const WaitingJob job = queue.take_first();
    CHECK(work.saved.size() == 1);
    queue.begun(job);
    CHECK(work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("put last") {
    queue.put_last(queue.take_first());
    CHECK(work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("removed") {
    queue.withdrawn("b.stl");
    CHECK(work.saved.back() == Names{"d.stl", "a.stl", "c.stl"});
  }
  SECTION("refused") {
    queue.refuse_first("no");
    work.rejections.back().done({Rejection::Filed, "", "a"});
    CHECK(work.saved.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
}

TEST_CASE_METHOD(QueueFixture, "A job that could not be claimed keeps its place") {
  arrive({"a.stl", "b.stl"});
  queue.move("b.stl", 0);
  queue.put_first(queue.take_first());
  CHECK(order() == Names{"b.stl", "a.stl"});
  CHECK(work.saved.size() == 1);
}

TEST_CASE_METHOD(
    QueueFixture,
    "After a restart jobs have their saved places, in whatever order they arrive, and new ones come last") {
  queue.load_order({"c.stl", "gone.stl", "a.stl", "b.stl"});
  arrive({"a.stl", "new.stl", "b.stl", "c.stl"});
  CHECK(order() == Names{"c.stl", "a.stl", "b.stl", "new.stl"});
  CHECK(log.has("info: c.stl: arrived, number 1 in the queue"));
  CHECK(work.saved.empty());
  queue.move("new.stl", 1);
  CHECK(order() == Names{"c.stl", "new.stl", "a.stl", "b.stl"});
  CHECK(work.saved.back() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
  queue.arrived("gone.stl");
  CHECK(order() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
}

TEST_CASE_METHOD(QueueFixture, "A failure to save the order is logged once, and the next order is tried") {
  arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i) {
    queue.move("b.stl", i == 1 ? 1 : 0);
    work.save_done("no room");
  }
  CHECK(work.saved.size() == 3);
  CHECK(log.count("warning: cannot save the order of the queue; a restart will lose it: no room") == 1);
}

TEST_CASE_METHOD(
    QueueFixture,
    "A removed job goes to failed/ with its reason and without an error, and no job begins until then") {
  arrive({"a.stl", "b.stl"});
  queue.check_next();
  reported.clear();
  queue.remove("a.stl", "removed by me");
  CHECK(work.forgotten == Names{"a.stl"});
  CHECK(order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(queue.first_may_begin());
  work.checks[0].done(JobRefusal{"no model"});  // ignored
  REQUIRE(work.rejections.size() == 1);
  CHECK(work.rejections[0].reason == "removed by me");
  reported.clear();
  work.rejections[0].done({Rejection::Filed, "", "a"});
  CHECK(order() == Names{"b.stl"});
  CHECK(reported == Names{"a cancelled: removed by me", "changed"});
  CHECK(log.has("info: a.stl: removed by me"));
}

TEST_CASE_METHOD(QueueFixture, "A job that is being rewritten is not removed, and the log says so") {
  arrive({"a.stl"});
  queue.remove("a.stl", "removed by me");
  queue.arrived("a.stl");
  work.rejections[0].done({Rejection::Unfinished, "", "a"});
  CHECK(order() == Names{"a.stl"});
  CHECK(queue.jobs().front().check == Check::Wanted);
  CHECK(log.has("warning: a.stl: stays in the queue, because it is being rewritten"));
}

TEST_CASE_METHOD(QueueFixture, "The result of a check is valid until the file is rewritten") {
  arrive({"a.stl"});
  queue.check_next();
  work.checks[0].done(JobOutlook{.layers = 7});
  REQUIRE(queue.jobs().front().outlook);
  CHECK(queue.jobs().front().outlook->layers == 7);
  queue.arrived("a.stl");
  CHECK_FALSE(queue.jobs().front().outlook);
}

TEST_CASE_METHOD(QueueFixture, "Without ask_before no job is analyzed") {
  arrive({"a.stl"});
  CHECK_FALSE(queue.questions().wanted());
  CHECK(queue.first_unanalyzed().empty());
  CHECK(queue.questions().knows(std::nullopt, "", std::nullopt));
}

TEST_CASE_METHOD(AskingQueueFixture,
                 "Jobs are analyzed one at a time after all checks, and only the next one is kept") {
  work.check_result.reset();
  arrive({"a.stl"});
  queue.check_next();
  CHECK(work.analyses.empty());
  work.check_result = JobOutlook{};
  arrive({"b.stl", "c.stl"});
  CHECK(work.analyses.empty());  // the check of a.stl has not ended
  queue.arrived("a.stl");
  queue.check_next();
  for (int i = 0; i < 3; ++i)
    queue.check_next();
  REQUIRE(work.analyses.size() == 1);
  CHECK(work.analyses[0].file == "a.stl");
  CHECK(work.analyses[0].keep == Keep::Prepared);
  CHECK(queue.first_unanalyzed() == "its layers must be analyzed first, as ask_before requires");
  find({});
  CHECK(queue.first_unanalyzed().empty());
  queue.check_next();
  REQUIRE(work.analyses.size() == 2);
  CHECK(work.analyses[1].file == "b.stl");
  CHECK(work.analyses[1].keep == Keep::Nothing);
}

TEST_CASE_METHOD(AskingQueueFixture, "A job that waits for confirmation is skipped and keeps its place") {
  arrive({"a.stl", "b.stl"});
  analyze({{"islands", "empty_layers"}, {}});
  CHECK(queue.jobs()[0].asks == Names{"islands"});
  CHECK(log.has("warning: a.stl waits: islands; run \"contourctl accept a\" to print it anyway"));
  CHECK(log.has("warning: a.stl: it has islands"));
  REQUIRE(queue.has_first());
  CHECK(queue.first() == 1);
  WaitingJob next = queue.take_first();
  CHECK(next.file == "b.stl");
  CHECK_FALSE(queue.has_first());
  queue.put_first(std::move(next));
  REQUIRE(queue.jobs().size() == 2);
  CHECK(queue.jobs()[0].file == "a.stl");
  CHECK(queue.jobs()[1].file == "b.stl");
}

TEST_CASE_METHOD(AskingQueueFixture,
                 "An accepted job is the next one again, and the log says who accepted it") {
  arrive({"a.stl", "b.stl"});
  analyze({{"islands"}, {}});
  queue.accept("a.stl", "user me");
  CHECK(queue.first() == 0);
  CHECK(observer.question_changes == 2);  // the question, then its acceptance
  CHECK(log.has("info: a.stl: accepted by user me with islands"));
  CHECK(work.saved == std::vector<Names>{{"1 islands"}});
}

TEST_CASE_METHOD(
    AskingQueueFixture,
    "An accepted finding needs no second confirmation for the same content, but one for other content") {
  queue.questions().load_accepted({"a1 islands"});
  arrive({"a.stl", "b.stl", "c.stl"});
  find({"islands"}, "a1");
  CHECK(queue.jobs()[0].asks.empty());
  queue.check_next();
  find({"islands"}, "b1");
  CHECK(queue.jobs()[1].asks == Names{"islands"});
  queue.check_next();
  find({"islands", "cracks"}, "a1");
  CHECK(queue.jobs()[2].asks == Names{"cracks"});
}

TEST_CASE_METHOD(AskingQueueFixture, "A checked job with places that cannot be held waits for confirmation") {
  JobOutlook outlook;
  outlook.question =
      AnalyzedJob{{.resin_ml = {}, .findings = {"unheld_places"}, .warnings = {"1 place"}}, "a1", {}};
  work.check_result = outlook;
  SECTION("without ask_before") {
    config.ask_before.clear();
    arrive({"a.stl"});
    CHECK_FALSE(queue.has_first());
    CHECK(queue.jobs()[0].asks == Names{"unheld_places"});
    CHECK(log.has("warning: a.stl waits: unheld places; run \"contourctl accept a\""));
    CHECK(log.has("warning: a.stl: 1 place"));
    queue.accept("a.stl", "user me");
    CHECK(queue.has_first());
    CHECK(queue.questions().has_accepted(queue.jobs()[0].analyzed, "unheld_places"));
  }
  SECTION("with ask_before, after its analysis") {
    arrive({"a.stl"});
    CHECK(queue.has_first());
    find({"unheld_places"});
    CHECK_FALSE(queue.has_first());
  }
}

TEST_CASE_METHOD(AskingQueueFixture, "Acceptances are forgotten when the job ends, not when it begins") {
  arrive({"a.stl"});
  find({"islands"}, "a1");
  queue.accept("a.stl", "user me");
  queue.questions().begun(queue.take_first().analyzed);
  CHECK(work.saved.back() == Names{"a1 islands"});
  queue.questions().ended();
  CHECK(work.saved.back().empty());
}

TEST_CASE_METHOD(
    AskingQueueFixture,
    "A job that is rewritten during its analysis, or while it waits for confirmation, is analyzed again") {
  arrive({"a.stl"});
  const auto late = work.analyses[0].done;
  queue.arrived("a.stl");
  late(AnalyzedJob{});
  CHECK_FALSE(queue.jobs()[0].analyzed);
  queue.check_next();
  queue.check_next();
  REQUIRE(work.analyses.size() == 2);
  find({"islands"});
  CHECK_FALSE(queue.has_first());
  queue.arrived("a.stl");
  CHECK(queue.has_first());
  CHECK_FALSE(queue.first_unanalyzed().empty());
}

TEST_CASE_METHOD(AskingQueueFixture,
                 "An analysis that was given up is repeated, and one that finds a mistake refuses the job") {
  arrive({"a.stl"});
  work.analyses[0].done(ReadingGivenUp{});
  queue.check_next();
  REQUIRE(work.analyses.size() == 2);
  work.analyses[1].done(JobRefusal{"no model"});
  REQUIRE(work.rejections.size() == 1);
  CHECK(work.rejections[0].file == "a.stl");
  CHECK(work.rejections[0].reason == "no model");
}

TEST_CASE_METHOD(AskingQueueFixture,
                 "Without enough memory, or with a broken profile, a job is analyzed later") {
  arrive({"a.stl"});
  SECTION("not enough memory") {
    work.analyses[0].done(JobRefusal{"100 MB", true});
    CHECK(queue.jobs()[0].check == Check::Postponed);
    CHECK(queue.first_unanalyzed() == "100 MB");
  }
  SECTION("a broken profile") {
    work.analyses[0].done(JobRefusal{"wrong", false, "the resin profile x cannot be used"});
    CHECK(queue.jobs()[0].analysis == WaitingJob::Analysis::Blocked);
    CHECK(queue.first_unanalyzed() ==
          "the resin profile x cannot be used; the queue continues when the profile is fixed");
  }
  queue.check_next();
  CHECK(work.analyses.size() == 1);
  queue.check_postponed();
  queue.check_next();
  queue.check_next();
  REQUIRE(work.analyses.size() == 2);
  find({});
  CHECK(queue.first_unanalyzed().empty());
}

TEST_CASE_METHOD(AskingQueueFixture, "A job that is removed during its analysis asks for no confirmation") {
  arrive({"a.stl"});
  queue.remove("a.stl", "removed by me");
  find({"islands"});
  CHECK(queue.jobs()[0].check == Check::Refused);
  CHECK(queue.jobs()[0].asks.empty());
}

TEST_CASE("The command that accepts a job is valid in a shell for every job name") {
  const auto question = [](const char* file) { return question_about(file, {"cracks"}); };
  CHECK(question("a-1.b.stl") == "cracks; run \"contourctl accept a-1.b\" to print it anyway");
  CHECK(question("two words.stl").find("accept 'two words'\"") != std::string::npos);
  CHECK(question("it's.stl").find(R"(accept 'it'\''s'")") != std::string::npos);
  CHECK(question("-x.stl").find("accept -- -x\"") != std::string::npos);
  CHECK(question("\x1b[2J.stl").find('\x1b') == std::string::npos);
}
