#include "hw/gpio/axis_motion.hpp"

#include "tests/catch.hpp"

namespace {

// 800 steps/mm, 25 mm/s2: 6 mm at 1.5 mm/s take 6 / 1.5 + 1.5 / 25 = 4.06 s.
constexpr Nanometers kLift{6'000'000};
constexpr MillimetersPerSecond kLiftSpeed{1.5};
// Rounding of the curve's times, which are doubles in seconds.
constexpr Duration kTimeRounding{1'000};

}  // namespace

TEST_CASE("an axis' move takes the time of its trapezoid") {
  CHECK(abs(move_duration({}, kLift, kLiftSpeed) - 4'060ms) < kTimeRounding);
  CHECK(abs(move_duration({}, -kLift, kLiftSpeed) - 4'060ms) < kTimeRounding);
  CHECK(move_duration({}, Nanometers{0}, kLiftSpeed) == 0ms);
}

TEST_CASE("an axis' jerk limit makes its moves longer") {
  GpioAxisConfig config;
  config.jerk_mm_s3 = 500;  // 25 / 500 = 0.05 s more
  CHECK(abs(move_duration(config, kLift, kLiftSpeed) - 4'110ms) < kTimeRounding);
}

TEST_CASE("an axis goes no faster than its top speed, whatever is asked for") {
  GpioAxisConfig config;
  config.top_speed = kLiftSpeed;
  CHECK(move_duration(config, kLift, MillimetersPerSecond{100}) == move_duration(config, kLift, kLiftSpeed));
}

TEST_CASE("an axis' move downwards includes the backlash and the way back") {
  GpioAxisConfig config;
  config.backlash = Nanometers{1'500'000};
  // 7.5 / 1.5 + 0.06, and 1.5 / 1.5 + 0.06.
  CHECK(abs(move_duration(config, -kLift, kLiftSpeed) - 6'120ms) < kTimeRounding);
  CHECK(abs(move_duration(config, kLift, kLiftSpeed) - 4'060ms) < kTimeRounding);
}

TEST_CASE("an axis with an encoder waits for rest before its move is over") {
  GpioAxisConfig config;
  config.encoder = EncoderConfig{};
  CHECK(abs(move_duration(config, kLift, kLiftSpeed) - 4'060ms - kEncoderRest) < kTimeRounding);
}
