#include "core/repair/wall_ends.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::Facets;

namespace {

// Returns a wall of two facets, 10 mm wide and high, from (x, y, 0) along x.
Facets wall(float x, float y) {
  const Vertex a{x, y, 0}, b{x + 10, y, 0}, c{x + 10, y, 10}, d{x, y, 10};
  return {{{a, b, c}}, {{a, c, d}}};
}

// Returns how many patches remain walls if the first `walls` patches are taken for walls.
std::ptrdiff_t kept(const Facets& facets, std::size_t walls) {
  const FacetPatches mesh = patches_of(facets);
  std::vector<bool> chosen(mesh.patches.size(), false);
  std::fill_n(chosen.begin(), walls, true);
  keep_walls_that_end(facets, mesh, chosen);
  return std::count(chosen.begin(), chosen.end(), true);
}

}  // namespace

TEST_CASE("Walls that end all around stay walls, however many there are") {
  CHECK(kept(wall(0, 0), 1) == 1);
  CHECK(kept(models::together(wall(0, 0), wall(0, 5)), 2) == 2);
  CHECK(kept(wall(0, 0), 0) == 0);
}

TEST_CASE("A wall that continues in another within a pixel is grouped with it") {
  for (const float gap : {0.0F, 0.001F, 0.04F}) {
    const Facets both = models::together(wall(0, 0), wall(10, gap));
    // Without a gap they share an edge and are one patch.
    const std::size_t patches = gap == 0 ? 1 : 2;
    CHECK(kept(both, patches) == static_cast<std::ptrdiff_t>(patches));
    if (patches == 2) CHECK(kept(both, 1) == 0);
  }
  CHECK(kept(models::together(wall(0, 0), wall(10, 0.06F)), 1) == 1);
}

TEST_CASE("A surface that ends nowhere is no wall, even if none of its facets meets another exactly") {
  Facets ball = models::sphere(6, 16);
  models::Dice dice(3);
  models::shake_corners(ball, 0.005, dice);
  REQUIRE(patches_of(ball).patches.size() == ball.size());
  CHECK(kept(ball, ball.size()) == 0);
}

TEST_CASE("A patch with more ends in one place than can be compared is no wall") {
  Facets fan;
  for (int i = 0; i < 1500; ++i) {
    const auto at = static_cast<float>(i);
    fan.push_back({{Vertex{0, 0, 1e-6F * at}, Vertex{10, at, 0}, Vertex{10, at, 5}}});
  }
  CHECK(kept(fan, fan.size()) == 0);
}
