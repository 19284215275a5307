#include "core/model/enclosed_volume.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

EnclosedVolume volume_of(const std::vector<Facet>& facets) {
  return enclosed_volume(facets, bounds_of(facets));
}

}  // namespace

TEST_CASE("No facets enclose no volume") {
  CHECK(volume_of({}).mm3 == 0);
  CHECK(volume_of({}).uncertainty_mm3 == 0);
}

TEST_CASE("A closed model has its volume without uncertainty, wherever it lies") {
  // 20^3; coordinates of 10,000 mm in float are exact to 1 um.
  const auto far = Vertex{10'000, -10'000, 5'000};
  const models::Facets cube = models::box({far.x, far.y, far.z}, {far.x + 20, far.y + 20, far.z + 20});
  CHECK(volume_of(cube).mm3 == 8000);
  CHECK(volume_of(cube).uncertainty_mm3 == 0);
}

TEST_CASE("A model whose facets face inwards has a negative volume") {
  models::Facets cube = models::box({0, 0, 0}, {20, 20, 20});
  models::invert(cube);
  CHECK(volume_of(cube).mm3 == -8000);
}

TEST_CASE("An open sheet is not inside out: its volume is uncertain") {
  models::Facets sheet = models::box({0, 0, 0}, {20, 20, 20});
  sheet.resize(2);  // one side
  CHECK(volume_of(sheet).uncertainty_mm3 >= std::abs(volume_of(sheet).mm3));
  CHECK(volume_of(sheet).uncertainty_mm3 > 0);
}
