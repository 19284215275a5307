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

class Desk : public testing::CurrentJobFixture {
 public:
  explicit Desk(const Names& files = {}, bool asks = false) : asking(asks) {
    for (const std::string& file : files)
      queue.arrived(file);
  }
  Json call(const std::string& method, const Json& parameters = Json::object()) {
    return methods.at(method).call(parameters, {1, 0});
  }
  // Why it is refused; empty when it is not.
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
  // Each job is found to have these at once.
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

TEST_CASE("The queue has all that is known of a job that waits") {
  Desk desk({"one.stl", "two.stl"});
  desk.queue.check_next();
  const Json jobs = desk.call("queue")["jobs"];
  REQUIRE(jobs.size() == 2);
  CHECK(jobs[0].dump() ==
        R"({"number":1,"file":"one.stl","job":"one","state":"ready","waiting_for":null,"bytes":84,"parts":0,)"
        R"("resin":"grey","overrides":[],"layers":7,"thinnest_layer_um":0.0,"thickest_layer_um":0.0,)"
        R"("height_mm":0.0,"print_time_s":0.0,"supports":null,"resin_ml":null,"asks":[],"warnings":[]})");
  CHECK(jobs[1]["state"] == "unchecked");
  CHECK(jobs[1]["bytes"].is_null());
  CHECK(jobs[1].size() == jobs[0].size());
}

TEST_CASE("The queue is asked for a job that is in it") {
  Desk desk({"one.stl"});
  CHECK(desk.status.queue(0)["jobs"].size() == 1);
  CHECK(testing::contract_broken_by([&] { (void)desk.status.queue(1); }) == "there is a job of that number");
}

TEST_CASE("Of a long queue the first hundred are told whole, and any other when it is asked for") {
  Desk desk;
  for (int i = 0; i < 150; ++i)
    desk.queue.arrived(std::to_string(i) + ".stl");
  CHECK(desk.call("queue")["jobs"].size() == 100);
  const Json asked = desk.call("queue", {{"job", "149"}})["jobs"];
  REQUIRE(asked.size() == 1);
  CHECK(asked[0]["number"] == 150);
}

TEST_CASE("A job is meant by its file's name, by its own, or by either as people read it") {
  Desk desk({"a.stl", "a.stl.stl", "b\x1b.stl", "c.stl", "c.STL"});
  const auto number = [&](const std::string& job) {
    return desk.call("queue", {{"job", job}})["jobs"][0]["number"].get<int>();
  };
  CHECK(number("a") == 1);
  CHECK(number("a.stl") == 1);
  CHECK(number("a.stl.stl") == 2);
  CHECK(number("b?") == 3);
  CHECK(number("b?.stl") == 3);
  CHECK(number("c.STL") == 5);
  CHECK(desk.refusal_of("queue", {{"job", "c"}}) == R"(more than one job is called "c": "c.stl", "c.STL")");
  CHECK(desk.refusal_of("queue", {{"job", "d\x1b"}}) == R"(no job "d\u001b" waits)");
}

TEST_CASE("A job whose turn has come does not wait") {
  Desk desk({"next.stl"});
  desk.begin();
  CHECK(desk.refusal_of("queue_remove", {{"job", "part.stl"}}) ==
        R"("part.stl" does not wait, its turn has come: cancel ends it)");
}

TEST_CASE("A job is moved to a place from 1 on, and further than to the end it does not go") {
  Desk desk({"a.stl", "b.stl", "c.stl"});
  desk.call("queue_move", {{"job", "c"}, {"to", 1}});
  CHECK(desk.order() == Names{"c.stl", "a.stl", "b.stl"});
  desk.call("queue_move", {{"job", "c"}, {"to", "last"}});
  CHECK(desk.order() == Names{"a.stl", "b.stl", "c.stl"});
  const Json reply = desk.call("queue_move", {{"job", "a"}, {"to", 1000}});
  CHECK(reply["queue"].get<Names>() == Names{"b.stl", "c.stl", "a.stl"});
}

TEST_CASE("Of a queue of thousands only the first are moved, and only among themselves") {
  Desk desk;
  for (int i = 0; i < 1'001; ++i)
    desk.queue.arrived(std::to_string(i) + ".stl");
  const std::string refusal = "only the first 1000 jobs can be moved, and to these places only";
  CHECK(desk.refusal_of("queue_move", {{"job", "1000"}, {"to", 1}}) == refusal);
  CHECK(desk.refusal_of("queue_move", {{"job", "0"}, {"to", "last"}}) == refusal);
  CHECK(desk.refusal_of("queue_move", {{"job", "999"}, {"to", 1}}).empty());
}

TEST_CASE("A removed job goes to failed with who removed it, once") {
  Desk desk({"a.stl", "b.stl"});
  const Json reply = desk.call("queue_remove", {{"job", "a"}});
  CHECK(desk.rejected == Names{"a.stl: removed from the queue by user root (0)\n"});
  CHECK(reply["jobs"][0]["state"] == "leaving");
  CHECK(desk.refusal_of("queue_remove", {{"job", "a"}}) == R"("a.stl" is on its way to failed already)");
}

TEST_CASE("What is no job and no place is refused as a parameter, and changes nothing") {
  Desk desk({"a.stl", "b.stl"});
  for (const Json& wrong : {Json(), Json(1), Json(""), Json(true), Json::object()}) {
    CAPTURE(wrong.dump());
    for (const char* method : {"queue", "queue_remove"})
      CHECK_THROWS_AS(desk.call(method, {{"job", wrong}}), InvalidParameters);
    CHECK_THROWS_AS(desk.call("queue_move", {{"job", wrong}, {"to", 1}}), InvalidParameters);
  }
  for (const Json& wrong : {Json(), Json(0), Json(-1), Json(1001), Json(1.5), Json("first"), Json(1e300)}) {
    CAPTURE(wrong.dump());
    CHECK_THROWS_AS(desk.call("queue_move", {{"job", "b"}, {"to", wrong}}), InvalidParameters);
  }
  CHECK_THROWS_AS(desk.call("queue_move", {{"job", "b"}}), InvalidParameters);
  CHECK_THROWS_AS(desk.call("queue_remove"), InvalidParameters);
  CHECK(desk.order() == Names{"a.stl", "b.stl"});
  CHECK(desk.rejected.empty());
}

TEST_CASE("Only what changes the queue is told in the log") {
  Desk desk;
  CHECK_FALSE(desk.methods.at("queue").changes);
  CHECK(desk.methods.at("queue_remove").changes);
  CHECK(desk.methods.at("queue_move").changes);
  CHECK(desk.methods.at("accept").changes);
}

TEST_CASE("A job that asks is told with what was found, and is accepted by whoever may change the queue") {
  Desk desk({"a.stl", "b.stl"}, true);
  desk.findings = {"islands"};
  desk.queue.check_next();
  CHECK(desk.call("queue")["jobs"][0]["state"] == "analysis");
  desk.queue.check_next();
  desk.queue.check_next();
  const Json job = desk.call("queue", {{"job", "a"}})["jobs"][0];
  CHECK(job["state"] == "unaccepted");
  CHECK(job["waiting_for"] == "islands; \"contourctl accept a\" has it printed as it is");
  CHECK(job["asks"] == Json({"islands"}));
  CHECK(job["warnings"] == Json({"islands"}));
  CHECK(job["resin_ml"] == 1.5);
  CHECK(desk.status.status()["unaccepted"] == Json({{"a.stl", job["waiting_for"]}}));
  const Json reply = desk.call("accept", {{"job", "a.stl"}});
  CHECK(reply["jobs"][0]["state"] == "ready");
  CHECK(reply["jobs"][0]["asks"].empty());
  CHECK(desk.status.status()["unaccepted"].empty());
  CHECK(desk.log.has("a.stl: user root (0) accepts it with islands"));
  CHECK_FALSE(desk.methods.at("accept").needs_service_rights);
}

TEST_CASE("A word for a job that does not wait for one is refused with why") {
  const auto refusal_of = [](Desk& desk, const char* job) {
    return desk.refusal_of("accept", {{"job", job}});
  };
  Desk silent({"a.stl"});
  CHECK(refusal_of(silent, "a") == R"("a.stl" needs no word: this printer's ask_before names nothing)");
  Desk desk({"a.stl", "b.stl", "c.stl", "d.stl"}, true);
  CHECK(refusal_of(desk, "none") == R"(no job "none" waits)");
  CHECK(refusal_of(desk, "a") ==
        R"("a.stl" is not looked through yet: nobody knows what there is to accept)");
  for (int i = 0; i < 4; ++i)
    desk.queue.check_next();
  desk.queue.check_next();
  CHECK(refusal_of(desk, "a") == R"("a.stl" waits for nobody's word)");
  desk.findings = {"cracks"};
  desk.queue.check_next();
  desk.queue.check_next();
  CHECK(refusal_of(desk, "nine") == R"(no job "nine" waits; to be accepted there is "b", "c")");
  CHECK(refusal_of(desk, "b").empty());
  CHECK(refusal_of(desk, "b") == R"("b.stl" waits for nobody's word)");
  desk.queue.remove("c.stl", "no");
  CHECK(refusal_of(desk, "c") == R"("c.stl" is on its way to failed already)");
  CHECK_THROWS_AS(desk.call("accept"), InvalidParameters);
}
