#include "daemon/print/rise_forecast.hpp"

#include <array>
#include <numeric>
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

TEST_CASE("A print without a rise is layered, and the reason is that it is too low or too wide") {
  const ResinProfile resin = window_resin();
  CHECK(why_no_rise({kCoarseDisplay, Nanometers{50'000}, Nanometers{300'000}}, resin) ==
        "the print is layered, not continuous: it is 0.30 mm high, and above its first layers, 0.95 mm, the "
        "plate would have to rise 1 mm");
  CHECK(lacking(why_no_rise({kCoarseDisplay, Nanometers{50'000}, mm(2)}, resin),
                {"rise 1 mm", "5 mm/h", "too wide", "oxygen"}) == "");
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

// Returns a plan for layers and rises, and the times of its layers, all alike if printed one by one.
struct PlannedParts {
  PrintPlan plan;
  std::vector<Duration> times;
};
PlannedParts parts_of(std::vector<RisePlan> rises, std::int64_t layers, Nanometers thickness) {
  PlannedParts parts;
  parts.plan.expected_layers.assign(static_cast<std::size_t>(layers), thickness);
  parts.times.assign(static_cast<std::size_t>(layers), Duration{5s});
  parts.plan.rises.emplace().each = rises_between(std::move(rises), parts.plan.expected_layers, parts.times,
                                                  window_resin().continuous.value());
  return parts;
}
// Returns the layers' times, with those of the rises, without any moves around them.
std::vector<Duration> times_of(const PlannedParts& parts) {
  std::vector<Duration> times = parts.times;
  const std::vector<Nanometers>& layers = parts.plan.expected_layers;
  for (const PlannedRise& rise : parts.plan.rises->each) {
    Nanometers bottom = rise.plan.points.front().height;
    for (auto i = static_cast<std::size_t>(rise.first_layer);
         i < layers.size() && bottom < rise.plan.points.back().height; ++i) {
      times[i] = std::chrono::duration_cast<Duration>(duration(rise.plan, bottom, bottom + layers[i]));
      if (i == static_cast<std::size_t>(rise.first_layer)) times[i] += rise.rest;
      bottom += layers[i];
    }
  }
  return times;
}
Duration sum_of(const std::vector<Duration>& times) {
  return std::accumulate(times.begin(), times.end(), Duration{});
}

TEST_CASE("A part is layered at first, rests, and has the times of its layers, rises and rests") {
  ContourEngine engine = testing::engine_for(models::box({-3, -3, 0}, {3, 3, 30}), {kCoarseDisplay});
  StopCheck never;
  const std::vector<RiseSlab> slabs = continuous_slabs(engine, {kCoarseDisplay, Nanometers{50'000}, mm(30)},
                                                       window_resin(), kWindowPrinter, never);
  const PlannedParts parts = parts_of(
      rises_through(slabs, Nanometers{50'000}, window_resin(), kWindowPrinter), 600, Nanometers{50'000});
  const std::vector<Duration> times = times_of(parts);
  const std::vector<ContinuousRange> ranges = ranges_of(parts.plan, times);
  REQUIRE(ranges.size() == 3);
  // 0.94 mm are 19 layers.
  CHECK_FALSE(ranges[0].limit);
  CHECK(ranges[0].top >= Nanometers{950'000});
  CHECK(ranges[0].top < Nanometers{1'050'000});
  CHECK(ranges[0].time == 5s * (ranges[0].top / Nanometers{50'000}));
  CHECK(ranges[1].bottom == ranges[0].top);
  CHECK(ranges[1].limit == RiseLimit::Cure);
  CHECK(ranges[1].fastest.count() * 3600 == Approx(55.26).epsilon(1e-3));
  CHECK(ranges[1].rest == 2min);
  CHECK(ranges[1].time <= 20min);
  CHECK(ranges[2].rest == Duration{});
  CHECK(ranges[2].top == mm(30));
  const ContinuousForecast forecast{rise_bounds(window_resin(), kWindowPrinter), ranges};
  CHECK(std::chrono::abs(forecast.time() - sum_of(times)) < 1us);
}

TEST_CASE("Rises rest before the window's oxygen is used up, less by the time of the layers between them") {
  const auto rise = [](std::int64_t from_mm, std::int64_t to_mm, double speed_mm_s) {
    const RiseLimit cure = RiseLimit::Cure;
    const MillimetersPerSecond at_rest{}, speed{speed_mm_s};
    return RisePlan{{{mm(from_mm), at_rest, cure},
                     {mm(from_mm) + Nanometers{1}, speed, cure},
                     {mm(to_mm) - Nanometers{1}, speed, cure},
                     {mm(to_mm), at_rest, cure}}};
  };
  // The window lasts for 20 minutes and recovers in 2. A millimetre at 0.002 mm/s takes 500 s.
  const auto rests = [&](std::vector<RisePlan> rises) {
    std::vector<Duration> found;
    const PlannedParts parts = parts_of(std::move(rises), 60, mm(1));
    for (const PlannedRise& each : parts.plan.rises->each)
      found.push_back(each.rest);
    return found;
  };
  CHECK(rests({rise(1, 3, 0.002), rise(3, 4, 0.002)}) == std::vector<Duration>{0s, 2min});
  CHECK(rests({rise(1, 2, 0.002), rise(2, 3, 0.002)}) == std::vector<Duration>{0s, 0s});
  CHECK(rests({rise(1, 2, 0.002), rise(3, 4, 0.002), rise(6, 7, 0.002), rise(7, 8, 0.002)}) ==
        std::vector<Duration>{0s, 0s, 2min - 10s, 0s});
  CHECK(rests({rise(1, 3, 0.002), rise(27, 28, 0.002), rise(28, 29, 0.002)}) ==
        std::vector<Duration>{0s, 0s, 0s});  // 24 layers take the 2 minutes
  const PlannedParts parted = parts_of({rise(1, 2, 0.002), rise(4, 5, 0.002)}, 60, mm(1));
  CHECK(parted.plan.rises->each[0].first_layer == 1);
  CHECK(parted.plan.rises->each[1].first_layer == 4);
  CHECK(contract_broken_by([&] {
          (void)rises_between({}, std::array{mm(1)}, {}, *window_resin().continuous);
        }) == "each layer has a time");
  const std::array layers{mm(3), mm(3)};
  const std::array times{Duration{5s}, Duration{5s}};
  CHECK(contract_broken_by([&] {
          (void)rises_between({rise(1, 2, 0.002)}, layers, times, *window_resin().continuous);
        }) == "a rise begins on top of a layer");
}

TEST_CASE("A warning names layers above the first ones if they are more than a millimetre high") {
  ContinuousForecast forecast;
  forecast.ranges = {{.bottom = {}, .top = mm(1)},
                     {.bottom = mm(1), .top = mm(5), .limit = RiseLimit::Cure},
                     {.bottom = mm(5), .top = mm(7)},
                     {.bottom = mm(7), .top = mm(20), .limit = RiseLimit::Cure}};
  CHECK(layered_parts_sentence(forecast, mm(1)) ==
        "3.00 of 20.00 mm are printed layer by layer, such as from 5.00 to 7.00 mm, because the plate cannot "
        "rise there without a stop");
  forecast.ranges[2].top = mm(6);
  CHECK(layered_parts_sentence(forecast, mm(1)) == "");
}

TEST_CASE("A rise with several limits has a range for each, and layers between rises") {
  const auto at = [](double height_mm, double speed_mm_s, RiseLimit limit) {
    return RisePoint{*to_nanometers(Millimeters{height_mm}), MillimetersPerSecond{speed_mm_s}, limit};
  };
  const PlannedParts parts =
      parts_of({RisePlan{{at(1, 0, RiseLimit::Machine), at(1.000001, 0.01, RiseLimit::Cure),
                          at(2, 0.01, RiseLimit::Machine), at(2.000001, 0.002, RiseLimit::Refill),
                          at(3, 0.002, RiseLimit::Machine), at(3.000001, 0.004, RiseLimit::Refill),
                          at(4, 0.004, RiseLimit::Machine), at(4.000001, 0, RiseLimit::Machine)}},
                RisePlan{{at(6, 0, RiseLimit::Machine), at(7, 0.02, RiseLimit::Machine),
                          at(8, 0, RiseLimit::Machine)}}},
               10, mm(1));
  std::vector<Duration> times = times_of(parts);
  times[1] += 12s;  // moves before the first rise
  const std::vector<ContinuousRange> ranges = ranges_of(parts.plan, times);
  REQUIRE(ranges.size() == 6);
  CHECK(ranges[0].time == 5s);
  CHECK(ranges[1].limit == RiseLimit::Cure);
  CHECK(ranges[1].slowest.count() == 0.01);
  CHECK(std::chrono::abs(ranges[1].time - 112s) < 10ms);
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
  CHECK(contract_broken_by([&] { (void)ranges_of(parts.plan, {}); }) == "each layer has a time");
}

}  // namespace
}  // namespace contourd
