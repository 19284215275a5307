#include "core/image/thumbnail.hpp"

#include "tests/catch.hpp"

namespace {

Mask lit(std::int32_t width, std::int32_t height, const PixelBox& box, std::uint8_t grey = 255) {
  Mask mask(Pixels{width}, Pixels{height});
  for (std::int32_t y = box.top; y < box.bottom; ++y)
    std::ranges::fill(mask.row(y).subspan(static_cast<std::size_t>(box.left),
                                          static_cast<std::size_t>(box.right - box.left)),
                      grey);
  return mask;
}

}  // namespace

TEST_CASE("A box that is small enough is cut out as it is") {
  const Mask mask = lit(30, 20, {10, 5, 12, 8}, 7);
  const Mask small = make_thumbnail(mask, {9, 4, 14, 9}, Pixels{5});
  CHECK(small.width() == Pixels{5});
  CHECK(small.height() == Pixels{5});
  CHECK(small == lit(5, 5, {1, 1, 3, 4}, 7));
}

TEST_CASE("A larger box keeps its proportions, and its longer side has the given length") {
  const Mask wide = make_thumbnail(Mask(Pixels{1000}, Pixels{500}), {0, 0, 1000, 500}, Pixels{100});
  CHECK(wide.width() == Pixels{100});
  CHECK(wide.height() == Pixels{50});
  const Mask thin = make_thumbnail(Mask(Pixels{16384}, Pixels{3}), {0, 1, 16384, 2}, Pixels{320});
  CHECK(thin.width() == Pixels{320});
  CHECK(thin.height() == Pixels{1});
}

TEST_CASE("A thumbnail's pixel is the mean of its source pixels") {
  const Mask small = make_thumbnail(lit(8, 8, {0, 0, 3, 8}), {0, 0, 8, 8}, Pixels{4});
  CHECK(small.row(0)[0] == 255);
  CHECK(small.row(0)[1] == 128);
  CHECK(small.row(0)[2] == 0);
  // Sides that do not divide evenly.
  CHECK(make_thumbnail(lit(7, 5, {0, 0, 7, 5}), {0, 0, 7, 5}, Pixels{3}) == lit(3, 2, {0, 0, 3, 2}));
}

TEST_CASE("One lit pixel among thousands stays visible") {
  const Mask small =
      make_thumbnail(lit(4000, 4000, {1999, 1999, 2000, 2000}, 1), {0, 0, 4000, 4000}, Pixels{100});
  CHECK(small.lit_pixels() == 1);
  CHECK(small.row(49)[49] >= 40);
}
