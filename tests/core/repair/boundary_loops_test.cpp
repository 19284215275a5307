#include "core/repair/boundary_loops.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"

TEST_CASE("The missing area of open boxes is that of their lids, loop by loop") {
  models::Facets facets = models::box({0, 0, 0}, {2, 3, 4});
  const auto is_level = [](const Facet& facet) {
    const auto& [a, b, c] = facet.vertices;
    return a.z == b.z && b.z == c.z;
  };
  std::erase_if(facets, is_level);
  const FacetPatches mesh = patches_of(facets);
  CHECK(mesh.boundary_edges.size() == 8);
  CHECK(mesh.patches[0].boundary_edges == 8);
  CHECK(area_to_close(facets, mesh.faces, mesh.boundary_edges) == Approx(12).epsilon(1e-12));
  CHECK(area_to_close(facets, mesh.faces, {}) == 0);
}
