#include "daemon/print/rise_progress.hpp"

#include <cmath>

#include "hw/rise_curve.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace contourd {
namespace {

using contourd::testing::Approx;
using namespace std::chrono_literals;

RisePoint point(double height_mm, double speed_mm_s) {
  return {Nanometers{std::llround(height_mm * 1e6)}, MillimetersPerSecond{speed_mm_s}, RiseLimit::Cure};
}

// From 1 to 3 mm, at 0.1 and then at 0.02 mm/s, with ramps of 0.1 mm.
RisePlan two_speeds() {
  return {{point(1, 0), point(1.1, 0.1), point(2, 0.1), point(2.1, 0.02), point(2.9, 0.02), point(3, 0)}};
}

TEST_CASE("A capped rise is the planned one where that is slower, with the same ramps") {
  const RisePlan plan = two_speeds(), slower = capped(plan, MillimetersPerSecond{0.05});
  for (double height = 1; height <= 3; height += 0.01) {
    CAPTURE(height);
    const Nanometers at{std::llround(height * 1e6)};
    const double expected = std::min(speed_at(plan, at).count(), 0.05);
    CHECK(speed_at(slower, at).count() == Approx(expected).margin(1e-5));  // heights are whole nanometres
  }
  CHECK(slower.points.size() == 8);
  CHECK(can_follow(slower, MillimetersPerSecond{0.05}, MillimetersPerSecondSquared{0.0501}));
  CHECK(capped(plan, MillimetersPerSecond{0.1}) == plan);
  CHECK(contract_broken_by([&] { (void)capped(plan, {}); }) == "a rise has a plan and a speed");
}

TEST_CASE("A print goes from layers to rises, rests once, and is layered above its last rise") {
  const auto rise = [](double from, double to, Duration rest) {
    return PlannedRise{{{point(from, 0), point(from + 0.1, 0.1), point(to, 0)}}, 1, rest};
  };
  RiseProgress rises(PlannedRises{.each = {rise(1, 2, 0s), rise(2, 3, 5s), rise(4, 5, 0s)}}, {});
  CHECK(rises.next() == NextPart::Layers);
  rises.reach();
  CHECK(rises.next() == NextPart::Rise);
  rises.begin();
  rises.stop_at(Nanometers{1'500'000});
  CHECK(rises.begun());
  CHECK(rises.rest().points.front().height == Nanometers{1'500'000});
  rises.stop_at(Nanometers{2'000'000});
  CHECK_FALSE(rises.begun());
  CHECK(rises.next() == NextPart::Rest);
  const TimePoint began{100s};
  CHECK(rises.rest_until(began) == began + 5s);
  CHECK(rises.rest_until(began + 60s) == began + 5s);
  rises.begin();
  rises.stop_at(Nanometers{3'000'000});
  CHECK(rises.next() == NextPart::Layers);
  rises.reach();
  rises.begin();
  rises.stop_at(Nanometers{5'000'000});
  CHECK_FALSE(rises.any_left());
  CHECK(rises.next() == NextPart::Layers);
}

TEST_CASE("A print that goes on higher up begins with the rises that are left") {
  const PlannedRises all{.each = {{two_speeds(), 1, {}}}};
  CHECK(RiseProgress(all, Nanometers{1'000'000}).next() == NextPart::Rise);
  CHECK(RiseProgress(all, {}).any_left());
  CHECK_FALSE(RiseProgress(all, Nanometers{3'000'000}).any_left());
}

TEST_CASE("A rise is slowed down by steps to its slowest speed, once a second at most") {
  RiseProgress rises(PlannedRises{.each = {{two_speeds(), 1, {}}}}, Nanometers{1'000'000});
  const MillimetersPerSecond slowest{0.07};
  rises.begin();
  const TimePoint start{100s};
  CHECK(rises.longest(slowest) > duration(two_speeds()));
  CHECK(rises.slow_down(Nanometers{1'010'000}, slowest, start));  // in the ramp, but by the speed after it
  rises.stop_at(Nanometers{1'010'000});
  CHECK(speed_at(rises.rest(), Nanometers{1'500'000}).count() == Approx(0.075));
  CHECK_FALSE(rises.slow_down(Nanometers{1'500'000}, slowest, start + 999ms));
  CHECK(rises.slow_down(Nanometers{1'500'000}, slowest, start + 1s));
  rises.stop_at(Nanometers{1'510'000});
  CHECK(speed_at(rises.rest(), Nanometers{1'700'000}).count() == Approx(0.07));
  CHECK_FALSE(rises.slow_down(Nanometers{1'700'000}, slowest, start + 3s));
}

}  // namespace
}  // namespace contourd
