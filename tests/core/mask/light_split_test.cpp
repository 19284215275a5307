#include "core/mask/light_split.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/allocation_counter.hpp"
#include "tests/catch.hpp"

namespace {

constexpr std::size_t kValues = 256;

// Returns a mask of one row with these values.
Mask row_of(const std::vector<int>& values) {
  Mask mask(Pixels{static_cast<std::int32_t>(values.size())}, Pixels{1});
  std::ranges::transform(values, mask.row(0).begin(),
                         [](int value) { return static_cast<std::uint8_t>(value); });
  return mask;
}

Mask all_values() {
  std::vector<int> values(kValues);
  for (std::size_t i = 0; i < kValues; ++i)
    values[i] = static_cast<int>(i);
  return row_of(values);
}

std::vector<Mask> pictures_of(const LightSplit& split, const Mask& light) {
  std::vector<Mask> pictures(split.pictures(), Mask(light.width(), light.height()));
  for (std::size_t i = 0; i < pictures.size(); ++i)
    split.draw(i, light, {0, light.height().count()}, pictures[i]);
  return pictures;
}

double end_of(const LightSplit& split, std::size_t picture) {
  return picture + 1 < split.pictures() ? split.begin(picture + 1) : 1;
}

// Returns the light that a panel makes of a grey value, by the definition of its levels.
double light_of(std::uint8_t grey, const PanelTone& panel) {
  const double greatest = std::pow(2, panel.grey_bits) - 1;
  const double level = std::round(grey * greatest / 255);
  CHECK(std::round(level * 255 / greatest) == grey);  // the panel has this level
  return std::pow(level / greatest, panel.gamma);
}

// Returns the light of a pixel in all pictures, by their times.
double light_in(const std::vector<Mask>& pictures, const LightSplit& split, std::size_t x,
                const PanelTone& panel) {
  double light = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    light += light_of(pictures[i].row(0)[x], panel) * (end_of(split, i) - split.begin(i));
  return light;
}

// Returns the greatest difference of light between neighbouring levels.
double widest_gap(const PanelTone& panel) {
  const double greatest = std::pow(2, panel.grey_bits) - 1;
  double widest = 0;
  for (double level = 1; level <= greatest; ++level)
    widest = std::max(
        widest, std::pow(level / greatest, panel.gamma) - std::pow((level - 1) / greatest, panel.gamma));
  return widest;
}

constexpr double kRounding = 1e-9;

// Checks the pictures of a mask with all shares of the light.
void check_all_shares(const PanelTone& panel, double shortest) {
  LightSplit split(panel);
  const Mask light = all_values();
  split.plan(light, shortest);
  const std::vector<Mask> pictures = pictures_of(split, light);
  const double steps = std::clamp(std::floor(1 / shortest), 1.0, 50.0);
  const double resolution = std::max(LightSplit::kExactness, widest_gap(panel) / (2 * steps));
  CHECK(split.error() <= resolution + kRounding);
  for (std::size_t i = 0; i < pictures.size() && pictures.size() > 1; ++i)
    CHECK(end_of(split, i) - split.begin(i) >= shortest - kRounding);
  double before = 0;
  for (std::size_t value = 0; value < kValues; ++value) {
    CAPTURE(value);
    const double given = light_in(pictures, split, value, panel);
    CHECK(std::abs(given - static_cast<double>(value) / 255) <= split.error() + kRounding);
    CHECK(std::abs(given - split.given(static_cast<std::uint8_t>(value))) <= kRounding);
    CHECK(given >= before - kRounding);
    before = given;
    for (std::size_t i = 1; i < pictures.size(); ++i)
      CHECK(pictures[i].row(0)[value] <= pictures[i - 1].row(0)[value]);
  }
}

}  // namespace

