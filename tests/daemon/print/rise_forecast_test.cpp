#include "daemon/print/rise_forecast.hpp"

#include <array>
#include <vector>

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/daemon/print/rise_fixture.hpp"

namespace contourd {
namespace {

using contourd::testing::Approx;
using contourd::testing::kCoarseDisplay;
using contourd::testing::kWindowPrinter;
using contourd::testing::mm;
using contourd::testing::window_resin;

TEST_CASE("The speed of the machine is that of its masks, its axis and the profile") {
  ResinProfile resin = window_resin();
  ContinuousMachine machine = kWindowPrinter;
  CHECK(rise_bounds(resin, machine).fastest.count() == Approx(0.12));
  machine.top_speed = MillimetersPerSecond{0.1};
  CHECK(rise_bounds(resin, machine).fastest.count() == Approx(0.1));
  resin.continuous->fastest = MillimetersPerSecond{0.05};
  CHECK(rise_bounds(resin, machine).fastest.count() == Approx(0.05));
  CHECK(rise_bounds(resin, machine).refill.viscosity_pa_s == Approx(0.2));
}

TEST_CASE("Coarse mask steps and microsteps slow the plate, so that no mask is over 5 um from it") {
  ResinProfile resin = window_resin();
  ContinuousMachine machine = kWindowPrinter;
  const auto a_refresh_um = [&] { return rise_bounds(resin, machine).fastest.count() * 1000 / 60; };
  resin.continuous->mask_step = Micrometers{3};
  CHECK(a_refresh_um() == Approx(2));  // 2.5 refreshes from rest to the first new mask
  resin.continuous->mask_step = Micrometers{4};
  CHECK(a_refresh_um() == Approx(1.25));
  machine.microstep = Micrometers{2.5};
  resin.continuous->mask_step = Micrometers{2};
  CHECK(a_refresh_um() == Approx(2));
  resin.continuous->mask_step = Micrometers{3};
  CHECK(continuous_refusal(resin, machine).empty());
  machine.microstep = Micrometers{10};
  CHECK(
      continuous_refusal(resin, machine) ==
      "a plate that moves in microsteps of 10 um cannot rise with a mask for every 3 um of the resin clear, "
      "because no mask may be more than 5 um from it: lower the resin's continuous/mask_step_um, use more "
      "microsteps, or print in layers");
}

TEST_CASE("A print without a rise is refused with the reason: too low, or no way up without a stop") {
  const ResinProfile resin = window_resin();
  CHECK(
      why_no_rise({kCoarseDisplay, Nanometers{50'000}, Nanometers{300'000}}, resin) ==
      "a print of 0.30 mm is too low for a continuous one: above its first layers, 0.95 mm, the plate would "
      "have to rise 1 mm: print it in layers (\"mode\": \"layered\")");
  CHECK(lacking(why_no_rise({kCoarseDisplay, Nanometers{50'000}, mm(2)}, resin),
                {"2.00 mm", "too wide", "oxygen"}) == "");
}

TEST_CASE("A resin that would rise too slowly everywhere is refused with the figures") {
  ResinProfile resin = window_resin();
  CHECK(continuous_refusal(resin, kWindowPrinter).empty());
  resin.continuous->margin = 50;
  CHECK(
      continuous_refusal(resin, kWindowPrinter) ==
      "the resin clear can rise at most at 4.42 mm/h, with a margin of 50, 4 mW/cm² and 60 masks/s, which is "
      "less than its continuous/least_speed_mm_h, 5: lower the margin or that speed, or print in layers");
  resin.viscosity_mpa_s.reset();
  CHECK(lacking(continuous_refusal(resin, kWindowPrinter), {"clear", "viscosity_mpa_s"}) == "");
  CHECK(contract_broken_by([&] { (void)rise_bounds(resin, kWindowPrinter); }) ==
        "the resin can be printed continuously");
}

TEST_CASE("A part is layered at first, rests, and has the times of its layers and rises") {
  ContourEngine engine = testing::engine_for(models::box({-3, -3, 0}, {3, 3, 30}), {kCoarseDisplay});
  StopCheck never;
  const std::vector<Nanometers> layers(600, Nanometers{50'000});
  const std::vector<Duration> times(600, Duration{5s});
  const std::vector<RisePlan> rises = plan_continuous(engine, {kCoarseDisplay, layers.front(), mm(30)},
                                                      window_resin(), kWindowPrinter, never);
  const std::vector<ContinuousRange> ranges = ranges_of(rises, layers, times);
  REQUIRE(ranges.size() == 3);
  // 0.94 mm are 19 layers.
  CHECK_FALSE(ranges[0].limit);
  CHECK(ranges[0].top >= Nanometers{950'000});
  CHECK(ranges[0].top < Nanometers{1'050'000});
  CHECK(ranges[0].time == 5s * (ranges[0].top / layers.front()));
  CHECK(ranges[1].bottom == ranges[0].top);
  CHECK(ranges[1].limit == RiseLimit::Cure);
  CHECK(ranges[1].fastest.count() * 3600 == Approx(55.26).epsilon(1e-3));
  CHECK(ranges[1].rests);
  CHECK(ranges[1].time <= 20min);
  CHECK_FALSE(ranges[2].rests);
  CHECK(ranges[2].top == mm(30));
}

TEST_CASE("The rise of a print is the last one, if it reaches the top") {
  const auto at = [](std::int64_t height_mm, double speed_mm_s) {
    return RisePoint{mm(height_mm), MillimetersPerSecond{speed_mm_s}, RiseLimit::Cure};
  };
  const std::vector<RisePlan> rises{{{at(1, 0), at(2, 0.01), at(4, 0)}}, {{at(6, 0), at(7, 0.02), at(9, 0)}}};
  const ContinuousSubject subject{kCoarseDisplay, Nanometers{50'000}, mm(9)};
  const std::optional<PlannedRise> rise = rise_to_top(rises, subject, *window_resin().continuous);
  REQUIRE(rise);
  CHECK(rise->plan == rises[1]);
  CHECK(rise->first_layers == 120);
  CHECK(rise->mask_step == Nanometers{2'000});
  CHECK_FALSE(rise_to_top(rises, {kCoarseDisplay, Nanometers{50'000}, mm(10)}, *window_resin().continuous));
  CHECK_FALSE(rise_to_top({}, subject, *window_resin().continuous));
  CHECK_FALSE(rise_to_top(rises, {kCoarseDisplay, Nanometers{70'000}, mm(9)}, *window_resin().continuous));
}

TEST_CASE("A rise with several limits has a range for each, and layers between rises") {
  const auto at = [](double height_mm, double speed_mm_s, RiseLimit limit) {
    return RisePoint{*to_nanometers(Millimeters{height_mm}), MillimetersPerSecond{speed_mm_s}, limit};
  };
  const std::array rises{RisePlan{{at(1, 0, RiseLimit::Machine), at(1.000001, 0.01, RiseLimit::Cure),
                                   at(2, 0.01, RiseLimit::Machine), at(2.000001, 0.002, RiseLimit::Refill),
                                   at(3, 0.002, RiseLimit::Machine), at(3.000001, 0.004, RiseLimit::Refill),
                                   at(4, 0.004, RiseLimit::Machine), at(4.000001, 0, RiseLimit::Machine)}},
                         RisePlan{{at(6, 0, RiseLimit::Machine), at(7, 0.02, RiseLimit::Machine),
                                   at(8, 0, RiseLimit::Machine)}}};
  const std::vector<Nanometers> layers(10, mm(1));
  const std::vector<Duration> times(10, Duration{5s});
  const std::vector<ContinuousRange> ranges = ranges_of(rises, layers, times);
  REQUIRE(ranges.size() == 6);
  CHECK(ranges[0].time == 5s);
  CHECK(ranges[1].limit == RiseLimit::Cure);
  CHECK(ranges[1].slowest.count() == 0.01);
  CHECK(ranges[2].limit == RiseLimit::Refill);
  CHECK(ranges[2].slowest.count() == 0.002);
  CHECK(ranges[2].fastest.count() == 0.004);
  CHECK(ranges[2].top == Nanometers{4'000'001});
  CHECK_FALSE(ranges[3].limit);
  CHECK(ranges[3].time == 5s);
  CHECK(ranges[4].limit == RiseLimit::Machine);
  CHECK(ranges[4].slowest.count() == 0.02);
  CHECK(ranges[5].bottom == mm(8));
  CHECK(ranges[5].time == 10s);
  CHECK_FALSE(ranges[2].rests);
  CHECK(contract_broken_by([&] { (void)ranges_of(rises, layers, {}); }) == "each layer has a time");
}

}  // namespace
}  // namespace contourd
