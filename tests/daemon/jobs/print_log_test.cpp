#include "daemon/jobs/print_log.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/report/print_state.hpp"

namespace {

constexpr Duration kFrame = 16ms;

class PrintLogFixture {
 public:
  PrintLogFixture() {
    summary.models.resize(1);
    summary.layers.count = 10;
    summary.resin.tolerance.bounds = 100ms;
    layer.exposure_asked = layer.exposure_least = layer.exposure_most = 2000ms;
    layer.complete = true;
    layer.area_mm2 = 4;
  }
  void log_layer() const { print.layer("part", summary, layer, kFrame); }
  [[nodiscard]] bool warned() const { return text.has("warning"); }

  EventLoop loop;
  testing::LogText text{loop};
  PrintLog print{text.log};
  JobSummary summary;
  LayerRecord layer;
};

}  // namespace

TEST_CASE("A layer is one line, counted from 1, with one figure for light that is known exactly") {
  PrintLogFixture fixture;
  fixture.layer.layer = 6;
  fixture.layer.plate_height = Nanometers{350'000};
  fixture.log_layer();
  CHECK(fixture.text.has("info: layer 7 of 10: height 0.3500 mm, 4.00 mm²"));
  CHECK(fixture.text.has("light 2000.0 ms\n"));
  CHECK_FALSE(fixture.warned());
}

TEST_CASE("Light that is not known exactly is logged with its bounds") {
  PrintLogFixture fixture;
  fixture.layer.exposure_least = 1980ms;
  fixture.layer.complete = fixture.layer.dark_confirmed = false;
  fixture.log_layer();
  CHECK(fixture.text.has("light 1980.0 to 2000.0 ms or more, not finished"));
}

TEST_CASE("Light that lasted too long by more than one refresh causes a warning") {
  PrintLogFixture fixture;
  fixture.layer.exposure_least = fixture.layer.exposure_most = 2000ms + kFrame;
  SECTION("by one refresh") {
    fixture.log_layer();
    CHECK_FALSE(fixture.warned());
  }
  SECTION("by more") {
    fixture.layer.exposure_least = fixture.layer.exposure_most += 1ms;
    fixture.log_layer();
    CHECK(fixture.text.has("warning: layer 1: the light was on for 2017.0 ms, 2000.0 ms were asked for"));
  }
}

TEST_CASE("Light that is known less exactly than the resin tolerates causes a warning") {
  PrintLogFixture fixture;
  fixture.layer.exposure_least = 1900ms;
  SECTION("as exactly") {
    fixture.log_layer();
    CHECK_FALSE(fixture.warned());
  }
  SECTION("less exactly") {
    fixture.layer.exposure_least -= 1ms;
    fixture.log_layer();
    CHECK(fixture.text.has("the projector's replies allow no closer bounds, and the resin tolerates 100 ms"));
  }
}

TEST_CASE("A picture that came more than a refresh late causes a warning") {
  PrintLogFixture fixture;
  fixture.layer.pictures = 12;
  fixture.layer.light_error = 0.009;
  fixture.layer.late_picture = kFrame;
  fixture.log_layer();
  CHECK(fixture.text.has("12 pictures that give pixels their light to 0.9 % of white's"));
  CHECK_FALSE(fixture.warned());
  fixture.layer.late_picture = 40ms;
  fixture.log_layer();
  CHECK(fixture.text.has(
      "warning: layer 1: a picture of its exposure came 40.0 ms late: pixels that it darkens "
      "got up to 2.0 % more of white's light than planned"));
}

TEST_CASE(
    "Layers that are empty, cracked or without their undersides cause one warning of each kind, at the end "
    "of the print") {
  PrintLogFixture fixture;
  PrintReport report;
  report.job = "part";
  report.summary = fixture.summary;
  report.summary.layers.count = 300;
  for (fixture.layer.layer = 0; fixture.layer.layer < 300; ++fixture.layer.layer) {
    const bool affected = fixture.layer.layer >= 100 && fixture.layer.layer < 200;
    fixture.layer.cracks.open_chains = affected ? 2 : 0;
    fixture.layer.cracks.widest_gap = Millimeters{affected ? fixture.layer.layer / 1000.0 : 0.0};
    fixture.layer.cracks.turned_chains = fixture.layer.layer == 5 ? 3 : 0;
    fixture.layer.area_mm2 = fixture.layer.layer < 298 ? 4 : 0;
    fixture.layer.undersides_found = fixture.layer.layer % 2 == 0;
    fixture.log_layer();
    report.layers.push_back(fixture.layer);
  }
  CHECK_FALSE(fixture.warned());
  fixture.print.ended(report);
  CHECK(
      fixture.text.has("warning: part: 100 of 300 layers, from layer 101 to 200: contours did not close; the "
                       "widest gap bridged is 0.199 mm"));
  CHECK(
      fixture.text.has("warning: part: 1 of 300 layers, from layer 6 to 6: sections of contours run in the "
                       "wrong direction"));
  CHECK(
      fixture.text.has("warning: part: 150 of 300 layers, from layer 2 to 300: undersides kept all their "
                       "light, because they were not found within mask_budget_ms"));
  // The last layer may be empty.
  CHECK(fixture.text.has("warning: part: 1 of 300 layers, from layer 299 to 299: nothing to expose"));
}

TEST_CASE(
    "Layers whose exposures were too short for their pictures cause one warning, at the end of the print") {
  PrintLogFixture fixture;
  PrintReport report;
  report.job = "part";
  report.summary = fixture.summary;
  for (const double error : {0.01, 0.05, 0.02, 0.0}) {
    fixture.layer.light_error = error;
    report.layers.push_back(fixture.layer);
    ++fixture.layer.layer;
  }
  fixture.print.ended(report);
  CHECK(fixture.text.has(
      "warning: part: 2 of 4 layers, from layer 2 to 3: exposures too short for more pictures: "
      "pixels get their light to 5.0 % of white's"));
}

TEST_CASE("Sound layers cause no warning at the end of the print") {
  PrintLogFixture fixture;
  PrintReport report;
  report.summary = fixture.summary;
  report.layers.push_back(fixture.layer);
  fixture.print.ended(report);
  CHECK_FALSE(fixture.warned());
}

TEST_CASE("Only the first warnings about a model are logged, and the number of the others") {
  PrintLogFixture fixture;
  fixture.summary.resin.exposure = FixedExposure{2s};
  fixture.summary.layers.thinnest = fixture.summary.layers.thickest = Nanometers{50'000};
  fixture.summary.irradiance_mw_cm2 = 5;
  for (int i = 1; i <= 23; ++i)
    fixture.summary.warnings.push_back("warning " + std::to_string(i) + ";");
  fixture.print.ready("part", fixture.summary, 12ms);
  CHECK(fixture.text.has("first mask after 12 ms"));
  CHECK_FALSE(fixture.text.has("while it waited"));
  fixture.summary.prepared_before = true;
  fixture.print.ready("part", fixture.summary, 0ms);
  CHECK(fixture.text.has("first mask after 0 ms, prepared while it waited"));
  CHECK(fixture.text.has("part: warning 20;"));
  CHECK_FALSE(fixture.text.has("part: warning 21;"));
  CHECK(fixture.text.has("warning: part: and 3 more"));
}

TEST_CASE("Only states that last, or that the user should know of, are logged") {
  const PrintLogFixture fixture;
  fixture.print.entered("part", print_state("exposing"));
  CHECK_FALSE(fixture.text.has("part"));
  fixture.print.entered("part", print_state("homing"));
  CHECK(fixture.text.has("info: part: homing"));
}

TEST_CASE("The log of an interruption says whether the light is known to be off") {
  const PrintLogFixture fixture;
  fixture.print.interrupted("part", 6, "the lid was opened", true);
  CHECK(fixture.text.has(
      "warning: part: layer 7: the lid was opened; the light is off; \"contourctl resume\""));
  fixture.print.interrupted("part", 6, "the lid was opened", false);
  CHECK(fixture.text.has("the lid was opened; light off was sent;"));
}

TEST_CASE("A failed print is logged as an error with its reason, and a finished one as information") {
  PrintLogFixture fixture;
  PrintReport report;
  report.job = "part";
  report.summary = fixture.summary;
  report.layers.push_back(fixture.layer);
  SECTION("failed") {
    report.reason = "the sky fell";
    fixture.print.ended(report);
    CHECK(fixture.text.has("error: part: failed after 1 of 10 layers and 0.0 s: the sky fell"));
  }
  SECTION("done") {
    report.outcome = PrintOutcome::Done;
    fixture.print.ended(report);
    CHECK(fixture.text.has("info: part: done after 1 of 10 layers and 0.0 s\n"));
  }
}

TEST_CASE("The end of a print warns of late steps, and of an event loop that was busy for too long") {
  PrintLogFixture fixture;
  PrintReport report;
  report.job = "part";
  report.outcome = PrintOutcome::Done;
  report.busiest_lit = {"the spool", kLongestLitTurn, 1ms};
  fixture.print.ended(report);
  CHECK_FALSE(fixture.warned());
  report.late_steps = 3;
  report.busiest_lit.busy += 1ms;
  fixture.print.ended(report);
  CHECK(fixture.text.has("warning: part: 3 steps of the motor came late"));
  CHECK(fixture.text.has("warning: part: the spool kept the event loop busy for 11.0 ms, of which 1.0 ms"));
}