TEST_CASE("Pictures give every share of the light within the resolution, and each only darkens the last") {
  for (int bits = 1; bits <= 7; ++bits) {
    for (const double gamma : {1.0, 2.2, 3.0}) {
      for (const double shortest : {0.004, 0.0167, 0.05, 0.11, 0.5, 1.5}) {
        CAPTURE(bits, gamma, shortest);
        check_all_shares({bits, gamma}, shortest);
      }
    }
  }
}

TEST_CASE("A mask that the panel can show needs one picture, which is the mask") {
  LightSplit split({3, 1});
  const Mask light = row_of({0, 255, 36, 109, 219, 0, 0, 0, 0, 255, 255, 255});
  split.plan(light, 0.01);
  REQUIRE(split.pictures() == 1);
  CHECK(split.error() < 0.002);  // 36 is 1/7 of 255, rounded
  CHECK(pictures_of(split, light).front() == light);
}

TEST_CASE("A panel without grey needs two pictures for one share of the light, which is exact") {
  LightSplit split({1, 3});
  const Mask light = row_of({0, 0, 48, 255, 48});
  split.plan(light, 0.02);
  REQUIRE(split.pictures() == 2);
  CHECK(split.error() == 0);
  CHECK(split.begin(1) == 48.0 / 255);
  const std::vector<Mask> pictures = pictures_of(split, light);
  CHECK(pictures[0] == row_of({0, 0, 255, 255, 255}));
  CHECK(pictures[1] == row_of({0, 0, 0, 255, 0}));
}

TEST_CASE(
    "All greys need fewer pictures the more levels the panel has, and no more than exactness is worth") {
  for (const double shortest : {0.0167, 0.001}) {  // 50 ms, 3 ms of 3 s
    const auto pictures = [shortest](const PanelTone& panel) {
      LightSplit split(panel);
      split.plan(all_values(), shortest);
      CHECK(split.error() <= LightSplit::kExactness);
      return split.pictures();
    };
    CHECK(pictures({1, 3}) == 50);
    CHECK(pictures({3, 3}) == 19);
    CHECK(pictures({4, 3}) == 10);
  }
}

TEST_CASE("An exposure too short for two pictures shows the nearest levels") {
  LightSplit split({1, 1});
  const Mask light = row_of({0, 100, 127, 128, 200, 255});
  split.plan(light, 0.6);
  REQUIRE(split.pictures() == 1);
  CHECK(pictures_of(split, light).front() == row_of({0, 0, 0, 255, 255, 255}));
  CHECK(split.error() == 127.0 / 255);
  CHECK(split.begin(0) == 0);
}

TEST_CASE("A plan depends on its own mask only") {
  LightSplit split({1, 1}), fresh({1, 1});
  split.plan(all_values(), 0.02);
  const Mask light = row_of({0, 128, 255});
  split.plan(light, 0.02);
  fresh.plan(light, 0.02);
  CHECK(split.pictures() == fresh.pictures());
  CHECK(pictures_of(split, light) == pictures_of(fresh, light));
}

TEST_CASE("The light that is given in a layer is the sum of its pictures") {
  const PanelTone panel{1, 3};
  GivenLight given(panel, {0.6, 0.25});
  const Mask light = row_of({0, 60, 127, 200, 255});
  CHECK(given.of(0, light) == row_of({0, 0, 0, 255, 255}));
  CHECK(given.of(1, light) == row_of({0, 64, 128, 191, 255}));
  CHECK(given.of(1, row_of({0, 255})) == row_of({0, 255}));
}

TEST_CASE("Planning an exposure and drawing its pictures allocates nothing") {
  LightSplit split({1, 1});
  const Mask light = all_values(), plain = row_of({0, 255});
  Mask picture(light.width(), light.height());
  const long before = testing::allocations();
  split.plan(plain, 0.001);
  split.plan(light, 0.001);
  for (std::size_t i = 0; i < split.pictures(); ++i)
    split.draw(i, light, {0, 1}, picture);
  split.sum(light, picture);
  CHECK(testing::allocations() == before);
}
