#include "core/continuous/slab_facets.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

struct CellBox {
  std::int32_t left, right, top, bottom;
  std::size_t lit;
  bool operator==(const CellBox&) const = default;
};

// Returns the box around the cells that a model's facets light, and their number.
CellBox lit_by(const PlateModel& model, HeightSpan span, double outwards = 0) {
  LitCells cells(Mask(kCoarseDisplay.width, kCoarseDisplay.height), CellRule{.side = 4});
  StopCheck never;
  light_facets(model, span, {4, outwards}, cells, never);
  CellBox box{1000, -1, 1000, -1, 0};
  for (std::int32_t row = 0; row < cells.rows(); ++row) {
    for (std::int32_t column = 0; column < cells.columns(); ++column) {
      if (!cells.is_lit(cells.place(column, row))) continue;
      box = {std::min(box.left, column), std::max(box.right, column), std::min(box.top, row),
             std::max(box.bottom, row), box.lit + 1};
    }
  }
  return box;
}

constexpr HeightSpan kMiddle{mm(1), mm(2)}, kTop{mm(3), mm(4)};

}  // namespace

TEST_CASE("Facets light the cells above which they are, and level ones all of them") {
  // From pixel 100 to 140 of 240 and, since row 0 is the top, from 80 to 100 of 220.
  const PlateModel block = plate_model(models::box({-2, 1, 0}, {2, 3, 4}));
  // The border is cell 0. Places on a boundary light the cells on both sides.
  CHECK(lit_by(block, kTop) == CellBox{25, 36, 20, 26, 12 * 7});
  CHECK(lit_by(block, kMiddle) == CellBox{25, 36, 20, 26, 12 * 7 - 8 * 3});
  CHECK(lit_by(block, {mm(5), mm(6)}).lit == 0);
  CHECK(lit_by(block, kTop, 1) == CellBox{24, 37, 19, 27, 14 * 9});
}

TEST_CASE("Only the part of a facet within the slab lights cells") {
  // At a height of 2 mm, the cone's radius is 4 mm: 10 cells.
  const CellBox box = lit_by(plate_model(models::cone(8, 4, 64)), {mm(2), Nanometers{2'100'000}});
  CHECK(box.left == 31 - 11);
  CHECK(box.right == 31 + 10);
}

TEST_CASE("Facets beside the display light none of its cells, and huge ones all") {
  CHECK(lit_by(plate_model(models::box({100, 100, 0}, {110, 110, 4})), kTop).lit == 0);
  CHECK(lit_by(plate_model(models::box({-1e30F, -1e30F, 0}, {1e30F, 1e30F, 4})), kTop).lit == 60 * 55);
}
