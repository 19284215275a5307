#include "core/model/standing_model.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

// The bounds of a model from z = -3 to 5 mm.
const Bounds kModel = bounds_of(models::box({0, 0, -3}, {1, 1, 5}));

}  // namespace

TEST_CASE("A model stands with its lowest point on the plate") {
  const Elevation on_plate;
  CHECK(on_plate.z_at(Nanometers{0}, kModel) == Millimeters{-3});
  CHECK(on_plate.z_at(Nanometers{8'000'000}, kModel) == Millimeters{5});
  CHECK(on_plate.top(kModel) == Millimeters{8});
  CHECK(on_plate.lift(kModel) == Millimeters{3});
}

TEST_CASE("A model that stands above the plate is higher everywhere by that distance") {
  const Elevation raised(Nanometers{2'500'000});
  CHECK(raised.z_at(Nanometers{2'500'000}, kModel) == Millimeters{-3});
  CHECK(raised.z_at(Nanometers{0}, kModel) == Millimeters{-5.5});
  CHECK(raised.top(kModel) == Millimeters{10.5});
  CHECK(raised.lift(kModel) == Millimeters{5.5});
}

TEST_CASE("A height converts to z and back to the nanometre") {
  for (const Elevation elevation :
       {Elevation(), Elevation(Nanometers{1}), Elevation(Nanometers{123'456'789})}) {
    for (const Nanometers height : {Nanometers{0}, Nanometers{1}, Nanometers{2'500}, Nanometers{987'654'321}})
      CHECK(elevation.height_at(elevation.z_at(height, kModel), kModel) == height);
  }
}

TEST_CASE("A z beyond the range of heights has no height") {
  CHECK_FALSE(Elevation().height_at(Millimeters{1e30}, kModel));
}

TEST_CASE("A standing model converts heights to its z and returns its top") {
  const StandingModel model{std::make_shared<const HeightIndex>(models::box({0, 0, -3}, {1, 1, 5})),
                            Elevation(Nanometers{2'500'000})};
  CHECK(model.z_at(Nanometers{3'500'000}) == Millimeters{-2});
  CHECK(model.top() == Millimeters{10.5});
}
