#include "daemon/control/history_control.hpp"

#include <deque>
#include <filesystem>
#include <variant>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using Json = HistoryControl::Json;

namespace {

// A history whose queries are answered while the loop runs.
class HistoryControlFixture : public testing::PrinterFixture {
 public:
  // Sends a query and returns the number of its reply.
  std::size_t ask(const std::string& method, const Json& parameters = Json::object(),
                  const ControlCaller& caller = {}) {
    const std::size_t number = replies.size();
    replies.emplace_back();
    const ControlMethod& called = methods.at(method);
    called.call_later(
        called.check(method, parameters), caller, [this, number](std::variant<Json, ControlRefusal> later) {
          const auto* const refusal = std::get_if<ControlRefusal>(&later);
          replies[number] = refusal != nullptr ? Json(refusal->what()) : std::move(std::get<Json>(later));
          answered.push_back(number);
        });
    return number;
  }
  // Runs until all queries are answered; each step follows when all queries before it are answered.
  void run(std::deque<std::function<void()>> steps = {}) {
    REQUIRE(run_until([&] {
      if (std::ranges::any_of(replies, &Json::is_null)) return false;
      if (steps.empty()) return true;
      steps.front()();
      steps.pop_front();
      return false;
    }));
  }
  std::vector<std::string> names(std::size_t number) {
    std::vector<std::string> found;
    for (const Json& job : replies[number]["ended"])
      found.push_back(job["job"]);
    return found;
  }
  void end(const std::string& name, const std::string& outcome = "done", const std::string& reason = "") {
    EndedJob job{.name = name, .outcome = outcome, .reason = reason, .key = new_job_key()};
    worker.refuse(job);
    recent.add(std::move(job));
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  const std::filesystem::path file = folder_.path() / "history.sqlite";
  std::vector<Json> replies;          // a refusal's message instead
  std::vector<std::size_t> answered;  // numbers of the replies, in order of arrival
  const StateRecords records{folder_.path()};
  JobEndRecord ends{records};
  HistoryWorker worker{loop, log.log, file, ends};
  JobHistory recent;
  ReminderConfig limits{.lamp = {.lamp_h = 0.5}, .film = {.layers = 10, .prints = 3}, .vat = {}};
  Reminders reminders{limits};
  int replacements = 0;
  HistoryControl control{worker, recent, reminders, [this](WearPart) { ++replacements; }};
  ControlMethods methods = control.methods();
};

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("The history has at most the requested number of jobs, page by page") {
  HistoryControlFixture fixture;
  for (int i = 0; i < 120; ++i)
    fixture.end("job " + std::to_string(i));
  fixture.ask("history", {{"last", 2}});
  fixture.ask("history");
  fixture.ask("history", {{"before", 21}});
  fixture.run();
  CHECK(fixture.names(0) == Names{"job 118", "job 119"});
  const Json& latest = fixture.replies[1];
  CHECK(latest["ended"].size() == 100);
  CHECK(latest["ended"][0]["job"] == "job 20");
  CHECK(latest["before"] == 21);
  CHECK(latest["trouble"].is_null());
  CHECK(fixture.names(2).size() == 20);
  CHECK(fixture.replies[2]["before"].is_null());
}

TEST_CASE("Invalid parameters of the history are refused") {
  HistoryControlFixture fixture;
  const auto refused = [&](const char* name, const Json& value) {
    CAPTURE(name, value.dump());
    CHECK_THROWS_AS(fixture.ask("history", {{name, value}}), InvalidParameters);
  };
  for (const Json& wrong : {Json(0), Json(101), Json(-1), Json(1.5), Json("2"), Json(), Json(1e300)})
    refused("last", wrong);
  for (const Json& wrong : {Json(0), Json(-1), Json("2"), Json(1.5)})
    refused("before", wrong);
  for (const Json& wrong : {Json("yesterday"), Json("2026-11-20"), Json("2026-11-20T19:05:00Zx"),
                            Json("2999-01-01T00:00:00Z"), Json(7)})
    refused("since", wrong);
  for (const Json& wrong : {Json("don"), Json(""), Json(1)})
    refused("outcome", wrong);
  refused("resin", "");
  refused("job", Json::array());
  refused("this_run", 1);
}

TEST_CASE("Without its file the history reports the jobs of this run, by the same filters, and the reason") {
  HistoryControlFixture fixture;
  std::filesystem::create_directory(fixture.file);
  fixture.end("one");
  fixture.end("two", "failed");
  fixture.ask("history");
  fixture.ask("history", {{"outcome", "failed"}});
  fixture.ask("history", {{"job", "on"}});
  fixture.ask("history", {{"resin", "grey"}});
  fixture.ask("history", {{"since", "2199-12-31T00:00:00Z"}});
  fixture.ask("history", {{"last", 1}});
  fixture.ask("usage");
  fixture.run();
  CHECK(fixture.names(0) == Names{"one", "two"});
  CHECK(fixture.replies[0]["trouble"].get<std::string>().find("is a folder") != std::string::npos);
  CHECK(fixture.names(1) == Names{"two"});
  CHECK(fixture.names(2) == Names{"one"});
  CHECK(fixture.names(3).empty());
  CHECK(fixture.names(4).empty());
  CHECK(fixture.names(5) == Names{"two"});
  CHECK(fixture.replies[6]["trouble"].is_string());
  // The problem is logged once, although several queries failed.
  CHECK(fixture.log.count("warning") == 1);
}

TEST_CASE("The history of this run is answered at once, whatever the state of the file") {
  HistoryControlFixture fixture;
  fixture.end("one");
  const std::size_t number = fixture.ask("history", {{"this_run", true}});
  REQUIRE(!fixture.replies[number].is_null());
  CHECK(fixture.replies[number]["ended"][0] == history_json(fixture.recent.jobs().front()));
}

TEST_CASE("The history of this run comes in several pages if its jobs are long") {
  HistoryControlFixture fixture;
  std::string reason;
  for (int i = 0; i < 4'000; ++i)
    reason += "\u00e9";  // six letters in a reply
  Names all;
  for (int i = 0; i < 150; ++i) {
    all.push_back("job " + std::to_string(i));
    fixture.end(all.back(), "failed", reason);
  }
  Names found;
  Json parameters{{"this_run", true}, {"outcome", "failed"}};
  for (bool more = true; more; parameters["before"] = fixture.replies.back()["before"]) {
    const Names page = fixture.names(fixture.ask("history", parameters));
    CHECK(fixture.replies.back()["ended"].dump(-1, ' ', true).size() < 100'000);
    REQUIRE_FALSE(page.empty());
    found.insert(found.begin(), page.begin(), page.end());
    more = fixture.replies.back()["before"].is_number();
  }
  CHECK(found == Names(all.end() - JobHistory::kLongest, all.end()));
}

TEST_CASE("A running job counts with its use so far, and a forgotten job does not count") {
  HistoryControlFixture fixture;
  fixture.worker.begin("part");
  JobFigures figures;
  figures.resin = "grey";
  figures.lit_s = 36;
  fixture.worker.note([&] { return figures; });
  // Ignored: too soon after the last call.
  fixture.worker.note([&] {
    FAIL("called");
    return figures;
  });
  fixture.ask("usage");
  fixture.worker.forget();
  fixture.ask("usage");
  fixture.ask("history");
  fixture.run();
  CHECK(fixture.replies[0]["lamp_h"] == 0.01);
  CHECK(fixture.replies[0]["resins"][0]["resin"] == "grey");
  CHECK(fixture.replies[1]["jobs"] == 0);
  CHECK(fixture.names(2).empty());
}

TEST_CASE("A job refused in the queue does not end the running job of the same name") {
  HistoryControlFixture fixture;
  fixture.worker.begin("part");
  EndedJob refused{.name = "part", .outcome = "failed", .reason = "no model", .key = new_job_key()};
  fixture.worker.refuse(refused);
  EndedJob done{.name = "part", .outcome = "done", .reason = ""};
  fixture.worker.end(done);
  CHECK(done.began <= done.ended);
  fixture.ask("history");
  fixture.ask("history", {{"outcome", "done"}});
  fixture.run();
  CHECK(fixture.names(0).size() == 2);
  CHECK(fixture.names(1).size() == 1);
}

TEST_CASE("The end of a job is recorded after the current query, before all waiting queries") {
  HistoryControlFixture fixture;
  for (int i = 0; i < 5; ++i)
    fixture.ask("history");
  fixture.end("part");
  fixture.run();
  for (std::size_t i = 1; i < 5; ++i)
    CHECK(fixture.names(i) == Names{"part"});
}

TEST_CASE("Users take turns in querying the history") {
  HistoryControlFixture fixture;
  for (int i = 0; i < 4; ++i)
    fixture.ask("history", Json::object(), {1, 1001});
  fixture.ask("usage", Json::object(), {2, 1002});
  fixture.run();
  CHECK(fixture.answered == std::vector<std::size_t>{0, 4, 1, 2, 3});
}

TEST_CASE("Waiting queries of a closed connection are dropped") {
  HistoryControlFixture fixture;
  fixture.ask("history", Json::object(), {1, 1001});
  for (const char* method : {"history", "usage"})
    fixture.ask(method, Json::object(), {2, 1001});
  fixture.ask("history", Json::object(), {3, 1001});
  fixture.control.disconnected(2);
  fixture.run();
  CHECK(fixture.answered == std::vector<std::size_t>{0, 1, 2, 3});
  CHECK(fixture.replies[1] == "the client has disconnected");
  CHECK(fixture.replies[2] == fixture.replies[1]);
  CHECK(fixture.replies[3].contains("ended"));
}

TEST_CASE("The use of a part counts from its replacement, and the part is due at any of its limits") {
  HistoryControlFixture fixture;
  const auto print = [&](std::int64_t layers, double lit_s) {
    fixture.worker.begin("part");
    EndedJob job{.name = "part", .outcome = "done", .reason = ""};
    job.figures.layers_exposed = layers;
    job.figures.lit_s = lit_s;
    fixture.worker.end(job);
  };
  // Updates about jobs precede queries, so each step waits for the answers.
  fixture.run({[&] {
                 print(9, 1799);
                 fixture.ask("usage");
               },
               [&] {
                 print(1, 1);
                 fixture.ask("usage");
               },
               [&] {
                 fixture.ask("replaced", {{"part", "film"}});
               },
               [&] {
                 fixture.end("refused");  // not a print
                 print(2, 0);
                 print(2, 0);
                 fixture.ask("usage");
               },
               [&] {
                 print(2, 0);
                 fixture.ask("usage");
               }});
  const auto reminder = [&](std::size_t reply, std::size_t part) {
    return fixture.replies[reply]["parts"][part]["reminder"];
  };
  CHECK(reminder(0, 0).is_null());
  CHECK(reminder(0, 1).is_null());
  CHECK(reminder(1, 0) ==
        "the lamp is due: 0.5 h of light (limit 0.5) since the history began; when it is replaced: "
        "contourctl replaced lamp");
  CHECK(reminder(1, 1).get<std::string>().starts_with(
      "the film is due: 10 layers (limit 10) since the history began;"));
  CHECK(reminder(2, 1).is_null());
  CHECK(fixture.replies[2]["parts"][1]["layers"] == 0);
  CHECK(fixture.replies[2]["parts"][0]["layers"] == 10);
  CHECK(fixture.replies[3]["parts"][1]["prints"] == 2);
  CHECK(reminder(3, 1).is_null());
  CHECK(reminder(4, 1).get<std::string>().starts_with("the film is due: 3 prints (limit 3) since 2"));
  CHECK(reminder(4, 2).is_null());  // no limit
  CHECK(fixture.replacements == 1);
}

TEST_CASE("Reminders follow the latest use and cover only parts with limits") {
  const ReminderConfig none;
  CHECK_FALSE(Reminders(none).wanted());
  const ReminderConfig config{.lamp = {}, .film = {.layers = 10}, .vat = {.prints = 2}};
  Reminders reminders(config);
  CHECK(reminders.wanted());
  reminders.update({{.part = WearPart::Lamp, .lamp_h = 1e6, .layers = 1'000'000'000, .prints = 1'000'000},
                    {.part = WearPart::Film, .layers = 10},
                    {.part = WearPart::Vat, .prints = 2}});
  CHECK(reminders.due().size() == 2);
  reminders.update({{.part = WearPart::Film, .layers = 9}});
  CHECK(reminders.due().empty());
}

TEST_CASE("An unknown part is not replaced") {
  HistoryControlFixture fixture;
  for (const Json& wrong : {Json("lens"), Json(""), Json(1), Json()})
    CHECK_THROWS_AS(fixture.ask("replaced", {{"part", wrong}}), InvalidParameters);
  CHECK_THROWS_AS(fixture.ask("replaced"), InvalidParameters);
}
