#include "core/overhangs/underside.hpp"

#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"

TEST_CASE("A tip is moved inwards until all of it holds, and to the middle of a thinner wall") {
  const SweepGrid grid = sweep_grid(testing::kHeldDisplay);
  Mask mask(grid.display.width, grid.display.height);
  MaskRuns dark, lit;
  dark.extract(mask);
  for (std::int32_t row = 100; row < 130; ++row) {
    for (std::size_t column = 100; column < 140; ++column)
      mask.row(row)[column] = 255;
    mask.row(row)[200] = mask.row(row)[201] = mask.row(row)[202] = 255;
  }
  lit.extract(mask);
  LayerParts parts;
  parts.add_layer(lit, dark);
  Underside underside(grid);
  underside.add_layer({lit, dark, parts, grid.step / 2}, {1, 1});
  CHECK(underside.centered({100, 100}, 4) == SweepPixel{104, 104});
  CHECK(underside.centered({139, 115}, 4) == SweepPixel{135, 115});
  CHECK(underside.centered({120, 115}, 4) == SweepPixel{120, 115});
  CHECK(underside.centered({202, 115}, 4) == SweepPixel{201, 115});
}
