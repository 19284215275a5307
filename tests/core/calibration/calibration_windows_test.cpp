#include "core/calibration/calibration_windows.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include "tests/catch.hpp"

namespace contourd {
namespace {

Mask windows(std::vector<std::uint8_t> greys, int width = 1920, int height = 1080) {
  return draw_calibration_windows(greys, Pixels{width}, Pixels{height}, Micrometers{50});
}

std::uint8_t grey_at(const Mask& mask, int x, int y) {
  return mask.row(y)[static_cast<std::size_t>(x)];
}

TEST_CASE("Nine windows of 6 mm lie around the display's middle, the first at top left") {
  const Mask mask = windows({10, 20, 30, 40, 50, 60, 70, 80, 90});
  // 6 mm are 120 pixels, 1.6 times as much from window to window.
  for (int i = 0; i < 9; ++i) {
    CAPTURE(i);
    const int x = 960 + (i % 3 - 1) * 192, y = 540 + (i / 3 - 1) * 192;
    CHECK(grey_at(mask, x - 60, y - 60) == 10 * (i + 1));
    CHECK(grey_at(mask, x + 59, y + 59) == 10 * (i + 1));
    CHECK(grey_at(mask, x + 60, y) == 0);
    CHECK(grey_at(mask, x, y + 60) == 0);
  }
}

TEST_CASE("Each window has as many dots as its number, with its own grey value") {
  for (int number = 1; number <= 9; ++number) {
    CAPTURE(number);
    std::vector<std::uint8_t> greys(9, 0);
    greys[static_cast<std::size_t>(number - 1)] = 200;
    const Mask mask = windows(greys);
    CHECK(mask.lit_area() == Approx(static_cast<double>(mask.lit_pixels()) * 200 / 255.0));
    // Count the lit pieces of a row through the dots: 0.18 of the window below it.
    const int y = 540 + ((number - 1) / 3 - 1) * 192 + 60 + 22;
    int dots = 0;
    for (int x = 1; x < 1920; ++x)
      dots += grey_at(mask, x, y) != 0 && grey_at(mask, x - 1, y) == 0;
    CHECK(dots == number);
  }
}

TEST_CASE("Windows are smaller on a small display, so that all are on it") {
  const Mask mask = windows(std::vector<std::uint8_t>(9, 255), 100, 300);
  CHECK(mask.lit_pixels() > 9 * 20 * 20);
  for (int y = 0; y < 300; ++y) {
    CHECK(grey_at(mask, 0, y) == 0);
    CHECK(grey_at(mask, 99, y) == 0);
  }
}

}  // namespace
}  // namespace contourd
