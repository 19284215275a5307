#include "core/repair/facet_patches.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

TEST_CASE("A closed model is one patch without boundary edges, with all facets turned alike") {
  const FacetPatches mesh = patches_of(models::box({0, 0, 0}, {2, 3, 4}));
  CHECK(mesh.faces.size() == 12);
  REQUIRE(mesh.patches.size() == 1);
  const Patch& patch = mesh.patches[0];
  CHECK(patch.is_even());
  CHECK(patch.net == 12);
  CHECK(patch.boundary_edges == 0);
  CHECK(mesh.boundary_edges.empty());
  CHECK(mesh.junctions == 0);
  CHECK(patch.area == 52);
  CHECK(patch.six_volumes == 6 * 24);
  CHECK(std::fabs(patch.area_x) + std::fabs(patch.area_y) + std::fabs(patch.area_z) == 0);
}

namespace {

// True if this facet of a ball around the origin faces outwards.
bool faces_outwards(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double nx = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
  const double ny = (b.z - a.z) * (c.x - a.x) - (b.x - a.x) * (c.z - a.z);
  const double nz = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  return nx * a.x + ny * a.y + nz * a.z > 0;
}

}  // namespace

TEST_CASE("Turned facets are marked as turned against their patch") {
  models::Facets facets = models::sphere(10, 20);
  models::Dice dice(2);
  models::turn_facets(facets, 0.3, dice);
  const FacetPatches mesh = patches_of(facets);
  REQUIRE(mesh.patches.size() == 1);
  CHECK(mesh.patches[0].orientable);
  CHECK_FALSE(mesh.patches[0].is_even());
  std::size_t outwards = 0;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    outwards += faces_outwards(facets[mesh.faces[f].facet]) == (mesh.places[f].reversed == 0) ? 1U : 0U;
  CHECK((outwards == 0 || outwards == facets.size()));
}

TEST_CASE("Facets over the same vertices are one face whose net is the sum of their directions") {
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  const auto [a, b, c] = facets[5].vertices;
  facets.insert(facets.end(), {{{b, c, a}}, {{a, c, b}}, {{c, a, b}}});
  const FacetPatches mesh = patches_of(facets);
  CHECK(mesh.faces.size() == 12);
  CHECK(mesh.face_of[12] == mesh.face_of[5]);
  const Face& face = mesh.faces[mesh.face_of[5]];
  CHECK(face.copies == 4);
  CHECK(face.net == 2);
  CHECK(mesh.patches[0].odd == 11);
  CHECK(mesh.patches[0].with_net == std::array<std::uint32_t, 7>{0, 0, 0, 0, 11, 1, 0});
}

TEST_CASE("A facet with two equal vertices belongs to no face") {
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  facets.push_back({{Vertex{0, 0, 0}, Vertex{1, 1, 1}, Vertex{0, 0, 0}}});
  CHECK(patches_of(facets).face_of.back() == FacetPatches::kNone);
}

TEST_CASE("Patches end where three or more faces meet") {
  // A wall across a box, along edges that it has: the box's halves and the wall.
  models::Facets facets = models::box({0, 0, 0}, {1, 1, 1});
  const Vertex a{0, 0, 0}, b{1, 1, 0}, c{1, 1, 1}, d{0, 0, 1};
  facets.insert(facets.end(), {{{a, b, c}}, {{a, c, d}}});
  const FacetPatches mesh = patches_of(facets);
  CHECK(mesh.junctions > 0);
  CHECK(mesh.patches.size() > 1);
  for (const JunctionPart& part : mesh.junction_parts)
    CHECK(part.junction < mesh.junctions);
}

TEST_CASE("A band with half a turn cannot be turned alike") {
  models::Facets band;
  constexpr int kSteps = 8;
  const auto at = [](int step, float side) {
    const double angle = step * 2 * 3.14159 / kSteps, half = angle / 2;
    const double radius = 10 + side * std::cos(half);
    return Vertex{static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)),
                  static_cast<float>(side * std::sin(half))};
  };
  for (int step = 0; step < kSteps; ++step) {
    const bool last = step + 1 == kSteps;
    const Vertex a = at(step, -1), b = at(step, 1), c = last ? at(0, -1) : at(step + 1, 1),
                 d = last ? at(0, 1) : at(step + 1, -1);
    band.insert(band.end(), {{{a, b, c}}, {{a, c, d}}});
  }
  const FacetPatches mesh = patches_of(band);
  REQUIRE(mesh.patches.size() == 1);
  CHECK_FALSE(mesh.patches[0].orientable);
}
