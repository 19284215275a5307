#include "core/orientation/rated_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

double surface_of(std::span<const Facet> facets) {
  double sum = 0;
  for (const Facet& facet : facets)
    sum += length_of(area_of(facet));
  return sum;
}

}  // namespace

TEST_CASE("A sample represents the whole surface and contains every large facet") {
  models::Facets facets = models::sphere(10, 60);
  const models::Facets large = models::box({20, 20, 20}, {40, 40, 40});
  facets.insert(facets.end(), large.begin(), large.end());
  const FacetSample sample = sample_of(facets, {}, 1000);
  REQUIRE(sample.facets.size() <= 1000);
  REQUIRE(sample.facets.size() > 300);  // two thirds of the surface are the box'
  double stands_for = 0;
  std::size_t of_box = 0;
  for (std::size_t i = 0; i < sample.facets.size(); ++i) {
    stands_for += sample.weights[i] * length_of(area_of(sample.facets[i]));
    if (sample.facets[i].vertices[0].x >= 20) ++of_box;
  }
  const double surface = surface_of(facets);
  CHECK(std::abs(stands_for - surface) <= surface / 1000 * 1.001);  // but for the last part
  CHECK(of_box == 12);
}

TEST_CASE("A sample of facets without area is empty") {
  const Vertex v{1, 1, 1};
  const Facet facets[]{{{v, v, v}}};
  CHECK(sample_of(facets, {}, 10).facets.empty());
}

TEST_CASE("A rated mesh has each vertex once, and areas that face outwards") {
  const models::Facets facets = models::box({0, 0, 0}, {10, 20, 30});
  const RatedMesh mesh({.facets = facets});
  CHECK(mesh.vertices().size() == 8);
  double upwards = 0;
  for (const RatedMesh::Side& side : mesh.sides())
    upwards += std::max(0.0, side.along({0, 0, 1}));
  CHECK(upwards == 200);
  double of_top = 0;
  for (const RatedMesh::Side& side : mesh.sides())
    if (std::ranges::all_of(side.corners, [&](auto v) { return mesh.vertices()[v].z == 30; }))
      of_top += side.along({0, 0, 1});
  CHECK(of_top == 200);
}

TEST_CASE("A sample takes no facet that does not count, and the others for all of the surface that counts") {
  const models::Facets facets = models::together(models::box({0, 0, 0}, {10, 10, 10}), models::sphere(3, 20));
  std::vector<double> exposed(facets.size(), 0.0);
  std::fill_n(exposed.begin(), 12, 0.5);
  const FacetSample sample = sample_of(facets, exposed, 100);
  double stands_for = 0;
  for (std::size_t i = 0; i < sample.facets.size(); ++i)
    stands_for += sample.weights[i] * length_of(area_of(sample.facets[i]));
  CHECK(sample.facets.size() == 12);
  CHECK(std::abs(stands_for - 300) <= 300 * 0.0101);  // but for the last part
}

TEST_CASE("Vertices in the same cube of the grid have the same cell") {
  const models::Facets facets = models::box({0, 0, 0}, {1, 1, 5});
  const RatedMesh mesh({.facets = facets, .cell_mm = 3});
  CHECK(mesh.cells() == 2);
  std::set<std::uint32_t> low, high;
  for (std::uint32_t v = 0; v < mesh.vertices().size(); ++v)
    (mesh.vertices()[v].z == 0 ? low : high).insert(mesh.cell_of(v));
  CHECK(low.size() == 1);
  CHECK(high.size() == 1);
  CHECK(low != high);
}

TEST_CASE("Facets to be kept clean face a direction or lie in a box") {
  const models::Facets facets = models::box({0, 0, 0}, {10, 10, 10});
  const auto kept = [&](const KeepClean& each) {
    const KeepClean all[]{each};
    const RatedMesh mesh({.facets = facets, .keep_clean = all});
    return std::ranges::count(mesh.sides(), true, &RatedMesh::Side::keep_clean);
  };
  CHECK(kept(Direction{0, 0, 7}) == 2);
  CHECK(kept(Direction{0.2, 0.1, 1}) == 2);
  CHECK(kept(Direction{1, 1, 1}) == 0);  // 55 degrees from each
  CHECK(kept(KeepCleanBox{{-1, -1, 9}, {11, 11, 11}}) == 2);
  CHECK(kept(KeepCleanBox{{-1, -1, -1}, {11, 11, 11}}) == 12);
  CHECK(kept(KeepCleanBox{{20, 20, 20}, {30, 30, 30}}) == 0);
}
