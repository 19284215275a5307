#include "daemon/report/print_record.hpp"

#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/late_machine.hpp"
#include "tests/daemon/report/print_state.hpp"

namespace {

class PrintRecordFixture {
 public:
  PrintRecordFixture() { machine.axis.late.count = 5; }
  [[nodiscard]] PrintRecord begin() { return {machine, clock, "masks/part"}; }

  VirtualClock clock;
  SimulatedPrinter printer{clock, {}};
  testing::LateMachine machine{printer};
};

LayerRecord layer(std::int32_t number) {
  LayerRecord record;
  record.layer = number;
  return record;
}

}  // namespace

TEST_CASE_METHOD(PrintRecordFixture, "A record counts only the late steps of its own print") {
  PrintRecord record = begin();
  machine.axis.late.count = 12;
  CHECK(record.take_report().late_steps == 7);
}

TEST_CASE_METHOD(PrintRecordFixture,
                 "A record contains all late steps of an axis that was opened again and counts from 0") {
  PrintRecord record = begin();
  machine.axis.late.count = 2;
  CHECK(record.take_report().late_steps == 2);
}

TEST_CASE_METHOD(PrintRecordFixture, "A record keeps the longest turn of the event loop with light") {
  PrintRecord record = begin();
  record.add_lit_turn({"a client", 3ms, 1ms});
  record.add_lit_turn({"the spool", 9ms, 2ms});
  record.add_lit_turn({"a timer", 4ms, 4ms});
  const PrintReport report = record.take_report();
  CHECK(report.busiest_lit.source == "the spool");
  CHECK(report.busiest_lit.busy == 9ms);
}

TEST_CASE_METHOD(PrintRecordFixture,
                 "A record lists a layer's change of a setting once, unless it was taken back") {
  PrintRecord record = begin();
  record.add(SettingChange{3, "rest", 700, 500});
  record.add(SettingChange{3, "rest", 800, 700});
  record.add(SettingChange{3, "lift", 5, 6});
  record.add(SettingChange{4, "rest", 900, 800});
  record.add(SettingChange{3, "lift", 6, 5});
  record.add(SettingChange{5, "rest", 900, 900});
  const std::vector<SettingChange> changes = record.take_report().changes;
  CHECK(changes == std::vector<SettingChange>{{3, "rest", 800, 500}, {4, "rest", 900, 800}});
  CHECK(describe(changes) ==
        "from layer 4 on rest 800 ms instead of 500 ms; from layer 5 on rest 900 ms instead of 800 ms");
}

TEST_CASE_METHOD(
    PrintRecordFixture,
    "Each change of a setting begins with the value of the change before, also for an earlier layer") {
  PrintRecord record = begin();
  const Nanometers low{1'000'000}, high{2'000'000};
  record.add(SettingChange{3, "margin", 3, 4, low});
  record.add(SettingChange{3, "margin", 2, 3, high});
  record.add(SettingChange{3, "margin", 5, 2, low});
  const std::vector<SettingChange> changes = record.take_report().changes;
  REQUIRE(changes.size() == 3);
  CHECK(changes[1].before == changes[0].value);
  CHECK(changes[2].before == changes[1].value);
}

TEST_CASE_METHOD(PrintRecordFixture, "A changed plan of the rises ends where the next one begins") {
  PrintRecord record = begin();
  const auto changed = [](std::int64_t from_um, double margin) {
    const Nanometers from{from_um * 1000}, top{5'000'000};
    ContinuousRange range{.bottom = from, .top = top, .limit = RiseLimit::Cure};
    range.time = std::chrono::seconds(8);
    return ChangedForecast{from, {.margin = margin}, {{}, {range}}};
  };
  for (const std::int64_t from_um : {1000, 3000, 3000})
    record.add(changed(from_um, static_cast<double>(from_um)));
  record.add(ChangedForecast{Nanometers{4'999'000}, {}, {}});  // no rise is left
  const std::vector<ChangedForecast> plans = record.take_report().changed_rises;
  REQUIRE(plans.size() == 2);
  CHECK(plans[0].plan.ranges.front().top == Nanometers{3'000'000});
  CHECK(plans[0].plan.time() == std::chrono::seconds(4));
  CHECK(plans[1].from == Nanometers{3'000'000});
  CHECK(plans[1].plan.time() == std::chrono::seconds(8));
}

TEST_CASE_METHOD(PrintRecordFixture, "A record keeps layers and interruptions in order") {
  PrintRecord record = begin();
  record.add(layer(0));
  record.add_interruption(1, "the lid was opened");
  record.add(layer(1));
  record.add_interruption(1, "the display was lost");
  CHECK(record.layers().size() == 2);
  const PrintReport report = record.take_report();
  REQUIRE(report.layers.size() == 2);
  CHECK(report.layers[1].layer == 1);
  REQUIRE(report.stops.interruptions.size() == 2);
  CHECK(report.stops.interruptions[0].layer == 1);
  CHECK(report.stops.interruptions[0].what == "the lid was opened");
  CHECK(report.stops.interruptions[1].what == "the display was lost");
  CHECK(report.masks == "masks/part");
}

TEST_CASE_METHOD(PrintRecordFixture, "A record measures time by the machine's clock") {
  PrintRecord record = begin();
  const auto timer = clock.call_at(clock.now() + 90s, [] {});
  CHECK(clock.run_next());
  CHECK(record.elapsed() == 90s);
  CHECK(record.take_report().print_time == 90s);
}

TEST_CASE_METHOD(PrintRecordFixture, "A record contains each pause with its layer, start and duration") {
  PrintRecord record = begin();
  const auto go_on_for = [&](Duration duration) {
    const auto timer = clock.call_at(clock.now() + duration, [] {});
    REQUIRE(clock.run_next());
  };
  record.enter(print_state("exposing"), 6);
  go_on_for(20s);
  record.enter(print_state("paused"), 6);
  go_on_for(60s);
  record.enter(print_state("paused"), 6);  // interrupted there
  go_on_for(30s);
  record.enter(print_state("awaiting dark"), 6);
  go_on_for(10s);
  record.enter(print_state("held"), 7);
  go_on_for(5s);
  const PrintReport report = record.take_report();
  REQUIRE(report.stops.pauses.size() == 2);
  CHECK(report.stops.pauses[0].layer == 6);
  CHECK(report.stops.pauses[0].at == 20s);
  CHECK(report.stops.pauses[0].lasted == 90s);
  CHECK(report.stops.pauses[1].layer == 7);
  CHECK(report.stops.pauses[1].lasted == 5s);
  CHECK(testing::time_in(report.states, "exposing") == 20s);
  CHECK(testing::time_in(report.states, "paused") == 90s);
  CHECK(report.states.total() == 125s);
}

TEST_CASE_METHOD(PrintRecordFixture, "A record keeps a limited number of stops and counts the others") {
  PrintRecord record = begin();
  for (std::size_t i = 0; i < PrintStops::kMost + 7; ++i) {
    record.add_interruption(2, "the lid was opened");
    record.enter(print_state("paused"), 2);
    record.enter(print_state("awaiting dark"), 2);
  }
  const PrintStops stops = record.take_report().stops;
  CHECK(stops.interruptions.size() == PrintStops::kMost);
  CHECK(stops.more_interruptions == 7);
  CHECK(stops.pauses.size() == PrintStops::kMost);
  CHECK(stops.more_pauses == 7);
}
