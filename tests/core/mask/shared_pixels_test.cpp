#include "core/mask/shared_pixels.hpp"

#include <array>

#include "core/mask/block_painter.hpp"
#include "tests/catch.hpp"

TEST_CASE("SharedPixels collects no more sides than the first pixel that is too dense has") {
  constexpr std::int32_t kWidth = 64, kUnits = 1 << kWindingBits, kSides = 1000;
  SharedPixels shared(kWidth, kWidth, 2);
  const auto side_of = [](std::uint32_t number) {
    const auto y = static_cast<std::int32_t>(number) + 1;
    return UnitSide{kUnits / 2, y, kWidth * kUnits - kUnits / 2, y + 10};
  };
  for (std::uint32_t number = 0; number < kSides; ++number)
    shared.count({number, 0, 0, kWidth - 1, false, false, true});
  const std::array<std::uint32_t, kBlockPixels> cells{};
  for (std::size_t first = 0; first < kWidth; first += kBlockPixels)
    shared.look_at_block(0, first, cells.data(), 0);
  REQUIRE(shared.pixels().size() == kWidth);
  std::size_t asked = 0;
  shared.collect(0, [&](std::uint32_t number) {
    ++asked;
    return side_of(number);
  });
  CHECK(shared.too_dense());
  CHECK(asked == PixelFill::kMostSides + 1);
  shared.clear();
  CHECK(shared.pixels().empty());
  CHECK_FALSE(shared.too_dense());
}
