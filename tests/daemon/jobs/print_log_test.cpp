#include "daemon/jobs/print_log.hpp"

#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

constexpr Duration kFrame = 16ms;

class Desk {
 public:
  Desk() {
    summary.models.resize(1);
    summary.layers.count = 10;
    summary.resin.tolerance.bounds = 100ms;
    layer.exposure_asked = layer.exposure_least = layer.exposure_most = 2000ms;
    layer.complete = true;
    layer.area_mm2 = 4;
  }
  void tell_layer() const { print.layer("part", summary, layer, kFrame); }
  [[nodiscard]] bool warned() const { return text.has("warning"); }

  EventLoop loop;
  testing::LogText text{loop};
  PrintLog print{text.log};
  JobSummary summary;
  LayerRecord layer;
};

}  // namespace

TEST_CASE("A layer is one line, counted from 1, with one figure for light that is known exactly") {
  Desk desk;
  desk.layer.layer = 6;
  desk.layer.plate_height = Nanometers{350'000};
  desk.tell_layer();
  CHECK(desk.text.has("info: layer 7 of 10: height 0.3500 mm, 4.00 mm2"));
  CHECK(desk.text.has("light 2000.0 ms\n"));
  CHECK_FALSE(desk.warned());
}

TEST_CASE("Light that is not known exactly is told from its least to its most") {
  Desk desk;
  desk.layer.exposure_least = 1980ms;
  desk.layer.complete = desk.layer.dark_confirmed = false;
  desk.tell_layer();
  CHECK(desk.text.has("light 1980.0 to 2000.0 ms or more, not finished"));
}

TEST_CASE("Light that lasted longer by more than a refresh is warned of, and by no less") {
  Desk desk;
  desk.layer.exposure_least = desk.layer.exposure_most = 2000ms + kFrame;
  SECTION("by a refresh") {
    desk.tell_layer();
    CHECK_FALSE(desk.warned());
  }
  SECTION("by more") {
    desk.layer.exposure_least = desk.layer.exposure_most += 1ms;
    desk.tell_layer();
    CHECK(desk.text.has("warning: layer 1: the light was on for 2017.0 ms, 2000.0 ms were asked for"));
  }
}

TEST_CASE("Light that is known less well than the resin tolerates is warned of") {
  Desk desk;
  desk.layer.exposure_least = 1900ms;
  SECTION("as well") {
    desk.tell_layer();
    CHECK_FALSE(desk.warned());
  }
  SECTION("less well") {
    desk.layer.exposure_least -= 1ms;
    desk.tell_layer();
    CHECK(desk.text.has("the projector's answers are no more exact, and the resin tolerates 100 ms"));
  }
}

TEST_CASE("A layer in which contours did not close, were turned, or that is empty, is warned of") {
  Desk desk;
  SECTION("open") {
    desk.layer.cracks.open_chains = 2;
    desk.tell_layer();
    CHECK(desk.text.has("warning: layer 1: 2 contours did not close"));
  }
  SECTION("turned") {
    desk.layer.cracks.turned_chains = 3;
    desk.tell_layer();
    CHECK(desk.text.has("warning: layer 1: 3 stretches of contours are turned against the others"));
  }
  SECTION("empty") {
    desk.layer.area_mm2 = 0;
    desk.tell_layer();
    CHECK(desk.text.has("warning: layer 1: nothing to expose"));
  }
}

TEST_CASE("That the last layer is empty is not warned of") {
  Desk desk;
  desk.layer.layer = 9;
  desk.layer.area_mm2 = 0;
  desk.tell_layer();
  CHECK_FALSE(desk.warned());
}

TEST_CASE("Of a model's many warnings the first are told, and how many more there are") {
  Desk desk;
  desk.summary.resin.exposure = FixedExposure{2s};
  desk.summary.layers.thinnest = desk.summary.layers.thickest = Nanometers{50'000};
  desk.summary.irradiance_mw_cm2 = 5;
  for (int i = 1; i <= 23; ++i)
    desk.summary.warnings.push_back("warning " + std::to_string(i) + ";");
  desk.print.ready("part", desk.summary, 12ms);
  CHECK(desk.text.has("first mask after 12 ms"));
  CHECK_FALSE(desk.text.has("while it waited"));
  desk.summary.prepared_before = true;
  desk.print.ready("part", desk.summary, 0ms);
  CHECK(desk.text.has("first mask after 0 ms, prepared while it waited"));
  CHECK(desk.text.has("part: warning 20;"));
  CHECK_FALSE(desk.text.has("part: warning 21;"));
  CHECK(desk.text.has("warning: part: and 3 more"));
}

TEST_CASE("Only states that last, or that an owner should know of, are a line") {
  const Desk desk;
  desk.print.entered("part", PrintState::Exposing);
  CHECK_FALSE(desk.text.has("part"));
  desk.print.entered("part", PrintState::Homing);
  CHECK(desk.text.has("info: part: homing"));
}

TEST_CASE("An interruption tells whether the light is known to be off") {
  const Desk desk;
  desk.print.interrupted("part", 6, "the lid was opened", true);
  CHECK(desk.text.has("warning: part: layer 7: the lid was opened; the light is off; \"contourctl resume\""));
  desk.print.interrupted("part", 6, "the lid was opened", false);
  CHECK(desk.text.has("the lid was opened; light off is sent;"));
}

TEST_CASE("A failed print ends with an error and its reason, another with neither") {
  Desk desk;
  PrintReport report;
  report.job = "part";
  report.summary = desk.summary;
  report.layers.push_back(desk.layer);
  SECTION("failed") {
    report.reason = "the sky fell";
    desk.print.ended(report);
    CHECK(desk.text.has("error: part: failed after 1 of 10 layers and 0.0 s: the sky fell"));
  }
  SECTION("done") {
    report.outcome = PrintOutcome::Done;
    desk.print.ended(report);
    CHECK(desk.text.has("info: part: done after 1 of 10 layers and 0.0 s\n"));
  }
}

TEST_CASE("A print's end warns of late steps, and of a loop that was busy for longer than it may be") {
  Desk desk;
  PrintReport report;
  report.job = "part";
  report.outcome = PrintOutcome::Done;
  report.busiest_lit = {"the spool", kLongestLitTurn, 1ms};
  desk.print.ended(report);
  CHECK_FALSE(desk.warned());
  report.late_steps = 3;
  report.busiest_lit.busy += 1ms;
  desk.print.ended(report);
  CHECK(desk.text.has("warning: part: 3 steps of the motor came late"));
  CHECK(desk.text.has("warning: part: the spool kept the event loop busy for 11.0 ms, of which 1.0 ms"));
}
