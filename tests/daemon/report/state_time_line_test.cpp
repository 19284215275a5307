#include "daemon/report/state_time_line.hpp"

#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

constexpr TimePoint kStart{std::chrono::hours(1000)};

PrintReport paused_print() {
  PrintReport report;
  report.states = StateTimes(kStart);
  report.states.enter(PrintState::Homing, kStart);
  report.states.enter(PrintState::Exposing, kStart + 10s);
  report.states.enter(PrintState::Paused, kStart + 40s);
  report.states.enter(PrintState::Lowering, kStart + 90s);
  report.states.enter(PrintState::Idle, kStart + 100s);
  report.stops.pauses.push_back({3, 40s, 50s});
  report.stops.interruptions.push_back({3, 39s, "the lid <b>was</b> opened"});
  return report;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++found;
  return found;
}

}  // namespace

TEST_CASE("The time line has a shape for each activity, and a mark for each stop") {
  const std::string svg = state_time_line(paused_print());
  for (const char* activity : {"preparing", "exposing", "moving", "stopped"})
    CHECK(count(svg, std::string("<title>") + activity + "</title>") == 1);
  CHECK(count(svg, "<title>waiting</title>") == 0);
  CHECK(count(svg, "<title>layer 4: stopped for 50.0 s</title>") == 1);
  CHECK(count(svg, "layer 4: the lid &lt;b&gt;was&lt;/b&gt; opened") == 1);
  CHECK(count(svg, "<b>") == 0);
}

TEST_CASE("The table has each state that was entered, and shares of the whole") {
  const std::string table = state_table(paused_print().states);
  CHECK(count(table, "<tr>") == 5);
  CHECK(count(table, "exposing\"></span>exposing</td><td>30.0 s</td><td>30.0 %") == 1);
  CHECK(count(table, "stopped\"></span>paused</td><td>50.0 s</td><td>50.0 %") == 1);
}

TEST_CASE("A print that took no time has no time line") {
  CHECK(state_time_line({}).empty());
  CHECK(state_table({}).empty());
}

TEST_CASE("Prints of any length have a few labels, and numbers that a browser draws") {
  for (const Duration length : {Duration(1ns), Duration(3ms), Duration(7s), Duration(50min), Duration(11h),
                                Duration(24h * 9), Duration(24h * 900)}) {
    PrintReport report;
    report.states = StateTimes(kStart);
    report.states.enter(PrintState::Exposing, kStart);
    report.states.enter(PrintState::Idle, kStart + length);
    const std::string svg = state_time_line(report);
    CAPTURE(svg);
    CHECK(count(svg, "<text") >= 1);
    CHECK(count(svg, "<text") <= 8);
    CHECK(count(svg, "nan") == 0);
    CHECK(count(svg, "inf") == 0);
  }
}

TEST_CASE("A thousand stops have a bounded number of marks") {
  PrintReport report = paused_print();
  report.stops.pauses.assign(1000, {3, 40s, 1s});
  report.stops.interruptions.assign(1000, {3, 40s, std::string(100'000, 'x')});
  const std::string svg = state_time_line(report);
  CHECK(count(svg, "class=\"pause\"") == 100);
  CHECK(count(svg, "class=\"interruption\"") == 100);
  CHECK(svg.size() < 100'000);
}
