#include "core/block_painter.hpp"

#include <rapidcheck.h>

#include <array>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

constexpr std::uint32_t kOneWinding = 1U << kWindingBits;

using Cells = std::array<std::uint32_t, kBlockPixels>;
using Greys = std::array<std::uint8_t, kBlockPixels>;

}  // namespace

TEST_CASE("A pixel's grey is its winding number's magnitude, at most one, of 255") {
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

TEST_CASE("A block is painted by the running sum of its cells, which are 0 after that") {
  Cells cells{};
  cells[3] = kOneWinding;
  cells[9] = 0 - kOneWinding / 2;
  Greys greys{};
  CHECK(paint_block(cells.data(), 0, greys.data()) == kOneWinding / 2);
  CHECK(greys == Greys{0, 0, 0, 255, 255, 255, 255, 255, 255, 128, 128, 128, 128, 128, 128, 128});
  CHECK(cells == Cells{});
}

TEST_CASE("A block painted by vector instructions is the one painted plainly") {
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
    const std::uint32_t plain_end = paint_block_plainly(plain_cells.data(), before, plain_greys.data());
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
