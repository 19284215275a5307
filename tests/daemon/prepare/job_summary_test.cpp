#include "daemon/prepare/job_summary.hpp"

#include "tests/catch.hpp"

TEST_CASE(
    "Corrections of contours and masks are described in one sentence, which is empty without corrections") {
  JobSummary summary;
  CHECK(describe_correction(summary).empty());
  summary.resin.compensation.growth = Micrometers{-50.0};
  CHECK(describe_correction(summary) == "contours moved inwards by 50 um");
  summary.resin.compensation.growth = Micrometers{50.0};
  summary.uniformity_mask = true;
  summary.tone.threshold = 12;
  CHECK(describe_correction(summary) ==
        "contours moved outwards by 50 um, uniformity mask applied, grey below 12 left dark");
}

TEST_CASE("The settings line has the resin's values, and the bottom layers' if there are any") {
  JobSummary summary;
  summary.layers.thinnest = summary.layers.thickest = Nanometers{50'000};
  summary.irradiance_mw_cm2 = 5;
  ResinProfile& resin = summary.resin;
  resin.name = "standard";
  resin.exposure = FixedExposure{.exposure = 3s, .bottom_exposure = 30s};
  resin.motion.settle = 1s;
  resin.motion.rest = 500ms;
  resin.bottom_layers = resin.fade_layers = 0;
  CHECK(describe_settings(summary).starts_with("standard: exposure 3000 ms; lift "));
  CHECK(describe_settings(summary).ends_with("wait 1000 ms before exposure, 500 ms after"));
  resin.motion.lift = Nanometers{2'000'000};
  resin.motion.lift_speed = MillimetersPerSecond{1.5};
  resin.motion.retract_speed = MillimetersPerSecond{4};
  CHECK(describe_settings(summary).find("; lift 2 mm at 1.5 mm/s, retract at 4 mm/s; ") != std::string::npos);
  resin.motion.second_lift = Nanometers{3'500'000};
  resin.motion.second_lift_speed = MillimetersPerSecond{5};
  resin.motion.slow_retract = Nanometers{500'000};
  resin.motion.slow_retract_speed = MillimetersPerSecond{0.8};
  CHECK(describe_settings(summary).find("; lift 2 mm at 1.5 mm/s, then 3.5 mm at 5 mm/s, retract at 4 mm/s, "
                                        "the last 0.5 mm at 0.8 mm/s; wait 1000 ms ") != std::string::npos);
  resin.viscosity_mpa_s = 200;
  CHECK(describe_settings(summary).ends_with(
      "wait 1000 ms before exposure, longer after large layers (200 mPa s), 500 ms after"));
  resin.viscosity_mpa_s.reset();
  std::get<FixedExposure>(resin.exposure).steps = {{Nanometers{2'500'000}, 4s},
                                                   {Nanometers{5'000'000}, 3500ms}};
  CHECK(describe_settings(summary).starts_with(
      "standard: exposure 3000 ms, 4000 ms from 2.5 mm, 3500 ms from 5 mm; lift "));
  std::get<FixedExposure>(resin.exposure).steps.clear();
  resin.bottom_layers = 5;
  resin.fade_layers = 10;
  CHECK(describe_settings(summary).starts_with(
      "standard: exposure 3000 ms, 30000 ms in 5 bottom layers, fading over 10; "));
  resin.mode = PrintWay::Continuous;
  CHECK(describe_settings(summary).ends_with("500 ms after; continuous"));
  resin.mode = PrintWay::Layered;
  resin.undersides = Undersides::Dose;
  CHECK(describe_settings(summary).ends_with("500 ms after; undersides by dose"));
  summary.overridden = {{"exposure_ms", 3000, 2500.5}, {"lift_mm", 8, 6}};
  CHECK(
      describe_settings(summary).ends_with("500 ms after; undersides by dose; by its ticket: exposure_ms "
                                           "3000 instead of 2500.5, lift_mm 8 instead of 6"));
}
