#include "core/continuous/rise_plan.hpp"

#include <cmath>

#include "tests/catch.hpp"

namespace {

using contourd::testing::Approx;

RisePoint point(double height_mm, double speed_mm_s, RiseLimit limit = RiseLimit::Cure) {
  return {*to_nanometers(Millimeters{height_mm}), MillimetersPerSecond{speed_mm_s}, limit};
}

// To 2 mm/s at 2 mm/s^2 within a millimetre, a millimetre at that speed, and to rest within another.
RisePlan trapezoid() {
  return {{point(10, 0), point(11, 2), point(12, 2), point(13, 0)}};
}

}  // namespace

TEST_CASE("A rise with constant acceleration between its points takes their distance over the mean speed") {
  CHECK(duration(trapezoid()).count() == Approx(1 + 0.5 + 1));
  CHECK(duration({}).count() == 0);
}

TEST_CASE("An overrun is passed at the speed before the last ramp") {
  RisePlan plan = trapezoid();
  CHECK(with_overrun(plan) == plan);
  plan.overrun = Nanometers{500'000};
  const RisePlan whole = with_overrun(plan);
  CHECK(whole.points.back() == point(13.5, 0));
  CHECK(whole.overrun == Nanometers{});
  CHECK(speed_at(whole, Nanometers{12'400'000}).count() == 2);
  CHECK(duration(whole).count() == Approx(duration(plan).count() + 0.25));
  CHECK(with_overrun({}).points.empty());
}

TEST_CASE("The time between two heights is that of the parts of the way between them") {
  const auto between = [](double low_mm, double high_mm) {
    return duration(trapezoid(), *to_nanometers(Millimeters{low_mm}), *to_nanometers(Millimeters{high_mm}))
        .count();
  };
  CHECK(between(0, 20) == Approx(2.5));
  CHECK(between(11, 12) == Approx(0.5));
  CHECK(between(10, 10.25) == Approx(0.5));
  CHECK(between(10.25, 11.5) == Approx(0.5 + 0.25));
  CHECK(between(13, 14) == 0);
}

TEST_CASE("The square of the speed is linear in height") {
  const auto at = [](double height_mm) {
    return speed_at(trapezoid(), *to_nanometers(Millimeters{height_mm})).count();
  };
  CHECK(at(9) == 0);
  CHECK(at(10) == 0);
  CHECK(at(10.25) == Approx(1));
  CHECK(at(11) == Approx(2));
  CHECK(at(11.5) == Approx(2));
  CHECK(at(12.5) == Approx(std::sqrt(2.0)));
  CHECK(at(13) == 0);
  CHECK(at(14) == 0);
}
