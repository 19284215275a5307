#include "daemon/ctl/watch/watch_view.hpp"

#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/system/readable.hpp"
#include "tests/catch.hpp"

using namespace contourd::ctl;
using contourd::printable;

namespace {

using Json = WatchedPrinter::Json;

constexpr std::time_t kNoon = 1'750'000'000;  // 2025-06-15 15:06:40 UTC

Json idle() {
  return {
      {"printer", "Simulated printer"},
      {"state", "idle"},
      {"job", nullptr},
      {"queued", 0},
      {"incomplete", Json::object()},
      {"postponed", Json::object()},
      {"ignored", Json::object()},
      {"deletable", Json::array()},
      {"plate", "clear"},
      {"plate_job", nullptr},
      {"not_ready_reason", nullptr},
      {"held", nullptr},
      {"waiting_for", nullptr},
      {"reminders", Json::array()},
      {"last", nullptr},
      {"dark", true},
      {"manual", {{"state", "idle"}, {"problem", nullptr}, {"height_mm", nullptr}, {"picture", nullptr}}}};
}

Json printing() {
  Json status = idle();
  status["state"] = "exposing";
  status["dark"] = false;
  status["job"] = {
      {"name", "gear"},
      {"analysis", {{"resin_ml", 3.21}, {"warnings", {"1 island begins with nothing under it"}}}},
      {"layer", 43},
      {"layers", 100},
      {"layers_done", 42},
      {"height_mm", 2.15},
      {"total_height_mm", 5.0},
      {"layer_height_um", 50},
      {"time_left_s", 750},
      {"state_left_s", 3.4},
      {"pause", nullptr},
      {"interruption", nullptr}};
  return status;
}

WatchedPrinter printer(Json status) {
  ::setenv("TZ", "UTC", 1);
  ::tzset();
  WatchedPrinter all;
  all.status = std::move(status);
  all.queue = {{"queue", {"next.stl", "later.stl"}}, {"more", 0}, {"arriving", Json::array()}};
  all.now = kNoon;
  return all;
}

// Returns a printer whose names, sentences and numbers have extreme values.
WatchedPrinter hostile() {
  const std::string name = "\x1B[2J\n\u202E\u90E8\u54C1\xFF" + std::string(200, 'x');
  Json status = printing();
  for (const char* const key : {"printer", "held", "not_ready_reason", "waiting_for", "state"})
    status[key] = name;
  status["job"]["name"] = status["job"]["interruption"] = status["job"]["pause"] = name;
  status["job"]["analysis"]["warnings"] = Json::array({name, name, name});
  status["job"]["layers_done"] = 1e9;
  status["job"]["time_left_s"] = 1e18;
  status["ignored"][name] = name;
  status["incomplete"][name] = {name};
  status["deletable"] = {name};
  WatchedPrinter all = printer(status);
  all.queue["queue"] = Json::array();
  for (int i = 0; i < 100; ++i)
    all.queue["queue"].push_back(name);
  all.job = all.trouble = name;
  return all;
}

std::string text_of(const WatchedPrinter& all, ScreenSize size = {}) {
  std::string text;
  for (const ScreenLine& line : watch_lines(all, size))
    text += line.text + "\n";
  return text;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void check_fit(const WatchedPrinter& all, ScreenSize size) {
  const auto lines = watch_lines(all, size);
  CHECK(lines.size() <= size.rows);
  for (const ScreenLine& line : lines) {
    CHECK(columns_of(line.text) <= size.columns);
    CHECK(printable(line.text) == line.text);
  }
}

}  // namespace

TEST_CASE("No line of the view is wider than the screen, and there are not more lines than rows") {
  const auto status = GENERATE(0, 1, 2, 3);
  const WatchedPrinter all = status == 0   ? printer(printing())
                             : status == 1 ? printer(idle())
                             : status == 2 ? hostile()
                                           : WatchedPrinter{};
  for (std::size_t columns = 1; columns < 130; ++columns)
    check_fit(all, {columns, 24});
  for (std::size_t rows = 0; rows < 60; ++rows)
    check_fit(all, {80, rows});
  for (const std::size_t columns : {1UL, 10UL, 29UL, 30UL, 40UL, 500UL})
    for (const std::size_t rows : {0UL, 1UL, 2UL, 5UL, 300UL})
      check_fit(all, {columns, rows});
}

TEST_CASE("The view of a print shows all known facts about it") {
  WatchedPrinter all = printer(printing());
  const std::string text = text_of(all);
  for (const char* const part :
       {"gear\n", "#.", "]  42 %", "phase     exposing, 4 s left", "light     ON",
        "layer     43 of 100, 50 um", "height    2.150 of 5.000 mm", "time left 12 min 30 s, until 15:19",
        "resin     3.21 ml", "next      resting; then next.stl", "warning   1 island begins",
        "2  later.stl"}) {
    INFO(text);
    CHECK(has(text, part));
  }
}

TEST_CASE(
    "The view counts down between two statuses, the time left at most by the state's expected duration") {
  WatchedPrinter all = printer(printing());
  all.status_age_s = 2;
  CHECK(has(text_of(all), "exposing, 2 s left"));
  CHECK(has(text_of(all), "time left 12 min 28 s"));
  all.status_age_s = 100;
  CHECK(has(text_of(all), "exposing, 0 s left"));
  CHECK(has(text_of(all), "time left 12 min 27 s"));
}

TEST_CASE("An end on another day is shown with its date") {
  Json status = printing();
  status["job"]["time_left_s"] = 36000;
  CHECK(has(text_of(printer(status)), "10 h 00 min, until Mon 16 Jun, 01:06"));
}

TEST_CASE("The view shows the known state of the light") {
  Json status = printing();
  const auto light = [&](const char* state, bool dark) {
    status["state"] = state;
    status["dark"] = dark;
    return text_of(printer(status));
  };
  CHECK(has(light("exposing", false), "light     ON"));
  CHECK(has(light("igniting", false), "light     turning on"));
  CHECK(has(light("extinguishing", false), "light     not confirmed off"));
  CHECK(has(light("lifting", true), "light     off"));
  WatchedPrinter gone = printer(status);
  gone.trouble = "contourd closed the connection";
  CHECK(has(text_of(gone), "light     unknown"));
  CHECK(has(text_of(gone), "closed the connection"));
}

TEST_CASE("A paused print has no end time") {
  Json status = printing();
  status["state"] = "paused";
  status["job"]["state_left_s"] = nullptr;
  status["job"]["interruption"] = "the lid was opened";
  const std::string text = text_of(printer(status));
  CHECK_FALSE(has(text, "until"));
  CHECK(has(text, "stopped   the lid was opened"));
  status["job"]["warnings"] = {"no force was felt"};
  CHECK(has(text_of(printer(status)), "warning   no force was felt"));
  CHECK(has(text, "contourctl resume"));
}

TEST_CASE("During a pause, the view shows the next job as next") {
  Json status = printing();
  status["state"] = "paused";
  CHECK(has(text_of(printer(status)), "next      next.stl\n"));
}

TEST_CASE("The view of an idle printer shows the reason, the queue and manual control") {
  Json status = idle();
  status["held"] = "the queue is held: a failure";
  status["plate"] = "occupied";
  status["plate_job"] = "gear";
  status["last"] = {{"job", "gear"}, {"outcome", "failed"}, {"reason", "no light"}};
  status["manual"] = {{"state", "moving"}, {"problem", nullptr}, {"height_mm", 20.0}, {"picture", "grid"}};
  status["queued"] = 2;
  status["reminders"] = {"the film is due"};
  const std::string text = text_of(printer(status));
  for (const char* const part :
       {"idle\n", "held      the queue is held", "plate     occupied by gear",
        "last job  gear: failed: no light", "reminder  the film is due",
        "by hand   moving, plate at 20.000 mm, screen: grid", "queue     2 jobs", "1  next.stl"}) {
    INFO(text);
    CHECK(has(text, part));
  }
}

TEST_CASE("A screen with few rows still shows the progress, the light and the reason of an interruption") {
  Json status = printing();
  status["job"]["interruption"] = "the lid was opened";
  const std::string three = text_of(printer(status), {40, 3});
  CHECK(has(three, "42 %"));
  CHECK(has(three, "ON"));
  CHECK(has(three, "the lid was opened"));
  CHECK(has(text_of(printer(status), {40, 1}), "42 %"));
}
