// Tests that each header of hw checks its preconditions.
#include "hw/motion_curve.hpp"
#include "hw/simulated_axis.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/rises.hpp"

TEST_CASE("MotionCurve requires a distance that is not negative, and positive limits") {
  const auto curve = [](double distance, const MotionLimits& limits) {
    return contract_broken_by([&] { MotionCurve(distance, limits); });
  };
  CHECK(curve(0, {1, 1, 1}).empty());
  CHECK(curve(-1, {1, 1, 1}) == "the distance is not negative");
  for (const MotionLimits& limits : {MotionLimits{0, 1, 1}, MotionLimits{1, 0, 1}, MotionLimits{1, 1, 0}})
    CHECK(curve(1, limits) == "every limit is positive");
  CHECK(contract_broken_by([] {
          MotionProfile(Nanometers{-1'000'000}, MillimetersPerSecond{0}, MillimetersPerSecondSquared{1});
        }) == "every limit is positive");
}

TEST_CASE("RiseCurve and rest_of() require a plan, and a rest that begins within it") {
  const RisePlan plan{{rise_point(1, 0), rise_point(2, 1), rise_point(3, 0)}};
  CHECK(contract_broken_by([&] { RiseCurve(plan, 800, 0); }).empty());
  CHECK(contract_broken_by([] { RiseCurve({}, 800, 0); }) == "a rise has points between its ends");
  CHECK(contract_broken_by([] { (void)rest_of({}, Nanometers{0}); }) == "the plan has begun");
  CHECK(contract_broken_by([&] { (void)rest_of(plan, Nanometers{999'999}); }) == "the plan has begun");
  CHECK(contract_broken_by([&] {
          MotionCurve(RiseCurve(plan, 1, 0), {1, 0, 1});
        }) == "every limit is positive");
}

TEST_CASE("ZAxis neither homes nor moves while it moves") {
  VirtualClock clock;
  SimulatedAxis axis(clock, {});
  axis.home([](HomingResult) {});
  CHECK(contract_broken_by([&] { axis.home([](HomingResult) {}); }) == "the axis does not move");
  CHECK(contract_broken_by([&] {
          axis.move_to(Nanometers{0}, MillimetersPerSecond{1}, [](MoveResult) {});
        }) == "the axis does not move");
  CHECK(contract_broken_by([&] { axis.rise({}, [](MoveResult) {}); }) == "the axis does not move");
  const auto nudge = [&axis](Nanometers distance) {
    axis.nudge(distance, MillimetersPerSecond{1}, [](MoveResult) {});
  };
  CHECK(contract_broken_by([&] { nudge(Nanometers{1}); }) == "the axis does not move");
  const auto raise = [&axis](Nanometers distance) {
    axis.raise(distance, MillimetersPerSecond{1}, [](MoveResult) {});
  };
  CHECK(contract_broken_by([&] { raise(Nanometers{1}); }) == "the axis does not move");
  CHECK(contract_broken_by([&] { axis.assume_height(Nanometers{1}); }) == "the axis does not move");
  axis.abort();
  for (const Nanometers distance : {Nanometers{-1}, axis.travel() + Nanometers{1}})
    CHECK(contract_broken_by([&] { raise(distance); }) == "the plate rises within its travel");
  CHECK(contract_broken_by([&] { nudge(Nanometers{2'000'001}); }) == "a nudge is short");
  CHECK(contract_broken_by([&] { axis.home([](HomingResult) {}); }).empty());
}

TEST_CASE("MaskDisplay only shows masks of its own size") {
  VirtualClock clock;
  SimulatedPrinterConfig config;
  config.display.width = Pixels{8};
  config.display.height = Pixels{6};
  SimulatedPrinter printer(clock, config);
  const auto show = [&](Pixels width, Pixels height) {
    return contract_broken_by(
        [&] { printer.display().show(Mask(width, height), [](std::optional<TimePoint>) {}); });
  };
  CHECK(show(Pixels{8}, Pixels{6}).empty());
  CHECK(show(Pixels{6}, Pixels{8}) == "the mask has the display's size");
}
