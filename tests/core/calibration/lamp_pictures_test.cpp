#include "core/calibration/lamp_pictures.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/catch.hpp"

namespace contourd {
namespace {

std::uint8_t shade_at(const Mask& mask, int x, int y) {
  return mask.row(y)[static_cast<std::size_t>(x)];
}

TEST_CASE("The fields of a grid are white squares from edge to edge") {
  constexpr LampGrid grid{5, 3};
  for (int cell = 0; cell < grid.cells(); ++cell) {
    const Mask mask = draw_lamp_field(grid, cell, Pixels{1920}, Pixels{1080});
    CAPTURE(cell);
    // Cells of 384 x 360 pixels: a square of three fifths of 360.
    CHECK(mask.lit_pixels() == 216 * 216);
    const int left = cell % 5 * (1920 - 216) / 4, top = cell / 5 * (1080 - 216) / 2;
    CHECK(shade_at(mask, left, top) == 255);
    CHECK(shade_at(mask, left + 215, top + 215) == 255);
    const LampField field = lamp_field(grid, cell, Pixels{1920}, Pixels{1080});
    CHECK(field.middle.x == Approx((left + 108) / 960.0 - 1));
    CHECK(field.middle.y == Approx((top + 108) / 540.0 - 1));
  }
}

TEST_CASE("Every field lies on the smallest display") {
  constexpr LampGrid grid{9, 9};
  for (int cell = 0; cell < grid.cells(); ++cell)
    CHECK(draw_lamp_field(grid, cell, Pixels{100}, Pixels{100}).lit_pixels() == 7 * 7);
}

TEST_CASE("The white picture has as many dots in a corner as its number") {
  for (const auto& [width, height] : {std::pair{1920, 1080}, std::pair{100, 130}}) {
    const Mask mask = draw_lamp_photo(Pixels{width}, Pixels{height});
    CHECK(std::ranges::all_of(mask.pixels(), [](auto grey) { return grey == 0 || grey == 255; }));
    // Dots along a row, to the left and right of the middle.
    const auto dots = [&mask, wide = width](int y, bool is_right) {
      int count = 0;
      for (int x = is_right ? wide / 2 : 1; x < (is_right ? wide : wide / 2); ++x)
        count += shade_at(mask, x, y) == 0 && shade_at(mask, x - 1, y) != 0 ? 1 : 0;
      return count;
    };
    const int dot = std::min(width, height) / 100, above = dot, below = height - 2 * dot;
    CHECK(dots(above, false) == 1);
    CHECK(dots(above, true) == 2);
    CHECK(dots(below, true) == 3);
    CHECK(dots(below, false) == 4);
    CHECK(static_cast<std::int64_t>(width) * height - mask.lit_pixels() == 10 * dot * dot);
    CHECK(shade_at(mask, 0, 0) == 255);
    CHECK(shade_at(mask, width / 2, height / 2) == 255);
  }
}

}  // namespace
}  // namespace contourd
