#include "daemon/control/queue_control.hpp"

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"
#include "tests/message_of.hpp"

using Json = QueueControl::Json;
using testing::Names;

namespace {

class QueueControlFixture : public testing::ControlFixture {
 public:
  // With `asks`, the islands and cracks of a job need confirmation.
  explicit QueueControlFixture(const Names& files = {}, bool asks = false) {
    checks.check_result = JobOutlook{.bytes = 84, .resin = "grey", .layers = 7};
    checks.saves_end = true;
    checks.analysis_result = [this](const std::string& file) {
      return AnalyzedJob{{.resin_ml = 1.5, .findings = findings, .warnings = findings}, file, {}};
    };
    if (asks) config.ask_before = {"islands", "cracks"};
    for (const std::string& file : files)
      queue.arrived(file);
  }
  Json call(const std::string& method, const Json& parameters = Json::object()) {
    const ControlMethod& called = methods.at(method);
    return called.call(called.check(method, parameters), {1, 0});
  }
  // Calls the method and returns why it is refused; empty if it is not.
  std::string refusal_of(const std::string& method, const Json& parameters) {
    return testing::message_of<ControlRefusal>([&] { (void)call(method, parameters); });
  }
  [[nodiscard]] Names order() { return call("queue")["queue"].get<Names>(); }

  Names findings;  // of each job; its analysis ends at once
  QueueControl control{queue, job, status};
  ControlMethods methods = control.methods();
};

}  // namespace

TEST_CASE("The queue has the details of each waiting job") {
  QueueControlFixture fixture({"one.stl", "two.stl"});
  fixture.queue.check_next();
  Json jobs = fixture.call("queue")["jobs"];
  REQUIRE(jobs.size() == 2);
  CHECK(jobs[0]["forecast"]["time_s"] == jobs[0]["print_time_s"]);
  jobs[0]["forecast"] = nullptr;
  CHECK(
      jobs[0].dump() ==
      R"({"number":1,"file":"one.stl","job":"one","state":"ready","waiting_for":null,"bytes":84,"parts":0,)"
      R"("resin":"grey","overrides":[],"layers":7,"thinnest_layer_um":0.0,"thickest_layer_um":0.0,)"
      R"("height_mm":0.0,"print_time_s":0.0,"forecast":null,"supports":null,"resin_ml":null,"asks":[],"warnings":[]})");
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
  REQUIRE(fixture.checks.rejections.size() == 1);
  CHECK(fixture.checks.rejections[0].file == "a.stl");
  CHECK(fixture.checks.rejections[0].reason == "removed from the queue by user root (0)");
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
  CHECK(fixture.checks.rejections.empty());
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
  CHECK(job["waiting_for"] == "islands; run \"contourctl accept a\" to print it anyway");
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
