#include "core/image/test_pattern.hpp"

#include "tests/catch.hpp"

namespace {

constexpr Pixels kPatternWidth{640}, kPatternHeight{400};
constexpr Micrometers kPatternPitch{50};

Mask drawn(TestPattern pattern) {
  return draw_test_pattern(pattern, kPatternWidth, kPatternHeight, kPatternPitch);
}

bool lit(const Mask& mask, int x, int y) {
  return mask.row(y)[static_cast<std::size_t>(x)] != 0;
}

}  // namespace

TEST_CASE("Every test pattern is found by its name, and other names are not found") {
  for (const TestPattern pattern : kTestPatterns)
    CHECK(find_test_pattern(name_of(pattern)) == pattern);
  CHECK_FALSE(find_test_pattern("gird"));
  CHECK_FALSE(find_test_pattern(""));
}

TEST_CASE("Test patterns have the display's size and nothing but black and white") {
  for (const TestPattern pattern : kTestPatterns) {
    CAPTURE(name_of(pattern));
    for (const auto& [width, height] : {std::pair{640, 400}, {1, 1}, {3, 900}}) {
      const Mask mask = draw_test_pattern(pattern, Pixels{width}, Pixels{height}, kPatternPitch);
      CHECK(mask.width() == Pixels{width});
      CHECK(mask.height() == Pixels{height});
      CHECK(mask.lit_area() == static_cast<double>(mask.lit_pixels()));
    }
  }
}

TEST_CASE("White is all lit, black all dark") {
  CHECK(drawn(TestPattern::White).lit_pixels() == 640 * 400);
  CHECK(drawn(TestPattern::Black).lit_pixels() == 0);
}

TEST_CASE("The grid has a line every 5 mm, counted from the centre") {
  const Mask mask = drawn(TestPattern::Grid);
  // 5 mm are 100 pixels; row 50 lies between two lines.
  for (int x = 0; x < 640; ++x) {
    CAPTURE(x);
    const int from_centre = std::abs(x - 320);
    CHECK(lit(mask, x, 50) == (from_centre % 100 == 0 || from_centre == 1));
  }
  for (int y = 0; y < 400; ++y)
    CHECK(lit(mask, 50, y) == (std::abs(y - 200) % 100 == 0 || std::abs(y - 200) == 1));
}

TEST_CASE("The checker's squares are 5 mm wide and meet at the centre") {
  const Mask mask = drawn(TestPattern::Checker);
  CHECK(lit(mask, 320, 200));
  CHECK(lit(mask, 319, 199));
  CHECK_FALSE(lit(mask, 319, 200));
  CHECK_FALSE(lit(mask, 320, 199));
  CHECK(lit(mask, 419, 299));
  CHECK_FALSE(lit(mask, 420, 299));
}

TEST_CASE("Focus has lines of one pixel both ways, and single pixels") {
  const Mask mask = drawn(TestPattern::Focus);
  CHECK((lit(mask, 0, 1) && !lit(mask, 1, 1) && lit(mask, 2, 1)));
  CHECK((lit(mask, 65, 0) && !lit(mask, 65, 1) && lit(mask, 65, 2)));
  CHECK((lit(mask, 128, 0) && !lit(mask, 129, 0) && !lit(mask, 128, 1) && lit(mask, 132, 4)));
}

TEST_CASE("The border lights the outermost pixels, with a filled square only at the top left") {
  const Mask mask = drawn(TestPattern::Border);
  for (const int x : {0, 100, 639})
    CHECK((lit(mask, x, 0) && lit(mask, x, 399)));
  for (const int y : {0, 100, 399})
    CHECK((lit(mask, 0, y) && lit(mask, 639, y)));
  CHECK(lit(mask, 50, 50));
  CHECK_FALSE(lit(mask, 639 - 50, 50));
  CHECK_FALSE(lit(mask, 50, 399 - 50));
}

TEST_CASE("The rulers have the length of ruler_length(), with ticks at millimetres") {
  // 32 mm by 20 mm: nine tenths are 28.8 and 18.
  CHECK(ruler_length(kPatternWidth, kPatternPitch).count() == 20);
  CHECK(ruler_length(kPatternHeight, kPatternPitch).count() == 10);
  CHECK(ruler_length(Pixels{100}, kPatternPitch).count() == 4);
  CHECK(ruler_length(Pixels{1}, kPatternPitch).count() == 0);
  const Mask mask = drawn(TestPattern::Dimensions);
  int first = 640, last = -1;
  for (int x = 0; x < 640; ++x) {
    if (!lit(mask, x, 200)) continue;
    first = std::min(first, x);
    last = std::max(last, x);
  }
  CHECK(first == 120);
  CHECK(last == 519);  // 400 pixels of 50 um
  // A tick of 1 mm and one of 5 mm beside the middle.
  CHECK((lit(mask, 140, 190) && !lit(mask, 141, 190) && !lit(mask, 140, 170)));
  CHECK(lit(mask, 220, 165));
}
