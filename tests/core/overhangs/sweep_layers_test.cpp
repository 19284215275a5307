#include "core/overhangs/sweep_layers.hpp"

#include "tests/catch.hpp"

namespace {

constexpr Nanometers um(std::int64_t um) {
  return Nanometers{um * 1000};
}

}  // namespace

TEST_CASE("A sweep without a print's layers has layers of 50 um whose middles lie below the top") {
  const SweepLayers layers({}, Millimeters{0.13});
  REQUIRE(layers.count() == 3);
  CHECK(layers.middle_of(3) == um(125));
  CHECK(layers.step() == um(50));
  CHECK(SweepLayers({}, Millimeters{0.12}).count() == 2);
  CHECK(SweepLayers({}, Millimeters{}).count() == 0);
}

TEST_CASE("A sweep has a print's layers, and steps of 20 to 50 um") {
  const SweepLayers layers(std::vector{um(30), um(100), um(41)}, Millimeters{1});
  REQUIRE(layers.count() == 3);
  CHECK(layers.bottom_of(2) == um(30));
  CHECK(layers.middle_of(2) == um(80));
  CHECK(layers.top_of(3) == um(171));
  CHECK(layers.thickness_of(3) == um(41));
  CHECK(layers.step() == um(30));
  CHECK(SweepLayers(std::vector{um(100)}, Millimeters{1}).step() == um(50));
  CHECK(SweepLayers(std::vector{um(5)}, Millimeters{1}).step() == um(20));
}

TEST_CASE("A print with more layers than a sweep can number is swept by several layers at a time") {
  const SweepLayers layers(std::vector(2 * SweepLayers::kMostLayers + 1, um(1)), Millimeters{121});
  REQUIRE(layers.count() == 40'001);
  CHECK(layers.thickness_of(1) == um(3));
  CHECK(layers.top_of(40'001) == um(120'001));
}
