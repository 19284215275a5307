#include "core/repair/winding_probe.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::together;

namespace {

WindingProbe::Windings all(int winding) {
  WindingProbe::Windings windings;
  windings.fill(winding);
  return windings;
}

// Counts each face once, turned as its first facet is.
WindingProbe::Windings windings_around(const models::Facets& facets, const SpacePoint& point) {
  const FacetPatches mesh = patches_of(facets);
  return WindingProbe(facets, mesh.faces).windings_around(point, [](std::uint32_t) { return 1; });
}

}  // namespace

TEST_CASE("All rays from a point agree on how often a closed model winds around it", "[long]") {
  models::Facets cavity = models::sphere(3, 12);
  models::invert(cavity);
  const models::Facets ball = together(models::sphere(8, 20), cavity);
  const models::Facets both = together(ball, models::box({-20, -6, -6}, {0, 6, 6}));
  models::Dice dice(5);
  for (int i = 0; i < 500; ++i) {
    const Vertex v = dice.in_ball(12);
    const double distance = std::hypot(v.x, v.y, v.z);
    // The ball is a polyhedron: less than a fifth of a millimetre lies between it and the sphere.
    if (std::fabs(distance - 8) < 0.5 || std::fabs(distance - 3) < 0.5) continue;
    const int in_ball = distance < 8 && distance > 3 ? 1 : 0;
    const int in_box = v.x > -20 && v.x < 0 && std::fabs(v.y) < 6 && std::fabs(v.z) < 6 ? 1 : 0;
    CAPTURE(v.x, v.y, v.z);
    CHECK(windings_around(both, {v.x, v.y, v.z}) == all(in_ball + in_box));
  }
}

TEST_CASE("A ray through an edge, a vertex or beside the model counts like any other") {
  const models::Facets box = models::box({-1, -1, -1}, {1, 1, 1});
  CHECK(windings_around(box, {0, 0, 0}) == all(1));
  CHECK(windings_around(box, {5, 0, 0}) == all(0));
  CHECK(windings_around(box, {-50, 0.5, 70}) == all(0));
}

TEST_CASE("A face of weight 0 does not count") {
  const models::Facets box = models::box({-1, -1, -1}, {1, 1, 1});
  const FacetPatches mesh = patches_of(box);
  WindingProbe probe(box, mesh.faces);
  const auto lid = [&](std::uint32_t face) {
    const auto& v = box[mesh.faces[face].facet].vertices;
    return v[0].z == 1 && v[1].z == 1 && v[2].z == 1 ? 0 : 2;
  };
  CHECK(probe.windings_around({0.1, 0.2, 0.3}, lid) == WindingProbe::Windings{2, 2, 2, 2, 0, 2});
  CHECK(probe.looks() > 0);
}
