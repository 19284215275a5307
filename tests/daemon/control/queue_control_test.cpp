#include "daemon/control/queue_control.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"

using namespace contourd;
using Json = QueueControl::Json;
using Names = std::vector<std::string>;

namespace {

class QueueControlFixture : public testing::CurrentJobFixture {
 public:
  explicit QueueControlFixture(const Names& files = {}, bool asks = false) : asking(asks) {
    for (const std::string& file : files)
      queue.arrived(file);
  }
  Json call(const std::string& method, const Json& parameters = Json::object()) {
    const ControlMethod& called = methods.at(method);
    return called.call(called.check(method, parameters), {1, 0});
  }
  // Calls the method and returns why it is refused; empty if it is not.
  std::string refusal_of(const std::string& method, const Json& parameters) {
    try {
      (void)call(method, parameters);
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    }
    return "";
  }
  [[nodiscard]] Names order() { return call("queue")["queue"].get<Names>(); }

  Names rejected;  // "FILE: REASON"
  bool asking;
  // Findings of each job; its analysis ends at once.
  Names findings;
  PrintQueue::Calls queue_calls() {
    PrintQueue::Calls calls{
        .check =
            [](const std::string&, JobReader::Keep, const std::function<void(const CheckedJob&)>& done) {
              JobOutlook outlook{.bytes = 84, .resin = "grey", .layers = 7};
              done(std::move(outlook));
            },
        .forget = [](const std::string&) {},
        .reject = [this](const std::string& file, const std::string& reason,
                         const Spool::Rejected&) { rejected.push_back(file + ": " + reason); },
        .changed = [] {},
        .refused = [](const std::string&, const std::string&) {},
        .removed = [](const std::string&, const std::string&) {},
        .keep_order = [](const QueueOrder::Names&, const auto&) {}};
    if (!asking) return calls;
    calls.questions.analyze = [this](const std::string& file, JobReader::Keep,
                                     const std::function<void(const JobAnalysisOutcome&)>& done) {
      AnalyzedJob found;
      found.analysis.resin_ml = 1.5;
      found.analysis.findings = findings;
      found.analysis.warnings = findings;
      found.content = file;
      done(found);
    };
    calls.questions.changed = [] {};
    calls.questions.asked = [](const PreprintAnalysis& analysis) { return analysis.findings; };
    calls.questions.keep_accepted = [](const Acceptances::Lines&, const auto& done) { done(""); };
    return calls;
  }
  PrintQueue queue{log.log, queue_calls()};
  JobScheduler scheduler{context,
                         spool,
                         queue,
                         hold,
                         {.has_job = [] { return true; },
                          .prints = [] { return true; },
                          .controlled_by_hand = [] { return false; },
                          .begin = [](const ClaimedJob&) {},
                          .copy_over = [] {}}};
  JobHistory history;
  ManualProcess manual{machine, clock, [] {}};
  ReminderConfig reminder_config;
  Reminders reminders{reminder_config};
  PrinterStatus status{context, {spool, queue, scheduler, hold, job, history, manual, reminders}};
  QueueControl control{queue, job, status};
  ControlMethods methods = control.methods();
};

}  // namespace

TEST_CASE("The queue has the details of each waiting job") {
  QueueControlFixture fixture({"one.stl", "two.stl"});
  fixture.queue.check_next();
  const Json jobs = fixture.call("queue")["jobs"];
  REQUIRE(jobs.size() == 2);
  CHECK(jobs[0].dump() ==
        R"({"number":1,"file":"one.stl","job":"one","state":"ready","waiting_for":null,"bytes":84,"parts":0,)"
        R"("resin":"grey","overrides":[],"layers":7,"thinnest_layer_um":0.0,"thickest_layer_um":0.0,)"
        R"("height_mm":0.0,"print_time_s":0.0,"supports":null,"resin_ml":null,"asks":[],"warnings":[]})");
  CHECK(jobs[1]["state"] == "unchecked");
  CHECK(jobs[1]["bytes"].is_null());
  CHECK(jobs[1].size() == jobs[0].size());
}

