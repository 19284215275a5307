#include "core/mask/picture_stack.hpp"

#include <random>

#include "tests/catch.hpp"

namespace {

constexpr Nanometers kLayer{50'000};

Mask random_mask(std::mt19937& random, Pixels width, Pixels height) {
  Mask mask(width, height);
  std::uniform_int_distribution<int> grey(0, 3), longest(1, 400);
  for (std::int32_t y = 0; y < height.count(); ++y) {
    const auto row = mask.row(y);
    for (std::size_t x = 0; x < row.size();) {
      const auto value = static_cast<std::uint8_t>(85 * grey(random));
      const auto end = std::min(row.size(), x + static_cast<std::size_t>(longest(random)));
      std::fill(row.begin() + static_cast<std::ptrdiff_t>(x), row.begin() + static_cast<std::ptrdiff_t>(end),
                value);
      x = end;
    }
  }
  return mask;
}

}  // namespace

TEST_CASE("A stack of pictures draws each picture as it was added, to the byte") {
  std::mt19937 random(7);
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {129, 65}, {1000, 40}}) {
    PictureStack stack(Pixels{width}, Pixels{height}, kLayer);
    std::vector<Mask> added;
    for (int layer = 0; layer < 20; ++layer) {
      added.push_back(random_mask(random, Pixels{width}, Pixels{height}));
      stack.add(added.back());
    }
    Mask drawn(Pixels{width}, Pixels{height});
    for (std::size_t layer = 0; layer < added.size(); ++layer) {
      stack.draw(kLayer * static_cast<std::int64_t>(layer) + kLayer / 2, drawn);
      CHECK(drawn == added[layer]);
    }
  }
}

TEST_CASE("A layer's picture reaches from its lower side to just below its upper side") {
  PictureStack stack(Pixels{4}, Pixels{2}, kLayer);
  Mask first(Pixels{4}, Pixels{2}), second = first, drawn = first, dark = first;
  first.row(0)[1] = 200;
  second.row(1)[3] = 100;
  stack.add(first);
  stack.add(second);
  const auto at = [&](std::int64_t nanometers) -> const Mask& {
    stack.draw(Nanometers{nanometers}, drawn);
    return drawn;
  };
  CHECK(at(0) == first);
  CHECK(at(49'999) == first);
  CHECK(at(50'000) == second);
  CHECK(at(99'999) == second);
  CHECK(at(100'000) == dark);
  CHECK(at(-1) == dark);
}

TEST_CASE("A picture equal to the one beneath takes no memory for its pixels") {
  std::mt19937 random(3);
  const Mask picture = random_mask(random, Pixels{500}, Pixels{500});
  PictureStack one(Pixels{500}, Pixels{500}, kLayer), many = one;
  one.add(picture);
  for (int layer = 0; layer < 100; ++layer)
    many.add(picture);
  CHECK(many.layers() == 100);
  CHECK(many.bytes() < 3 * one.bytes() + 100 * 4 * sizeof(std::size_t));
  Mask drawn(Pixels{500}, Pixels{500});
  many.draw(kLayer * 99, drawn);
  CHECK(drawn == picture);
}

TEST_CASE("The lit box of a stack encloses the lit pixels of all pictures") {
  PictureStack stack(Pixels{20}, Pixels{10}, kLayer);
  Mask picture(Pixels{20}, Pixels{10});
  stack.add(picture);
  CHECK(!stack.lit());
  picture.row(4)[7] = 1;
  stack.add(picture);
  CHECK(stack.lit() == PixelBox{7, 4, 8, 5});
  picture.row(4)[7] = 0;
  picture.row(2)[19] = 255;
  picture.row(9)[0] = 255;
  stack.add(picture);
  CHECK(stack.lit() == PixelBox{0, 2, 20, 10});
}
