#include "daemon/jobs/print_queue.hpp"

#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using Names = std::vector<std::string>;
using Check = WaitingJob::Check;

namespace {

// A queue whose checks and refusals end when a test says so.
class Desk {
 public:
  struct RunningCheck {
    std::string file;
    JobReader::Keep keep;
    std::function<void(const CheckedJob&)> done;
  };
  struct RunningRejection {
    std::string file, reason;
    Spool::Rejected done;
  };

  void arrive(const Names& files) {
    for (const std::string& file : files)
      queue.arrived(file);
  }
  // Refused by its check; its files are on their way.
  void begin_to_refuse(const std::string& reason) {
    queue.check_next();
    checks.back().done(JobRefusal{reason});
  }
  [[nodiscard]] Names order() const {
    Names files;
    for (const WaitingJob& job : queue.jobs())
      files.push_back(job.file);
    return files;
  }

  EventLoop loop;
  testing::LogText log{loop};
  std::vector<RunningCheck> checks;
  std::vector<RunningRejection> rejections;
  Names forgotten;
  Names told;                                          // "changed", "refused FILE: REASON" or "removed ..."
  std::vector<Names> kept;                             // orders, as the disk was given them
  std::function<void(const std::string&)> order_kept;  // the last of them
  PrintQueue queue{
      log.log,
      {.check =
           [this](const std::string& file, JobReader::Keep keep, auto done) {
             checks.push_back({file, keep, std::move(done)});
           },
       .forget = [this](const std::string& file) { forgotten.push_back(file); },
       .reject =
           [this](const std::string& file, const std::string& reason, Spool::Rejected done) {
             rejections.push_back({file, reason, std::move(done)});
           },
       .changed = [this] { told.emplace_back("changed"); },
       .refused = [this](const std::string& file,
                         const std::string& reason) { told.push_back("refused " + file + ": " + reason); },
       .removed = [this](const std::string& file,
                         const std::string& reason) { told.push_back("removed " + file + ": " + reason); },
       .keep_order =
           [this](const QueueOrder::Names& names, auto done) {
             kept.push_back(names);
             order_kept = std::move(done);
           }}};
};

// The same of a printer whose owner is asked about islands and cracks. What a job is found to have is put
// there by hand.
class AskingDesk {
 public:
  struct RunningAnalysis {
    std::string file;
    JobReader::Keep keep;
    std::function<void(const JobAnalysisOutcome&)> done;
  };

  void arrive(const Names& files) {
    for (const std::string& file : files) {
      queue.arrived(file);
      queue.check_next();
      queue.check_next();
    }
  }
  // The analysis under way ends.
  void find(const Names& findings, const std::string& content = "a1") {
    REQUIRE_FALSE(analyses.empty());
    PreprintAnalysis analysis;
    analysis.findings = findings;
    for (const std::string& each : findings)
      analysis.warnings.push_back("it has " + each);
    analyses.back().done(AnalyzedJob{analysis, content, {}});
  }
  // Each in its turn; in the queue's order.
  void look_through(const std::vector<Names>& findings) {
    for (const Names& each : findings) {
      queue.check_next();
      find(each, std::to_string(analyses.size()));
    }
  }

  // Of a printer whose file names no finding, where a check finds this.
  [[nodiscard]] PrintQueue::Calls calls_without_analysis(const JobOutlook& outlook) {
    PrintQueue::Calls calls{
        .check = [outlook](const std::string&, JobReader::Keep, const auto& done) { done(outlook); },
        .forget = [](const std::string&) {},
        .reject = [](const std::string&, const std::string&, const Spool::Rejected&) {},
        .changed = [] {},
        .refused = [](const std::string&, const std::string&) {},
        .removed = [](const std::string&, const std::string&) {},
        .keep_order = [](const QueueOrder::Names&, const auto&) {}};
    calls.questions.asked = [](const PreprintAnalysis& analysis) { return analysis.findings; };
    calls.questions.keep_accepted = [](const Acceptances::Lines&, const auto& done) { done(""); };
    calls.questions.changed = [] {};
    return calls;
  }