TEST_CASE("Details of a job that is not in the queue are a broken contract") {
  QueueControlFixture fixture({"one.stl"});
  CHECK(fixture.status.queue(0)["jobs"].size() == 1);
  CHECK(testing::contract_broken_by([&] { (void)fixture.status.queue(1); }) ==
        "there is a job of that number");
}

TEST_CASE("A long queue has the details of the first hundred jobs, and of any other job on request") {
  QueueControlFixture fixture;
  for (int i = 0; i < 150; ++i)
    fixture.queue.arrived(std::to_string(i) + ".stl");
  CHECK(fixture.call("queue")["jobs"].size() == 100);
  const Json asked = fixture.call("queue", {{"job", "149"}})["jobs"];
  REQUIRE(asked.size() == 1);
  CHECK(asked[0]["number"] == 150);
}

TEST_CASE("A job is found by its file's name, its own name, or the printable form of either") {
  QueueControlFixture fixture({"a.stl", "a.stl.stl", "b\x1b.stl", "c.stl", "c.STL"});
  const auto number = [&](const std::string& job) {
    return fixture.call("queue", {{"job", job}})["jobs"][0]["number"].get<int>();
  };
  CHECK(number("a") == 1);
  CHECK(number("a.stl") == 1);
  CHECK(number("a.stl.stl") == 2);
  CHECK(number("b?") == 3);
  CHECK(number("b?.stl") == 3);
  CHECK(number("c.STL") == 5);
  CHECK(fixture.refusal_of("queue", {{"job", "c"}}) ==
        R"(more than one job is called "c": "c.stl", "c.STL")");
  CHECK(fixture.refusal_of("queue", {{"job", "d\x1b"}}) == R"(no job "d\u001b" waits)");
}

TEST_CASE("A job whose turn has come no longer waits") {
  QueueControlFixture fixture({"next.stl"});
  fixture.begin();
  CHECK(fixture.refusal_of("queue_remove", {{"job", "part.stl"}}) ==
        R"("part.stl" no longer waits, its turn has come: cancel ends it)");
}

TEST_CASE("A job is moved to a place counted from 1, at most to the end") {
  QueueControlFixture fixture({"a.stl", "b.stl", "c.stl"});
  fixture.call("queue_move", {{"job", "c"}, {"to", 1}});
  CHECK(fixture.order() == Names{"c.stl", "a.stl", "b.stl"});
  fixture.call("queue_move", {{"job", "c"}, {"to", "last"}});
  CHECK(fixture.order() == Names{"a.stl", "b.stl", "c.stl"});
  const Json reply = fixture.call("queue_move", {{"job", "a"}, {"to", 1000}});
  CHECK(reply["queue"].get<Names>() == Names{"b.stl", "c.stl", "a.stl"});
}

