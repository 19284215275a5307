#include "core/mask/mask.hpp"

#include "tests/catch.hpp"
#include "tests/message_of.hpp"

TEST_CASE("A new mask is dark") {
  const Mask mask(Pixels{7}, Pixels{3});
  CHECK(mask.width() == Pixels{7});
  CHECK(mask.height() == Pixels{3});
  CHECK(mask.pixels().size() == 21);
  CHECK(mask.lit_pixels() == 0);
  CHECK(mask.lit_area() == 0.0);
}

TEST_CASE("A mask that was never given a size has no pixels") {
  const Mask mask;
  CHECK(mask.width() == Pixels{0});
  CHECK(mask.pixels().empty());
  CHECK(mask.lit_pixels() == 0);
}

TEST_CASE("A mask has 1 to 16384 pixels a side") {
  CHECK(Mask(Pixels{16384}, Pixels{1}).pixels().size() == 16384);
  CHECK(Mask(Pixels{1}, Pixels{16384}).pixels().size() == 16384);
  CHECK_THROWS_AS(Mask(Pixels{0}, Pixels{1}), std::invalid_argument);
  CHECK_THROWS_AS(Mask(Pixels{1}, Pixels{0}), std::invalid_argument);
  CHECK_THROWS_AS(Mask(Pixels{1}, Pixels{16385}), std::invalid_argument);
  CHECK_THROWS_AS(Mask(Pixels{-1}, Pixels{-1}), std::invalid_argument);
}

TEST_CASE("The error for a refused mask size contains the size") {
  CHECK(testing::message_of<std::invalid_argument>([] {
          return Mask(Pixels{20000}, Pixels{10});
        }).find("20000x10") != std::string::npos);
}

TEST_CASE("A mask's rows lie below each other without padding") {
  Mask mask(Pixels{3}, Pixels{2});
  mask.row(0)[2] = 1;
  mask.row(1)[0] = 2;
  const Mask& view = mask;
  CHECK(view.row(0).size() == 3);
  CHECK(view.row(1)[0] == 2);
  CHECK(view.pixels()[2] == 1);
  CHECK(view.pixels()[3] == 2);
  CHECK(view.row(1).data() == view.pixels().data() + 3);
}

TEST_CASE("Lit pixels are counted, and the lit area is weighted by their grey values") {
  Mask mask(Pixels{4}, Pixels{1});
  mask.row(0)[0] = 255;
  mask.row(0)[1] = 51;
  mask.row(0)[2] = 1;
  CHECK(mask.lit_pixels() == 3);
  CHECK(mask.lit_area() == 307.0 / 255.0);
}

TEST_CASE("A large bright mask's area does not overflow") {
  Mask mask(Pixels{16384}, Pixels{1100});  // 18 million pixels of 255 are beyond 32 bits
  for (std::int32_t y = 0; y < 1100; ++y)
    std::ranges::fill(mask.row(y), std::uint8_t{255});
  CHECK(mask.lit_area() == 16384.0 * 1100.0);
}

TEST_CASE("Masks are equal when their sizes and pixels are") {
  Mask a(Pixels{2}, Pixels{3}), b(Pixels{2}, Pixels{3});
  CHECK(a == b);
  b.row(2)[1] = 1;
  CHECK_FALSE(a == b);
  CHECK_FALSE(a == Mask(Pixels{3}, Pixels{2}));
}