  EventLoop loop;
  testing::LogText log{loop};
  std::vector<RunningAnalysis> analyses;
  std::vector<Acceptances::Lines> kept;
  Names refused;
  bool check_ends = true;
  int questions_told = 0;
  PrintQueue queue{log.log,
                   {.check =
                        [this](const std::string&, JobReader::Keep, const auto& done) {
                          if (check_ends) done(JobOutlook{});
                        },
                    .forget = [](const std::string&) {},
                    .reject = [this](const std::string& file, const std::string& reason,
                                     const Spool::Rejected&) { refused.push_back(file + ": " + reason); },
                    .changed = [] {},
                    .refused = [](const std::string&, const std::string&) {},
                    .removed = [](const std::string&, const std::string&) {},
                    .keep_order = [](const QueueOrder::Names&, const auto&) {},
                    .questions = {.analyze =
                                      [this](const std::string& file, JobReader::Keep keep, auto done) {
                                        analyses.push_back({file, keep, std::move(done)});
                                      },
                                  .asked =
                                      [](const PreprintAnalysis& analysis) {
                                        Names asked = analysis.findings;
                                        std::erase(asked, "empty_layers");
                                        return asked;
                                      },
                                  .keep_accepted =
                                      [this](const Acceptances::Lines& lines, const auto& done) {
                                        kept.push_back(lines);
                                        done("");
                                      },
                                  .changed = [this] { ++questions_told; }}}};
};

}  // namespace

TEST_CASE("Jobs wait in the order of their arrival, and the first is the next") {
  Desk desk;
  desk.arrive({"b.stl", "a.stl", "c.stl"});
  CHECK(desk.order() == Names{"b.stl", "a.stl", "c.stl"});
  CHECK(desk.log.has("info: c.stl: arrived, number 3 in the queue"));
  CHECK(desk.told == Names{"changed", "changed", "changed"});
  CHECK(desk.queue.take_first().file == "b.stl");
  CHECK(desk.order() == Names{"a.stl", "c.stl"});
}

TEST_CASE("A check that was given up is made again") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.checks[0].done(ReadingGivenUp{});
  CHECK(desk.queue.jobs().front().check == Check::Wanted);
  desk.queue.check_next();
  CHECK(desk.checks.size() == 2);
}

TEST_CASE("A job that is written again keeps its place, and is checked again") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.queue.check_next();
  desk.checks[0].done(JobOutlook{});
  REQUIRE(desk.queue.jobs().front().check == Check::Passed);
  desk.queue.arrived("a.stl");
  CHECK(desk.order() == Names{"a.stl", "b.stl"});
  CHECK(desk.queue.jobs().front().check == Check::Wanted);
  CHECK(desk.log.count("a.stl: arrived") == 1);
}

TEST_CASE("A job that is written again and again while it is read lets the others go first") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl", "c.stl"});
  const auto interrupt = [&](int times) {
    for (int i = 0; i < times; ++i) {
      desk.queue.check_next();
      REQUIRE(desk.checks.back().file == "a.stl");
      desk.queue.arrived("a.stl");
      // What was written while nobody read it has kept nobody waiting.
      desk.queue.arrived("a.stl");
    }
  };
  interrupt(3);
  CHECK(desk.order() == Names{"a.stl", "b.stl", "c.stl"});
  interrupt(1);
  CHECK(desk.order() == Names{"b.stl", "c.stl", "a.stl"});
  CHECK(desk.log.count("a.stl: is written again and again while it is read; the others go first") == 1);
  desk.queue.check_next();
  CHECK(desk.checks.back().file == "b.stl");
  // Nor does it wait in vain, once they are through.
  CHECK(desk.queue.take_first().file == "b.stl");
  CHECK(desk.queue.take_first().file == "c.stl");
  interrupt(2);
  CHECK(desk.order() == Names{"a.stl"});
  CHECK(desk.log.count("the others go first") == 1);
}

TEST_CASE("A job that is written again waits anew, and what was told of it is not told again") {
  Desk desk;
  desk.arrive({"a.stl"});
  WaitingJob job = desk.queue.take_first();
  job.trouble = "it cannot be claimed";
  job.waited = true;
  desk.queue.put_first(std::move(job));
  desk.queue.arrived("a.stl");
  CHECK(desk.queue.jobs().front().trouble == "it cannot be claimed");
  CHECK_FALSE(desk.queue.jobs().front().waited);
}

TEST_CASE("Each job is checked once, one call after the other, the first that was not checked first") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i)
    desk.queue.check_next();
  REQUIRE(desk.checks.size() == 2);
  CHECK(desk.checks[0].file == "a.stl");
  CHECK(desk.checks[1].file == "b.stl");
}