TEST_CASE("Only the first thousand jobs can be moved, and only among themselves") {
  QueueControlFixture fixture;
  for (int i = 0; i < 1'001; ++i)
    fixture.queue.arrived(std::to_string(i) + ".stl");
  const std::string refusal = "only the first 1000 jobs can be moved, and only among themselves";
  CHECK(fixture.refusal_of("queue_move", {{"job", "1000"}, {"to", 1}}) == refusal);
  CHECK(fixture.refusal_of("queue_move", {{"job", "0"}, {"to", "last"}}) == refusal);
  CHECK(fixture.refusal_of("queue_move", {{"job", "999"}, {"to", 1}}).empty());
}

TEST_CASE("A removed job goes to failed once, with the user who removed it") {
  QueueControlFixture fixture({"a.stl", "b.stl"});
  const Json reply = fixture.call("queue_remove", {{"job", "a"}});
  CHECK(fixture.rejected == Names{"a.stl: removed from the queue by user root (0)\n"});
  CHECK(reply["jobs"][0]["state"] == "leaving");
  CHECK(fixture.refusal_of("queue_remove", {{"job", "a"}}) == R"("a.stl" is already being moved to failed)");
}

TEST_CASE("Invalid jobs and places are refused as parameters and change nothing") {
  QueueControlFixture fixture({"a.stl", "b.stl"});
  for (const Json& wrong : {Json(), Json(1), Json(""), Json(true), Json::object()}) {
    CAPTURE(wrong.dump());
    for (const char* method : {"queue", "queue_remove"})
      CHECK_THROWS_AS(fixture.call(method, {{"job", wrong}}), InvalidParameters);
    CHECK_THROWS_AS(fixture.call("queue_move", {{"job", wrong}, {"to", 1}}), InvalidParameters);
  }
  for (const Json& wrong : {Json(), Json(0), Json(-1), Json(1001), Json(1.5), Json("first"), Json(1e300)}) {
    CAPTURE(wrong.dump());
    CHECK_THROWS_AS(fixture.call("queue_move", {{"job", "b"}, {"to", wrong}}), InvalidParameters);
  }
  CHECK_THROWS_AS(fixture.call("queue_move", {{"job", "b"}}), InvalidParameters);
  CHECK_THROWS_AS(fixture.call("queue_remove"), InvalidParameters);
  CHECK(fixture.order() == Names{"a.stl", "b.stl"});
  CHECK(fixture.rejected.empty());
}

TEST_CASE("Only methods that change the queue are logged") {
  QueueControlFixture fixture;
  CHECK_FALSE(fixture.methods.at("queue").changes);
  CHECK(fixture.methods.at("queue_remove").changes);
  CHECK(fixture.methods.at("queue_move").changes);
  CHECK(fixture.methods.at("accept").changes);
}

TEST_CASE(
    "An unaccepted job is reported with its findings, and anyone who may change the queue can accept it") {
  QueueControlFixture fixture({"a.stl", "b.stl"}, true);
  fixture.findings = {"islands"};
  fixture.queue.check_next();
  CHECK(fixture.call("queue")["jobs"][0]["state"] == "analyzing");
  fixture.queue.check_next();
  fixture.queue.check_next();
  const Json job = fixture.call("queue", {{"job", "a"}})["jobs"][0];
  CHECK(job["state"] == "unaccepted");
  CHECK(job["waiting_for"] == "islands; run \"contourctl accept a\" to print it as it is");
  CHECK(job["asks"] == Json({"islands"}));
  CHECK(job["warnings"] == Json({"islands"}));
  CHECK(job["resin_ml"] == 1.5);
  CHECK(fixture.status.status()["unaccepted"] == Json({{"a.stl", job["waiting_for"]}}));
  const Json reply = fixture.call("accept", {{"job", "a.stl"}});
  CHECK(reply["jobs"][0]["state"] == "ready");
  CHECK(reply["jobs"][0]["asks"].empty());
  CHECK(fixture.status.status()["unaccepted"].empty());
  CHECK(fixture.log.has("a.stl: accepted by user root (0) with islands"));
  CHECK_FALSE(fixture.methods.at("accept").needs_service_rights);
}

TEST_CASE("Accepting a job that does not wait to be accepted is refused with the reason") {
  const auto refusal_of = [](QueueControlFixture& fixture, const char* job) {
    return fixture.refusal_of("accept", {{"job", job}});
  };
  QueueControlFixture silent({"a.stl"});
  CHECK(refusal_of(silent, "a") == R"("a.stl" need not be accepted: this printer's ask_before is empty)");
  QueueControlFixture fixture({"a.stl", "b.stl", "c.stl", "d.stl"}, true);
  CHECK(refusal_of(fixture, "none") == R"(no job "none" waits)");
  CHECK(refusal_of(fixture, "a") == R"("a.stl" is not analyzed yet: its findings are unknown)");
  for (int i = 0; i < 4; ++i)
    fixture.queue.check_next();
  fixture.queue.check_next();
  CHECK(refusal_of(fixture, "a") == R"("a.stl" does not wait to be accepted)");
  fixture.findings = {"cracks"};
  fixture.queue.check_next();
  fixture.queue.check_next();
  CHECK(refusal_of(fixture, "nine") == R"(no job "nine" waits; jobs that wait to be accepted: "b", "c")");
  CHECK(refusal_of(fixture, "b").empty());
  CHECK(refusal_of(fixture, "b") == R"("b.stl" does not wait to be accepted)");
  fixture.queue.remove("c.stl", "no");
  CHECK(refusal_of(fixture, "c") == R"("c.stl" is already being moved to failed)");
  CHECK_THROWS_AS(fixture.call("accept"), InvalidParameters);
}
