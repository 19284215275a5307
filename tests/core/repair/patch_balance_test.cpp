#include "core/repair/patch_balance.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::Facets;
using models::inverted;
using models::together;

namespace {

Facets cube_of_4() {
  return models::box({0, 0, 0}, {4, 4, 4});
}

// Returns by how many sides the patches miss balance, over all junctions.
int imbalance(const FacetPatches& mesh, const std::vector<std::int32_t>& windings) {
  std::vector<int> residuals(mesh.junctions, 0);
  for (const JunctionPart& part : mesh.junction_parts)
    residuals[part.junction] += part.sides * windings[part.patch];
  int sum = 0;
  for (const int residual : residuals)
    sum += std::abs(residual);
  return sum;
}

}  // namespace

TEST_CASE("Solids that do not meet are groups of their own, and consistent") {
  const FacetPatches mesh = patches_of(together(cube_of_4(), models::box({9, 0, 0}, {12, 3, 3})));
  const PatchGroups groups = balance_patches(mesh);
  REQUIRE(groups.groups.size() == 2);
  CHECK(groups.windings == std::vector<std::int32_t>{1, 1});
  for (const PatchGroups::Group& group : groups.groups) {
    CHECK_FALSE(group.inconsistent);
    CHECK_FALSE(group.double_sided);
  }
}

TEST_CASE("The majority of a patch's facets decides how it is turned") {
  Facets facets = inverted(cube_of_4());
  std::swap(facets[3].vertices[0], facets[3].vertices[1]);
  const FacetPatches mesh = patches_of(facets);
  const PatchGroups groups = balance_patches(mesh);
  REQUIRE(groups.groups.size() == 1);
  CHECK(groups.groups[0].inconsistent);
  // The first facet, which sets the patch's direction, is one of the majority.
  CHECK(groups.windings[0] == 1);
}

TEST_CASE("A solid that is there in both directions is double-sided and counts once") {
  const FacetPatches mesh = patches_of(together(cube_of_4(), inverted(cube_of_4())));
  const PatchGroups groups = balance_patches(mesh);
  REQUIRE(groups.groups.size() == 1);
  CHECK(groups.groups[0].double_sided);
  CHECK(std::abs(groups.windings[0]) == 1);
}

TEST_CASE("A solid that is there twice counts twice") {
  const PatchGroups groups = balance_patches(patches_of(together(cube_of_4(), cube_of_4())));
  CHECK(groups.windings == std::vector<std::int32_t>{2});
  CHECK_FALSE(groups.groups[0].inconsistent);
}

TEST_CASE("Turned patches are turned back until all junctions are balanced") {
  // A row of boxes wall to wall, with a few facets turned.
  Facets clean;
  for (int i = 0; i < 5; ++i) {
    const float x = 4 * static_cast<float>(i);
    clean = together(clean, models::box({x, 0, 0}, {x + 4, 4, 4}));
  }
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Facets facets = clean;
    models::Dice dice(seed);
    for (int i = 0; i < 3; ++i) {
      Facet& facet = facets[dice.below(facets.size())];
      std::swap(facet.vertices[0], facet.vertices[1]);
    }
    const FacetPatches mesh = patches_of(facets);
    REQUIRE(mesh.junctions > 0);
    CAPTURE(seed);
    CHECK(imbalance(mesh, balance_patches(mesh).windings) == 0);
  }
}