TEST_CASE("What the check of the next job has prepared is kept, and of no other") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.queue.check_next();
  desk.queue.check_next();
  REQUIRE(desk.checks.size() == 2);
  CHECK(desk.checks[0].keep == JobReader::Keep::Prepared);
  CHECK(desk.checks[1].keep == JobReader::Keep::Nothing);
}

TEST_CASE("A job that is written again, taken away or put last is not kept") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  CHECK(desk.forgotten.empty());
  desk.queue.arrived("a.stl");
  CHECK(desk.forgotten == Names{"a.stl"});
  desk.queue.put_last(desk.queue.take_first());
  CHECK(desk.forgotten == Names{"a.stl", "a.stl"});
  desk.queue.withdrawn("b.stl");
  CHECK(desk.forgotten == Names{"a.stl", "a.stl", "b.stl"});
}

TEST_CASE("What a check finds in a file that was written again meanwhile counts for nothing") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.queue.arrived("a.stl");
  desk.checks[0].done(JobRefusal{"no model"});
  CHECK(desk.rejections.empty());
  CHECK(desk.queue.jobs().front().check == Check::Wanted);
}

TEST_CASE("What a check finds in a file counts for nothing when the new one is being checked already") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.queue.arrived("a.stl");
  desk.queue.check_next();
  REQUIRE(desk.checks.size() == 2);
  desk.checks[0].done(JobRefusal{"no model"});
  CHECK(desk.rejections.empty());
  CHECK(desk.queue.jobs().front().check == Check::Running);
  desk.checks[1].done(JobOutlook{});
  CHECK(desk.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("What a check finds in a job that is gone counts for nothing") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.queue.withdrawn("a.stl");
  desk.told.clear();
  desk.checks[0].done(JobRefusal{"no model"});
  CHECK(desk.rejections.empty());
  CHECK(desk.told == Names{"changed"});
}

TEST_CASE("A job that its owner takes away leaves the queue, and another file's going is nothing to it") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.told.clear();
  desk.queue.withdrawn("c.stl");
  CHECK(desk.told.empty());
  desk.queue.withdrawn("a.stl");
  CHECK(desk.order() == Names{"b.stl"});
  CHECK(desk.log.has("info: a.stl: taken away by the owner"));
  CHECK(desk.told == Names{"changed"});
}

TEST_CASE("A refused job stays until its files are in failed/, then it is told before the queue goes on") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.begin_to_refuse("no model");
  REQUIRE(desk.rejections.size() == 1);
  CHECK(desk.rejections[0].reason == "no model\n");
  CHECK(desk.order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(desk.log.has("no model"));
  desk.told.clear();
  desk.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(desk.order() == Names{"b.stl"});
  CHECK(desk.told == Names{"refused a.stl: no model", "changed"});
  CHECK(desk.log.has("error: a.stl: no model"));
}

TEST_CASE("What the spool takes away as it refuses it was not taken away by its owner") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.begin_to_refuse("no model");
  desk.queue.withdrawn("a.stl");
  CHECK(desk.order() == Names{"a.stl"});
  desk.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(desk.order().empty());
  CHECK_FALSE(desk.log.has("taken away"));
}

TEST_CASE("What its owner takes away while it is refused leaves the queue") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.begin_to_refuse("no model");
  desk.queue.withdrawn("a.stl");
  desk.told.clear();
  desk.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(desk.order() == Names{"b.stl"});
  CHECK(desk.log.has("a.stl: taken away by the owner"));
  CHECK(desk.told == Names{"changed"});
}

TEST_CASE("What its owner writes anew while it is refused keeps its place") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.begin_to_refuse("no model");
  desk.told.clear();
  desk.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(desk.order() == Names{"a.stl", "b.stl"});
  CHECK(desk.told == Names{"changed"});
  CHECK_FALSE(desk.log.has("no model"));
}

TEST_CASE("What is seen again while it is refused went to failed, or was written anew") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.begin_to_refuse("no model");
  desk.queue.arrived("a.stl");
  SECTION("it went, and its owner did not take it") {
    desk.queue.withdrawn("a.stl");
    desk.rejections[0].done(Spool::Rejection::Filed, "");
    CHECK(desk.order().empty());
    CHECK_FALSE(desk.log.has("taken away"));
  }
  SECTION("it is new, and is checked") {
    desk.rejections[0].done(Spool::Rejection::Unfinished, "");
    desk.queue.check_next();
    CHECK(desk.checks.size() == 2);
  }
  SECTION("its owner took it away before") {
    desk.queue.withdrawn("a.stl");
    desk.queue.arrived("a.stl");
    desk.rejections[0].done(Spool::Rejection::Unfinished, "");
    CHECK(desk.order() == Names{"a.stl"});
    CHECK_FALSE(desk.log.has("taken away"));
  }
}

