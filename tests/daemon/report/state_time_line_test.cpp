#include "daemon/report/state_time_line.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/report/print_state.hpp"
#include "tests/daemon/report/report_fixture.hpp"

namespace {

constexpr TimePoint kPrintStart{std::chrono::hours(1000)};

PrintReport paused_print() {
  PrintReport report;
  report.states = StateTimes(kPrintStart);
  report.states.enter(print_state("homing"), kPrintStart);
  report.states.enter(print_state("exposing"), kPrintStart + 10s);
  report.states.enter(print_state("paused"), kPrintStart + 40s);
  report.states.enter(print_state("lowering"), kPrintStart + 90s);
  report.states.enter(kIdle, kPrintStart + 100s);
  report.stops.pauses.push_back({3, 40s, 50s});
  report.stops.interruptions.push_back({3, 39s, "the lid <b>was</b> opened"});
  return report;
}

}  // namespace

TEST_CASE("The time line has a shape for each activity, and a mark for each stop") {
  const std::string svg = state_time_line(paused_print());
  for (const char* activity : {"preparing", "exposing", "moving", "stopped"})
    CHECK(testing::occurrences(svg, std::string("<title>") + activity + "</title>") == 1);
  CHECK(testing::occurrences(svg, "<title>waiting</title>") == 0);
  CHECK(testing::occurrences(svg, "<title>layer 4: stopped for 50.0 s</title>") == 1);
  CHECK(testing::occurrences(svg, "layer 4: the lid &lt;b&gt;was&lt;/b&gt; opened") == 1);
  CHECK(testing::occurrences(svg, "<b>") == 0);
}

TEST_CASE("The table has a row for each state that was entered, with its share of the total") {
  const std::string table = state_table(paused_print().states);
  CHECK(testing::occurrences(table, "<tr>") == 5);
  CHECK(testing::occurrences(table, "exposing\"></span>exposing</td><td>30.0 s</td><td>30.0 %") == 1);
  CHECK(testing::occurrences(table, "stopped\"></span>paused</td><td>50.0 s</td><td>50.0 %") == 1);
}

TEST_CASE("A print that took no time has no time line") {
  CHECK(state_time_line({}).empty());
  CHECK(state_table({}).empty());
}

TEST_CASE("Time lines of any length have at most eight labels, and only finite numbers") {
  for (const Duration length : {Duration(1ns), Duration(3ms), Duration(7s), Duration(50min), Duration(11h),
                                Duration(24h * 9), Duration(24h * 900)}) {
    PrintReport report;
    report.states = StateTimes(kPrintStart);
    report.states.enter(print_state("exposing"), kPrintStart);
    report.states.enter(kIdle, kPrintStart + length);
    const std::string svg = state_time_line(report);
    CAPTURE(svg);
    CHECK(testing::occurrences(svg, "<text") >= 1);
    CHECK(testing::occurrences(svg, "<text") <= 8);
    CHECK(testing::occurrences(svg, "nan") == 0);
    CHECK(testing::occurrences(svg, "inf") == 0);
  }
}

TEST_CASE("The number of marks is limited, even for a thousand stops") {
  PrintReport report = paused_print();
  report.stops.pauses.assign(1000, {3, 40s, 1s});
  report.stops.interruptions.assign(1000, {3, 40s, std::string(100'000, 'x')});
  const std::string svg = state_time_line(report);
  CHECK(testing::occurrences(svg, "class=\"pause\"") == 100);
  CHECK(testing::occurrences(svg, "class=\"interruption\"") == 100);
  CHECK(svg.size() < 100'000);
}
