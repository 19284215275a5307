#include "core/mask/block_painter.hpp"

#include <rapidcheck.h>

#include "tests/catch.hpp"

namespace {

constexpr std::uint32_t kOneWinding = 1U << kWindingBits;

using Cells = std::array<std::uint32_t, kBlockPixels>;
using Greys = std::array<std::uint8_t, kBlockPixels>;

}  // namespace

TEST_CASE("A pixel's grey value is 255 times its winding number's magnitude, at most 1") {
  CHECK(grey_of(0) == 0);
  CHECK(grey_of(kOneWinding) == 255);
  CHECK(grey_of(0 - kOneWinding) == 255);
  CHECK(grey_of(3 * kOneWinding) == 255);
  CHECK(grey_of(kOneWinding / 2) == 128);  // 127.5
  CHECK(grey_of(0 - kOneWinding / 2) == 128);
  // Half a grey step is 64.25 units.
  CHECK(grey_of(64) == 0);
  CHECK(grey_of(65) == 1);
  CHECK(grey_of(kOneWinding - 64) == 255);
  CHECK(grey_of(kOneWinding - 65) == 254);
}

TEST_CASE("64 bytes of 0 or 1 become 64 bits") {
  std::array<std::uint8_t, 64> bytes{};
  CHECK(bits_of(bytes.data()) == 0);
  for (std::size_t i = 0; i < 64; ++i) {
    bytes[i] = 1;
    CHECK(bits_of(bytes.data()) == (i == 63 ? ~std::uint64_t{0} : (std::uint64_t{2} << i) - 1));
    CHECK(bits_of_scalar(bytes.data()) == bits_of(bytes.data()));
  }
}

TEST_CASE("A block is painted by the running sum of its cells, which are 0 afterwards") {
  Cells cells{};
  cells[3] = kOneWinding;
  cells[9] = 0 - kOneWinding / 2;
  Greys greys{};
  CHECK(paint_block(cells.data(), 0, greys.data()) == kOneWinding / 2);
  CHECK(greys == Greys{0, 0, 0, 255, 255, 255, 255, 255, 255, 128, 128, 128, 128, 128, 128, 128});
  CHECK(cells == Cells{});
}

TEST_CASE("Vector instructions paint the same block as plain code") {
  const bool equal = rc::check([] {
    const auto start = *rc::gen::arbitrary<std::uint32_t>();
    // Sums in the range that matters, and any at all.
    const bool small = *rc::gen::arbitrary<bool>();
    Cells cells{};
    for (std::uint32_t& cell : cells) {
      cell = small ? static_cast<std::uint32_t>(*rc::gen::inRange<std::int32_t>(-40'000, 40'000))
                   : *rc::gen::arbitrary<std::uint32_t>();
    }
    Cells plain_cells = cells;
    Greys greys{}, plain_greys{};
    const std::uint32_t before = small ? start % (2 * kOneWinding) : start;
    const std::uint32_t end = paint_block(cells.data(), before, greys.data());
    const std::uint32_t plain_end = paint_block_scalar(plain_cells.data(), before, plain_greys.data());
    RC_ASSERT(end == plain_end);
    RC_ASSERT(greys == plain_greys);
    RC_ASSERT(cells == plain_cells);
  });
  CHECK(equal);
}

TEST_CASE("Every magnitude up to two and every sign gives the same grey by vector instructions") {
  for (std::uint32_t winding = 0; winding <= 2 * kOneWinding; ++winding) {
    for (const std::uint32_t signed_winding : {winding, 0 - winding}) {
      Cells cells{signed_winding};
      Greys greys{};
      (void)paint_block(cells.data(), 0, greys.data());
      if (greys.back() != grey_of(signed_winding))
        FAIL("winding " << static_cast<std::int32_t>(signed_winding));
    }
  }
  SUCCEED();
}

TEST_CASE("A block without overlaps has the same grey values and reports no overlap") {
  Cells cells{};
  cells[2] = kOneWinding / 4;
  cells[3] = kOneWinding / 2;
  cells[4] = kOneWinding / 4;
  cells[12] = 0 - kOneWinding;
  Cells again = cells;
  Greys greys{}, plain_greys{};
  WindingRange range;
  CHECK(paint_covered_block(cells.data(), kNoWinding, greys.data(), range) == kNoWinding);
  CHECK(range.is_zero_to_one());
  CHECK(cells == Cells{});
  (void)paint_block(again.data(), 0, plain_greys.data());
  CHECK(greys == plain_greys);
}

TEST_CASE("A winding number above 1 or below 0 is reported, a rounding error is not") {
  const auto is_sound = [](std::int32_t winding) {
    Cells cells{};
    cells[7] = static_cast<std::uint32_t>(winding);
    Greys greys{};
    WindingRange range;
    (void)paint_covered_block(cells.data(), kNoWinding, greys.data(), range);
    CHECK(greys[7] == (winding < 0 ? 0 : grey_of(static_cast<std::uint32_t>(winding))));
    return range.is_zero_to_one();
  };
  constexpr auto kOne = static_cast<std::int32_t>(kOneWinding);
  for (const std::int32_t sound : {0, 1, kOne / 2, kOne, kOne + kWindingSlack, -kWindingSlack})
    CHECK(is_sound(sound));
  for (const std::int32_t overlap :
       {kOne + kWindingSlack + 1, -kWindingSlack - 1, 2 * kOne, -kOne, 60'000 * kOne})
    CHECK_FALSE(is_sound(overlap));
}

TEST_CASE("Vector instructions paint the same block without overlaps as plain code") {
  const bool equal = rc::check([] {
    const bool small = *rc::gen::arbitrary<bool>();
    Cells cells{};
    for (std::uint32_t& cell : cells) {
      cell = small ? static_cast<std::uint32_t>(*rc::gen::inRange<std::int32_t>(-20'000, 20'000))
                   : *rc::gen::arbitrary<std::uint32_t>();
    }
    Cells plain_cells = cells;
    Greys greys{}, plain_greys{};
    WindingRange range;
    ScalarWindingRange plain_range;
    const std::uint32_t end = paint_covered_block(cells.data(), kNoWinding, greys.data(), range);
    const std::uint32_t plain_end =
        paint_covered_block_scalar(plain_cells.data(), kNoWinding, plain_greys.data(), plain_range);
    RC_ASSERT(end == plain_end);
    RC_ASSERT(greys == plain_greys);
    RC_ASSERT(range.is_zero_to_one() == plain_range.is_zero_to_one());
  });
  CHECK(equal);
}