TEST_CASE("What arrives behind a refusal is a job of its own") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.begin_to_refuse("no model");
  desk.rejections[0].done(Spool::Rejection::Filed, "");
  desk.queue.arrived("a.stl");
  CHECK(desk.order() == Names{"a.stl"});
  CHECK(desk.queue.first_may_begin());
}

TEST_CASE("A refused job whose files cannot be moved leaves the queue, and that is told") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.begin_to_refuse("no model");
  SECTION("they may be deleted") {
    desk.rejections[0].done(Spool::Rejection::LeftThere, "");
    CHECK(desk.log.has("warning: a.stl: stays in incoming, because it cannot be moved; it may be deleted"));
  }
  SECTION("nobody knows what becomes of them") {
    desk.rejections[0].done(Spool::Rejection::Impossible, "no room");
    CHECK(desk.log.has("error: a.stl: cannot be moved to failed: no room"));
  }
  CHECK(desk.order().empty());
}

TEST_CASE("A job for which there is no room is told once, and read again when there may be") {
  Desk desk;
  desk.arrive({"a.stl"});
  for (const char* why : {"it takes 900 MB", "it takes 901 MB"}) {
    desk.queue.check_next();
    desk.checks.back().done(JobRefusal{why, true});
    CHECK(desk.queue.jobs().front().postponed == why);
    desk.queue.check_next();  // it is not wanted by itself
    desk.queue.check_postponed();
  }
  CHECK(desk.checks.size() == 2);
  CHECK(desk.log.count("a.stl: is read later") == 1);
  desk.queue.check_next();
  desk.checks.back().done(JobOutlook{});
  CHECK(desk.queue.jobs().front().postponed.empty());
  CHECK(desk.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("A broken profile is no reason to refuse the job that names it") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.checks[0].done(JobRefusal{"the profile is broken", false, "standard.json: it is broken"});
  CHECK(desk.rejections.empty());
  CHECK(desk.log.has("warning: a.stl: standard.json: it is broken"));
  CHECK(desk.queue.jobs().front().check == Check::Passed);
}

TEST_CASE("The first job does not begin while it is being checked, nor while any is being refused") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  CHECK(desk.queue.first_may_begin());
  desk.queue.check_next();
  CHECK_FALSE(desk.queue.first_may_begin());
  desk.checks[0].done(JobOutlook{});
  CHECK(desk.queue.first_may_begin());
  desk.begin_to_refuse("no model");
  CHECK(desk.rejections[0].file == "b.stl");
  CHECK_FALSE(desk.queue.first_may_begin());
  desk.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(desk.queue.first_may_begin());
}

TEST_CASE("A job can be moved to any place, and the order is kept down to where it was or is") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  desk.told.clear();
  desk.queue.move("c.stl", 0);
  CHECK(desk.order() == Names{"c.stl", "a.stl", "b.stl", "d.stl"});
  CHECK(desk.kept.back() == Names{"c.stl", "a.stl", "b.stl"});
  CHECK(desk.told == Names{"changed"});
  CHECK(desk.log.has("info: c.stl: number 1 in the queue now"));
  desk.order_kept("");
  desk.queue.move("a.stl", 99);
  CHECK(desk.order() == Names{"c.stl", "b.stl", "d.stl", "a.stl"});
  CHECK(desk.kept.back() == desk.order());
  desk.order_kept("");
  desk.queue.move("b.stl", 2);
  CHECK(desk.order() == Names{"c.stl", "d.stl", "b.stl", "a.stl"});
  CHECK(desk.kept.back() == desk.order());
}

TEST_CASE("A job that is moved to where it is changes nothing") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.told.clear();
  desk.queue.move("b.stl", 1);
  CHECK(desk.kept.empty());
  CHECK(desk.told.empty());
}

TEST_CASE("The order is written once at a time, the latest of it") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl", "c.stl"});
  desk.queue.move("c.stl", 0);
  desk.queue.move("b.stl", 0);
  desk.queue.move("a.stl", 0);
  CHECK(desk.kept.size() == 1);
  desk.order_kept("");
  REQUIRE(desk.kept.size() == 2);
  CHECK(desk.kept.back() == Names{"a.stl", "b.stl", "c.stl"});
  desk.order_kept("");
  CHECK(desk.kept.size() == 2);
}

