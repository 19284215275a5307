#include "daemon/print_record.hpp"

#include <string>
#include <vector>

#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/late_machine.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

class Desk {
 public:
  Desk() { machine.axis.late.count = 5; }
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

TEST_CASE("A record counts the late steps of its print, and no others") {
  Desk desk;
  PrintRecord record = desk.begin();
  desk.machine.axis.late.count = 12;
  CHECK(record.take_report().late_steps == 7);
}

TEST_CASE("A record has all late steps of an axis that was opened again and counts anew") {
  Desk desk;
  PrintRecord record = desk.begin();
  desk.machine.axis.late.count = 2;
  CHECK(record.take_report().late_steps == 2);
}

TEST_CASE("A record keeps the longest turn with light") {
  Desk desk;
  PrintRecord record = desk.begin();
  record.add_lit_turn({"a client", 3ms, 1ms});
  record.add_lit_turn({"the spool", 9ms, 2ms});
  record.add_lit_turn({"a timer", 4ms, 4ms});
  const PrintReport report = record.take_report();
  CHECK(report.busiest_lit.source == "the spool");
  CHECK(report.busiest_lit.busy == 9ms);
}

TEST_CASE("A record tells layers and interruptions in their order, as people count them") {
  Desk desk;
  PrintRecord record = desk.begin();
  record.add(layer(0));
  record.add_interruption(1, "the lid was opened");
  record.add(layer(1));
  record.add_interruption(1, "the display was lost");
  CHECK(record.layers().size() == 2);
  const PrintReport report = record.take_report();
  REQUIRE(report.layers.size() == 2);
  CHECK(report.layers[1].layer == 1);
  CHECK(report.interruptions ==
        std::vector<std::string>{"layer 2: the lid was opened", "layer 2: the display was lost"});
  CHECK(report.masks == "masks/part");
}

TEST_CASE("A record's time is the machine's") {
  Desk desk;
  PrintRecord record = desk.begin();
  const auto timer = desk.clock.call_at(desk.clock.now() + 90s, [] {});
  CHECK(desk.clock.run_next());
  CHECK(record.elapsed() == 90s);
  CHECK(record.take_report().print_time == 90s);
}
