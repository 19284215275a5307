#include "daemon/print/split_exposure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/catch.hpp"

using namespace std::chrono_literals;

namespace {

constexpr Duration kFrame = 10ms;

// Returns a mask of one row with pixels that get a quarter, a half, three quarters and all of the light.
Mask quarters() {
  Mask light(Pixels{4}, Pixels{1});
  for (std::size_t x = 0; x < 4; ++x)
    light.row(0)[x] = static_cast<std::uint8_t>((x + 1) * 255 / 4);
  return light;
}

// Returns the number of lit pixels.
std::int64_t lit(const Mask& picture) {
  return picture.lit_pixels();
}

// Shows the next picture, and draws the one after it.
void show(SplitExposure& split, Duration light) {
  split.shown(light);
  while (split.draw_some()) {
  }
}

// Returns the light after which the next picture is due, in quarters of a second, which are shares in 255ths.
std::int64_t due_quarters(const SplitExposure& split) {
  return std::lround(split.next_due().value() / std::chrono::duration<double, std::milli>(250));
}

}  // namespace

TEST_CASE("The pictures of an exposure follow each other by the light that it has had") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  const Mask light = quarters();
  CHECK(lit(split.begin(light, {1000ms, 0ms, kFrame})) == 4);
  CHECK(split.pictures() == 4);
  CHECK(split.light_error() < 0.003);  // 63 of 255 are not a quarter
  for (const std::int64_t quarter : {1, 2, 3}) {
    CHECK(due_quarters(split) == quarter);
    const Mask& next = split.next();
    CHECK(lit(next) == 4 - quarter);
    show(split, 250ms * quarter + 3ms);
    CHECK(lit(next) == 4 - quarter);  // now on the screen, beside the picture after it
  }
  CHECK_FALSE(split.next_due());
}

TEST_CASE("A picture that comes after the next one was due is followed by the last that is due") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  const Mask light = quarters();
  split.begin(light, {1000ms, 0ms, kFrame});
  show(split, 760ms);
  CHECK(due_quarters(split) == 3);
  CHECK(lit(split.next()) == 1);
  show(split, 770ms);
  CHECK_FALSE(split.next_due());
}

TEST_CASE("The rest of an interrupted exposure begins with the picture of the light that it has had") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  const Mask light = quarters();
  struct Rest {
    Duration past;
    std::int64_t lit, next;
  };
  // A picture that is due within half a refresh comes first.
  for (const Rest& rest : {Rest{0ms, 4, 1}, {240ms, 4, 1}, {246ms, 3, 2}, {400ms, 3, 2}, {510ms, 2, 3}}) {
    CAPTURE(rest.past.count());
    CHECK(lit(split.begin(light, {1000ms, rest.past, kFrame})) == rest.lit);
    CHECK(due_quarters(split) == rest.next);
  }
  CHECK(lit(split.begin(light, {1000ms, 900ms, kFrame})) == 1);
  CHECK_FALSE(split.next_due());
}

TEST_CASE("An exposure of fewer refreshes than its pictures need has fewer pictures") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  const Mask light = quarters();
  split.begin(light, {12 * kFrame, 0ms, kFrame});
  CHECK(split.pictures() == 4);
  split.begin(light, {12 * kFrame - 1ms, 0ms, kFrame});
  CHECK(split.pictures() == 3);
  CHECK(split.light_error() > 0.05);
  split.begin(light, {5 * kFrame, 0ms, kFrame});
  CHECK(split.pictures() == 1);
}

TEST_CASE("An exposure of a few times three refreshes has as many pictures, whatever the refresh rate") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  const Mask light = quarters();
  for (const double refresh_hz : {24.0, 30.0, 50.0, 59.94, 60.0, 75.0, 120.0, 144.0, 165.0, 240.0}) {
    CAPTURE(refresh_hz);
    const Duration frame{std::llround(1e9 / refresh_hz)}, exposure{std::llround(12e9 / refresh_hz)};
    split.begin(light, {exposure, 0ms, frame});
    CHECK(split.pictures() == 4);
    split.begin(light, {exposure - 100us, 0ms, frame});
    CHECK(split.pictures() == 3);
  }
}

TEST_CASE("A mask without grey is one picture, which nothing follows") {
  SplitExposure split({1, 1}, Pixels{4}, Pixels{1});
  Mask light(Pixels{4}, Pixels{1});
  light.row(0)[2] = 255;
  CHECK(split.begin(light, {1000ms, 0ms, kFrame}) == light);
  CHECK_FALSE(split.next_due());
}

TEST_CASE("A large picture is drawn in parts, which together are the picture drawn at once") {
  const Pixels width{1000}, height{2500};
  SplitExposure split({1, 1}, width, height);
  Mask light(width, height);
  for (std::int32_t y = 0; y < height.count(); ++y)
    std::ranges::fill(light.row(y), static_cast<std::uint8_t>(1 + y % 255));
  split.begin(light, {1000ms, 0ms, kFrame});
  REQUIRE(split.pictures() > 3);
  LightSplit whole({1, 1});
  whole.plan(light, 0.03);
  REQUIRE(whole.pictures() == split.pictures());
  split.shown(1ms);
  CHECK(split.draw_some());
  CHECK(split.draw_some());
  CHECK_FALSE(split.draw_some());
  Mask expected(width, height);
  whole.draw(2, light, {0, height.count()}, expected);
  CHECK(split.next() == expected);
}