TEST_CASE("What has left the queue is not in its order any more") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl", "c.stl", "d.stl"});
  desk.queue.move("d.stl", 0);
  desk.order_kept("");
  SECTION("claimed") {
    const WaitingJob job = desk.queue.take_first();
    CHECK(desk.kept.size() == 1);
    desk.queue.claimed(job.file);
    CHECK(desk.kept.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("put last") {
    desk.queue.put_last(desk.queue.take_first());
    CHECK(desk.kept.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
  SECTION("taken away") {
    desk.queue.withdrawn("b.stl");
    CHECK(desk.kept.back() == Names{"d.stl", "a.stl", "c.stl"});
  }
  SECTION("refused") {
    desk.queue.refuse_first("no");
    desk.rejections.back().done(Spool::Rejection::Filed, "");
    CHECK(desk.kept.back() == Names{"a.stl", "b.stl", "c.stl"});
  }
}

TEST_CASE("A job that could not be claimed has kept its place") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.queue.move("b.stl", 0);
  desk.queue.put_first(desk.queue.take_first());
  CHECK(desk.order() == Names{"b.stl", "a.stl"});
  CHECK(desk.kept.size() == 1);
}

TEST_CASE("After a restart jobs have their places, in whatever order they are seen, and new ones come last") {
  Desk desk;
  desk.queue.load_order({"c.stl", "gone.stl", "a.stl", "b.stl"});
  desk.arrive({"a.stl", "new.stl", "b.stl", "c.stl"});
  CHECK(desk.order() == Names{"c.stl", "a.stl", "b.stl", "new.stl"});
  CHECK(desk.log.has("info: c.stl: arrived, number 1 in the queue"));
  CHECK(desk.kept.empty());
  desk.queue.move("new.stl", 1);
  CHECK(desk.order() == Names{"c.stl", "new.stl", "a.stl", "b.stl"});
  CHECK(desk.kept.back() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
  desk.queue.arrived("gone.stl");
  CHECK(desk.order() == Names{"c.stl", "gone.stl", "new.stl", "a.stl", "b.stl"});
}

TEST_CASE("An order that the disk does not take is told once, and the next one is tried") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  for (int i = 0; i < 3; ++i) {
    desk.queue.move("b.stl", i == 1 ? 1 : 0);
    desk.order_kept("no room");
  }
  CHECK(desk.kept.size() == 3);
  CHECK(desk.log.count("warning: the queue's order will be lost with a restart: no room") == 1);
}

TEST_CASE(
    "A removed job is filed with its reason, is no mistake, and keeps the next from beginning until then") {
  Desk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.queue.check_next();
  desk.told.clear();
  desk.queue.remove("a.stl", "removed by me");
  CHECK(desk.forgotten == Names{"a.stl"});
  CHECK(desk.order() == Names{"a.stl", "b.stl"});
  CHECK_FALSE(desk.queue.first_may_begin());
  desk.checks[0].done(JobRefusal{"no model"});  // of nobody's interest any more
  REQUIRE(desk.rejections.size() == 1);
  CHECK(desk.rejections[0].reason == "removed by me\n");
  desk.told.clear();
  desk.rejections[0].done(Spool::Rejection::Filed, "");
  CHECK(desk.order() == Names{"b.stl"});
  CHECK(desk.told == Names{"removed a.stl: removed by me", "changed"});
  CHECK(desk.log.has("info: a.stl: removed by me"));
}

TEST_CASE("A job that somebody writes anew is not removed, and that is told") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.remove("a.stl", "removed by me");
  desk.queue.arrived("a.stl");
  desk.rejections[0].done(Spool::Rejection::Unfinished, "");
  CHECK(desk.order() == Names{"a.stl"});
  CHECK(desk.queue.jobs().front().check == Check::Wanted);
  CHECK(desk.log.has("warning: a.stl: stays in the queue, because somebody is writing it anew"));
}

TEST_CASE("What a check has found counts until the file is written again") {
  Desk desk;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  desk.checks[0].done(JobOutlook{.layers = 7});
  REQUIRE(desk.queue.jobs().front().outlook);
  CHECK(desk.queue.jobs().front().outlook->layers == 7);
  desk.queue.arrived("a.stl");
  CHECK_FALSE(desk.queue.jobs().front().outlook);
}

TEST_CASE("Where nobody is to be asked, no job is looked through") {
  Desk desk;
  desk.arrive({"a.stl"});
  CHECK_FALSE(desk.queue.questions().wanted());
  CHECK(desk.queue.first_unanalyzed().empty());
  CHECK(desk.queue.questions().knows(std::nullopt, {}, std::nullopt));
}

TEST_CASE("Jobs are looked through one after the other, behind all checks, and the next one is kept") {
  AskingDesk desk;
  desk.check_ends = false;
  desk.arrive({"a.stl"});
  desk.queue.check_next();
  CHECK(desk.analyses.empty());
  desk.check_ends = true;
  desk.arrive({"b.stl", "c.stl"});
  CHECK(desk.analyses.empty());  // the first's check has not ended
  desk.queue.arrived("a.stl");
  desk.queue.check_next();
  for (int i = 0; i < 3; ++i)
    desk.queue.check_next();
  REQUIRE(desk.analyses.size() == 1);
  CHECK(desk.analyses[0].file == "a.stl");
  CHECK(desk.analyses[0].keep == JobReader::Keep::Prepared);
  CHECK(desk.queue.first_unanalyzed() == "its layers are looked through first, as ask_before demands");
  desk.find({});
  CHECK(desk.queue.first_unanalyzed().empty());
  desk.queue.check_next();
  REQUIRE(desk.analyses.size() == 2);
  CHECK(desk.analyses[1].file == "b.stl");
  CHECK(desk.analyses[1].keep == JobReader::Keep::Nothing);
}

TEST_CASE("A job that asks is ignored and keeps its place") {
  AskingDesk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.look_through({{"islands", "empty_layers"}, {}});
  CHECK(desk.queue.jobs()[0].asks == Names{"islands"});
  CHECK(desk.log.has("warning: a.stl waits: islands; \"contourctl accept a\" has it printed as it is"));
  CHECK(desk.log.has("warning: a.stl: it has islands"));
  REQUIRE(desk.queue.has_first());
  CHECK(desk.queue.first() == 1);
  WaitingJob next = desk.queue.take_first();
  CHECK(next.file == "b.stl");
  CHECK_FALSE(desk.queue.has_first());
  desk.queue.put_first(std::move(next));
  REQUIRE(desk.queue.jobs().size() == 2);
  CHECK(desk.queue.jobs()[0].file == "a.stl");
  CHECK(desk.queue.jobs()[1].file == "b.stl");
}

TEST_CASE("An accepted job is the next one again, and is in the log with who accepted it") {
  AskingDesk desk;
  desk.arrive({"a.stl", "b.stl"});
  desk.look_through({{"islands"}, {}});
  desk.queue.accept("a.stl", "user me");
  CHECK(desk.queue.first() == 0);
  CHECK(desk.questions_told == 2);  // it asks, it was accepted
  CHECK(desk.log.has("info: a.stl: user me accepts it with islands"));
  CHECK(desk.kept == std::vector<Acceptances::Lines>{{"1 islands"}});
}

TEST_CASE("What was accepted needs no second word from these files, and one from others") {
  AskingDesk desk;
  desk.queue.questions().load_accepted({"a1 islands"});
  desk.arrive({"a.stl", "b.stl", "c.stl"});
  desk.find({"islands"}, "a1");
  CHECK(desk.queue.jobs()[0].asks.empty());
  desk.queue.check_next();
  desk.find({"islands"}, "b1");
  CHECK(desk.queue.jobs()[1].asks == Names{"islands"});
  desk.queue.check_next();
  desk.find({"islands", "cracks"}, "a1");
  CHECK(desk.queue.jobs()[2].asks == Names{"cracks"});
}

TEST_CASE("A job that was checked and has places that cannot be held waits for its owner") {
  AskingDesk desk;
  JobOutlook outlook;
  outlook.question =
      AnalyzedJob{{.resin_ml = {}, .findings = {"unheld_places"}, .warnings = {"1 place"}}, "a1", {}};
  SECTION("where nothing else is asked about") {
    PrintQueue queue(desk.log.log, desk.calls_without_analysis(outlook));
    queue.arrived("a.stl");
    queue.check_next();
    CHECK_FALSE(queue.has_first());
    CHECK(queue.jobs()[0].asks == Names{"unheld_places"});
    CHECK(desk.log.has("warning: a.stl waits: unheld places; \"contourctl accept a\""));
    CHECK(desk.log.has("warning: a.stl: 1 place"));
    queue.accept("a.stl", "user me");
    CHECK(queue.has_first());
    CHECK(queue.questions().has_accepted(queue.jobs()[0].analyzed, "unheld_places"));
  }
  SECTION("where its layers are looked through, by what that finds") {
    desk.arrive({"a.stl"});
    CHECK(desk.queue.has_first());
    desk.find({"unheld_places"});
    CHECK_FALSE(desk.queue.has_first());
  }
}

TEST_CASE("What was accepted is forgotten when the job has ended, and not when it only begins") {
  AskingDesk desk;
  desk.arrive({"a.stl"});
  desk.find({"islands"}, "a1");
  desk.queue.accept("a.stl", "user me");
  desk.queue.questions().begun(desk.queue.take_first().analyzed);
  CHECK(desk.kept.back() == Acceptances::Lines{"a1 islands"});
  desk.queue.questions().ended();
  CHECK(desk.kept.back().empty());
}

TEST_CASE("A job that is written again while it asks, or is looked through, is looked through again") {
  AskingDesk desk;
  desk.arrive({"a.stl"});
  const auto late = desk.analyses[0].done;
  desk.queue.arrived("a.stl");
  late(AnalyzedJob{});
  CHECK_FALSE(desk.queue.jobs()[0].analyzed);
  desk.queue.check_next();
  desk.queue.check_next();
  REQUIRE(desk.analyses.size() == 2);
  desk.find({"islands"});
  CHECK_FALSE(desk.queue.has_first());
  desk.queue.arrived("a.stl");
  CHECK(desk.queue.has_first());
  CHECK_FALSE(desk.queue.first_unanalyzed().empty());
}

TEST_CASE("A analysis that was given up is made again, and one that finds a mistake refuses the job") {
  AskingDesk desk;
  desk.arrive({"a.stl"});
  desk.analyses[0].done(ReadingGivenUp{});
  desk.queue.check_next();
  REQUIRE(desk.analyses.size() == 2);
  desk.analyses[1].done(JobRefusal{"no model"});
  CHECK(desk.refused == Names{"a.stl: no model\n"});
}

TEST_CASE("Without room in memory, or with a broken profile, a job is looked through later") {
  AskingDesk desk;
  desk.arrive({"a.stl"});
  SECTION("no room") {
    desk.analyses[0].done(JobRefusal{"100 MB", true});
    CHECK(desk.queue.jobs()[0].check == Check::Postponed);
    CHECK(desk.queue.first_unanalyzed() == "100 MB");
  }
  SECTION("a broken profile") {
    desk.analyses[0].done(JobRefusal{"wrong", false, "the resin profile x cannot be used"});
    CHECK(desk.queue.jobs()[0].analysis == WaitingJob::Analysis::Blocked);
    CHECK(desk.queue.first_unanalyzed() ==
          "the resin profile x cannot be used; the queue goes on when it is mended");
  }
  desk.queue.check_next();
  CHECK(desk.analyses.size() == 1);
  desk.queue.check_postponed();
  desk.queue.check_next();
  desk.queue.check_next();
  REQUIRE(desk.analyses.size() == 2);
  desk.find({});
  CHECK(desk.queue.first_unanalyzed().empty());
}

TEST_CASE("A removed job that asks is filed, whatever its analysis says later") {
  AskingDesk desk;
  desk.arrive({"a.stl"});
  desk.queue.remove("a.stl", "removed by me");
  desk.find({"islands"});
  CHECK(desk.queue.jobs()[0].check == Check::Refused);
  CHECK(desk.queue.jobs()[0].asks.empty());
}

TEST_CASE("The command that accepts a job is one for a shell, whatever the job is called") {
  const auto question = [](const char* file) { return question_about(file, {"cracks"}); };
  CHECK(question("a-1.b.stl") == "cracks; \"contourctl accept a-1.b\" has it printed as it is");
  CHECK(question("two words.stl").find("accept 'two words'\"") != std::string::npos);
  CHECK(question("it's.stl").find(R"(accept 'it'\''s'")") != std::string::npos);
  CHECK(question("-x.stl").find("accept -- -x\"") != std::string::npos);
  CHECK(question("\x1b[2J.stl").find('\x1b') == std::string::npos);
}
