#include "core/support/support_mesh.hpp"

#include "core/model/mesh_report.hpp"
#include "tests/catch.hpp"
#include "tests/core/support/random_primitives.hpp"

namespace {

std::vector<Facet> mesh_of(const SupportPrimitive& primitive) {
  return support_mesh(std::span(&primitive, 1));
}

}  // namespace

TEST_CASE("A primitive's mesh is closed, faces outwards and has the primitive's volume") {
  const double pi = std::numbers::pi;
  const struct {
    SupportPrimitive primitive;
    double mm3;
  } cases[]{{Ball{{1, 2, 3}, 2}, pi * 32 / 3},
            {Frustum{{1, 2, 3}, {1, 2, 5}, 2, 1}, pi * 2 * 7 / 3},
            {Frustum{{1, 2, 3}, {4, 6, 3}, 1, 1}, pi * 5},
            {Frustum{{1, 2, 3}, {3, 4, 4}, 1, 0}, pi}};
  for (const auto& [primitive, mm3] : cases) {
    const MeshReport report = inspect_mesh(mesh_of(primitive));
    CHECK(report.watertight);
    // Facets are up to 0.02 mm inside radii of 1 mm and more.
    CHECK(report.volume_mm3 < mm3);
    CHECK(report.volume_mm3 > mm3 * 0.96);
  }
  CHECK(mesh_of(Ball{{0, 0, 0}, 0}).empty());
}

TEST_CASE("A mesh lies above the plate and inside its primitive, by at most kMeshErrorMm") {
  CHECK(rc::check([] {
    const SupportPrimitive primitive = draw_primitive();
    const std::vector<Facet> facets = mesh_of(primitive);
    RC_ASSERT(inspect_mesh(facets).watertight);  // the primitives' middles are above the plate
    for (const Facet& facet : facets) {
      const auto& [a, b, c] = facet.vertices;
      const PlatePoint middle{(double{a.x} + b.x + c.x) / 3, (double{a.y} + b.y + c.y) / 3,
                              (double{a.z} + b.z + c.z) / 3};
      const double off = outside(primitive, middle);
      // Coordinates are rounded by at most half a micrometre.
      RC_ASSERT(off < 1e-6);
      RC_ASSERT(std::min({a.z, b.z, c.z}) >= 0);
      const bool on_the_plate = std::max({a.z, b.z, c.z}) == 0;
      RC_ASSERT(off > -kMeshErrorMm || on_the_plate);
    }
  }));
}

TEST_CASE("A primitive that reaches below the plate has a mesh that ends in a flat face on the plate") {
  const double pi = std::numbers::pi;
  const MeshReport half = inspect_mesh(mesh_of(Ball{{1, 2, 0}, 2}));
  CHECK(half.watertight);
  CHECK(half.volume_mm3 == testing::Approx(pi * 16 / 3).epsilon(0.04));
  CHECK(mesh_of(Ball{{0, 0, -3}, 2}).empty());
}
