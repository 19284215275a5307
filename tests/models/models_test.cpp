#include "tests/models/models.hpp"

#include "core/model/mesh_report.hpp"
#include "tests/catch.hpp"

TEST_CASE("The tests' own models are watertight and face outwards") {
  for (const models::Facets& facets :
       {models::box({0, 0, 0}, {1, 2, 3}), models::sphere(10, 12), models::gyroid_sphere(20, 10, 24)}) {
    const MeshReport report = inspect_mesh(facets);
    CHECK(report.watertight);
    CHECK(report.volume_mm3 > 0);
    CHECK(report.zero_area_facets == 0);
  }
}

TEST_CASE("A box of 1 by 2 by 3 mm has a volume of 6 cubic millimetres") {
  // Exact: all terms are small whole numbers.
  CHECK(inspect_mesh(models::box({0, 0, 0}, {1, 2, 3})).volume_mm3 == 6.0);
}
