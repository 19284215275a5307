#include "daemon/control/history_control.hpp"

#include <algorithm>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using Json = HistoryControl::Json;

namespace {

// What is asked is answered in the order in which it was, once the loop runs.
class Desk : public testing::PrinterFixture {
 public:
  // Returns the reply's number.
  std::size_t ask(const std::string& method, const Json& parameters = Json::object(),
                  const ControlCaller& caller = {}) {
    const std::size_t number = replies.size();
    replies.emplace_back();
    const auto reply = methods.at(method).call_later(
        parameters, caller, [this, number](std::variant<Json, ControlRefusal> later) {
          const auto* const refusal = std::get_if<ControlRefusal>(&later);
          replies[number] = refusal != nullptr ? Json(refusal->what()) : std::move(std::get<Json>(later));
          answered.push_back(number);
        });
    if (reply) replies[number] = *reply;
    return number;
  }
  // Until all is answered; each step is taken when all before it is.
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
    EndedJob job{.name = name, .outcome = outcome, .reason = reason};
    kept.refuse(job);
    recent.add(std::move(job));
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  const std::filesystem::path file = folder_.path() / "history.sqlite";
  std::vector<Json> replies;          // of a refusal its words
  std::vector<std::size_t> answered;  // their numbers, as they came
  HistoryWorker kept{loop, log.log, file};
  JobHistory recent;
  ReminderConfig limits{.lamp = {.lamp_h = 0.5}, .film = {.layers = 10, .prints = 3}, .vat = {}};
  Reminders reminders{limits};
  int replacements = 0;
  HistoryControl control{kept, recent, reminders, [this](WearPart) { ++replacements; }};
  ControlMethods methods = control.methods();
};

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("The history is as long as is asked, and comes page by page") {
  Desk desk;
  for (int i = 0; i < 120; ++i)
    desk.end("job " + std::to_string(i));
  desk.ask("history", {{"last", 2}});
  desk.ask("history");
  desk.ask("history", {{"before", 21}});
  desk.run();
  CHECK(desk.names(0) == Names{"job 118", "job 119"});
  const Json& latest = desk.replies[1];
  CHECK(latest["ended"].size() == 100);
  CHECK(latest["ended"][0]["job"] == "job 20");
  CHECK(latest["before"] == 21);
  CHECK(latest["trouble"].is_null());
  CHECK(desk.names(2).size() == 20);
  CHECK(desk.replies[2]["before"].is_null());
}

TEST_CASE("A parameter of the history that makes no sense is refused") {
  Desk desk;
  const auto refused = [&](const char* name, const Json& value) {
    CAPTURE(name, value.dump());
    CHECK_THROWS_AS(desk.ask("history", {{name, value}}), InvalidParameters);
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

TEST_CASE("Without a file the history tells what is remembered of this run, by the same filters, and why") {
  Desk desk;
  std::filesystem::create_directory(desk.file);
  desk.end("one");
  desk.end("two", "failed");
  desk.ask("history");
  desk.ask("history", {{"outcome", "failed"}});
  desk.ask("history", {{"job", "on"}});
  desk.ask("history", {{"resin", "grey"}});
  desk.ask("history", {{"since", "2199-12-31T00:00:00Z"}});
  desk.ask("history", {{"last", 1}});
  desk.ask("usage");
  desk.run();
  CHECK(desk.names(0) == Names{"one", "two"});
  CHECK(desk.replies[0]["trouble"].get<std::string>().find("is a folder") != std::string::npos);
  CHECK(desk.names(1) == Names{"two"});
  CHECK(desk.names(2) == Names{"one"});
  CHECK(desk.names(3).empty());
  CHECK(desk.names(4).empty());
  CHECK(desk.names(5) == Names{"two"});
  CHECK(desk.replies[6]["trouble"].is_string());
  // Once, however often it is tried.
  CHECK(desk.log.count("warning") == 1);
}

TEST_CASE("The history of this run is told at once, whatever the file is like") {
  Desk desk;
  desk.end("one");
  const std::optional<Json> reply =
      desk.methods.at("history").call_later({{"this_run", true}}, {}, [](const auto&) { FAIL("later"); });
  REQUIRE(reply);
  CHECK((*reply)["ended"][0] == history_json(desk.recent.jobs().front()));
}

TEST_CASE("The history of this run comes page by page when its jobs are long") {
  Desk desk;
  std::string reason;
  for (int i = 0; i < 4'000; ++i)
    reason += "\u00e9";  // six letters in a reply
  Names all;
  for (int i = 0; i < 150; ++i) {
    all.push_back("job " + std::to_string(i));
    desk.end(all.back(), "failed", reason);
  }
  Names found;
  Json parameters{{"this_run", true}, {"outcome", "failed"}};
  for (bool more = true; more; parameters["before"] = desk.replies.back()["before"]) {
    const Names page = desk.names(desk.ask("history", parameters));
    CHECK(desk.replies.back()["ended"].dump(-1, ' ', true).size() < 100'000);
    REQUIRE_FALSE(page.empty());
    found.insert(found.begin(), page.begin(), page.end());
    more = desk.replies.back()["before"].is_number();
  }
  CHECK(found == Names(all.end() - JobHistory::kLongest, all.end()));
}

TEST_CASE("A job under way counts what it used so far, and one that is forgotten nothing") {
  Desk desk;
  desk.kept.begin("part");
  JobFigures figures;
  figures.resin = "grey";
  figures.lit_s = 36;
  desk.kept.note([&] { return figures; });
  // Too soon behind the last.
  desk.kept.note([&] {
    FAIL("noted");
    return figures;
  });
  desk.ask("usage");
  desk.kept.forget();
  desk.ask("usage");
  desk.ask("history");
  desk.run();
  CHECK(desk.replies[0]["lamp_h"] == 0.01);
  CHECK(desk.replies[0]["resins"][0]["resin"] == "grey");
  CHECK(desk.replies[1]["jobs"] == 0);
  CHECK(desk.names(2).empty());
}

TEST_CASE("A job that is refused in the queue does not end the one under way that has its name") {
  Desk desk;
  desk.kept.begin("part");
  EndedJob refused{.name = "part", .outcome = "failed", .reason = "no model"};
  desk.kept.refuse(refused);
  EndedJob done{.name = "part", .outcome = "done", .reason = ""};
  (void)desk.kept.end(done);
  CHECK(done.began <= done.ended);
  desk.ask("history");
  desk.ask("history", {{"outcome", "done"}});
  desk.run();
  CHECK(desk.names(0).size() == 2);
  CHECK(desk.names(1).size() == 1);
}

TEST_CASE("What happens to a job is noted behind the question under way, not behind all that wait") {
  Desk desk;
  for (int i = 0; i < 5; ++i)
    desk.ask("history");
  desk.end("part");
  desk.run();
  for (std::size_t i = 1; i < 5; ++i)
    CHECK(desk.names(i) == Names{"part"});
}

TEST_CASE("Users take turns at asking the history") {
  Desk desk;
  for (int i = 0; i < 4; ++i)
    desk.ask("history", Json::object(), {1, 1001});
  desk.ask("usage", Json::object(), {2, 1002});
  desk.run();
  CHECK(desk.answered == std::vector<std::size_t>{0, 4, 1, 2, 3});
}

TEST_CASE("What an asker wanted who has gone is not looked up") {
  Desk desk;
  desk.ask("history", Json::object(), {1, 1001});
  for (const char* method : {"history", "usage"})
    desk.ask(method, Json::object(), {2, 1001});
  desk.ask("history", Json::object(), {3, 1001});
  desk.control.disconnected(2);
  desk.run();
  CHECK(desk.answered == std::vector<std::size_t>{0, 1, 2, 3});
  CHECK(desk.replies[1] == "nobody waits for the answer");
  CHECK(desk.replies[2] == desk.replies[1]);
  CHECK(desk.replies[3].contains("ended"));
}

TEST_CASE("A part that wears counts from when it was replaced, and is due from any of its limits on") {
  Desk desk;
  const auto print = [&](std::int64_t layers, double lit_s) {
    desk.kept.begin("part");
    EndedJob job{.name = "part", .outcome = "done", .reason = ""};
    job.figures.layers_exposed = layers;
    job.figures.lit_s = lit_s;
    (void)desk.kept.end(job);
  };
  // What happens to jobs goes before what is asked: each answer is waited for.
  desk.run({[&] {
              print(9, 1799);
              desk.ask("usage");
            },
            [&] {
              print(1, 1);
              desk.ask("usage");
            },
            [&] {
              desk.ask("replaced", {{"part", "film"}});
            },
            [&] {
              desk.end("refused");  // no print
              print(2, 0);
              print(2, 0);
              desk.ask("usage");
            },
            [&] {
              print(2, 0);
              desk.ask("usage");
            }});
  const auto reminder = [&](std::size_t reply, std::size_t part) {
    return desk.replies[reply]["parts"][part]["reminder"];
  };
  CHECK(reminder(0, 0).is_null());
  CHECK(reminder(0, 1).is_null());
  CHECK(reminder(1, 0) ==
        "the lamp is due: 0.5 h of light (limit 0.5) since the history began; when it is replaced: "
        "contourctl replaced lamp");
  CHECK(reminder(1, 1).get<std::string>().starts_with(
      "the film is due: 10 layers (limit 10) since the history began;"));
  CHECK(reminder(2, 1).is_null());
  CHECK(desk.replies[2]["parts"][1]["layers"] == 0);
  CHECK(desk.replies[2]["parts"][0]["layers"] == 10);
  CHECK(desk.replies[3]["parts"][1]["prints"] == 2);
  CHECK(reminder(3, 1).is_null());
  CHECK(reminder(4, 1).get<std::string>().starts_with("the film is due: 3 prints (limit 3) since 2"));
  CHECK(reminder(4, 2).is_null());  // no limit
  CHECK(desk.replacements == 1);
}

TEST_CASE("What is due is of the last word of the history, and only what is wanted") {
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

TEST_CASE("A part that is none is not replaced") {
  Desk desk;
  for (const Json& wrong : {Json("lens"), Json(""), Json(1), Json()})
    CHECK_THROWS_AS(desk.ask("replaced", {{"part", wrong}}), InvalidParameters);
  CHECK_THROWS_AS(desk.ask("replaced"), InvalidParameters);
}
