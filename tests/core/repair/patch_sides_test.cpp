#include "core/repair/patch_sides.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::Facets;
using models::inverted;
using models::together;

namespace {

struct Found {
  FacetPatches mesh;
  PatchSides sides;
};

Found sides_of(const Facets& facets) {
  Found found{patches_of(facets), {}};
  found.sides = find_sides(facets, found.mesh, balance_patches(found.mesh));
  return found;
}

// Returns the volume that the patches enclose with their windings.
double volume_of(const Found& found) {
  double six_volumes = 0;
  for (std::size_t p = 0; p < found.mesh.patches.size(); ++p)
    six_volumes += found.sides.windings[p] * found.mesh.patches[p].six_volumes;
  return six_volumes / 6;
}

Facets with_turned(Facets facets, std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < first + count; ++i)
    std::swap(facets[i].vertices[0], facets[i].vertices[1]);
  return facets;
}

const Facets& cube_of_10() {
  static const Facets facets = models::box({0, 0, 0}, {10, 10, 10});
  return facets;
}

}  // namespace

TEST_CASE("Patches without doubt stay as they are in the file") {
  const Found found = sides_of(together(cube_of_10(), inverted(models::box({3, 3, 3}, {6, 6, 6}))));
  CHECK(found.sides.as_filed == std::vector<bool>{true, true});
  CHECK(found.sides.inner_walls == std::vector<bool>{false, false});
}

TEST_CASE("An outermost shell is turned outwards, whatever most of its facets say") {
  for (const std::size_t turned : {1U, 5U, 6U, 7U, 11U}) {
    CAPTURE(turned);
    CHECK(volume_of(sides_of(with_turned(cube_of_10(), 0, turned))) == 1000);
  }
}

TEST_CASE(
    "A shell within a solid is turned as most of its facets are, or is a cavity if there is no majority") {
  const Facets both = together(cube_of_10(), models::box({3, 3, 3}, {5, 5, 5}));
  CHECK(volume_of(sides_of(with_turned(both, 12, 1))) == 1008);
  CHECK(volume_of(sides_of(with_turned(both, 12, 11))) == 992);
  CHECK(volume_of(sides_of(with_turned(both, 12, 6))) == 992);
}

TEST_CASE("A majority of three in four decides a shell's direction only if few facets are turned elsewhere") {
  const Facets both = together(cube_of_10(), models::box({3, 3, 3}, {5, 5, 5}));
  CHECK(volume_of(sides_of(with_turned(both, 12, 3))) == 1008);
  CHECK(volume_of(sides_of(with_turned(with_turned(both, 12, 3), 0, 6))) == 992);
}

TEST_CASE("A shell that is there twice is a hole in two solids and one solid by itself") {
  const Facets hole = inverted(models::box({3, 3, 3}, {5, 5, 5}));
  const Facets solids = together(cube_of_10(), models::box({1, 1, 1}, {9, 9, 9}));
  const double without = 1000 + 512 - 2 * 8;
  CHECK(volume_of(sides_of(together(solids, together(hole, hole)))) == without);
  CHECK(volume_of(sides_of(with_turned(together(solids, together(hole, hole)), 24, 1))) == without);
  CHECK(volume_of(sides_of(with_turned(together(cube_of_10(), cube_of_10()), 0, 1))) == 1000);
}

TEST_CASE("An open sheet within a solid is an inner wall, a sheet beside the solid is not") {
  const Facet within{{Vertex{2, 2, 2}, Vertex{7, 2, 2}, Vertex{2, 7, 7}}};
  const Facet beside{{Vertex{22, 2, 2}, Vertex{27, 2, 2}, Vertex{22, 7, 7}}};
  CHECK(sides_of(together(cube_of_10(), {within})).sides.inner_walls == std::vector<bool>{false, true});
  CHECK(sides_of(together(cube_of_10(), {beside})).sides.inner_walls == std::vector<bool>{false, false});
  // A cavity that lacks a facet is no sheet.
  Facets cavity = inverted(models::box({3, 3, 3}, {6, 6, 6}));
  cavity.pop_back();
  CHECK(sides_of(together(cube_of_10(), cavity)).sides.inner_walls == std::vector<bool>{false, false});
}
