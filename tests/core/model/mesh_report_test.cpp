#include "core/model/mesh_report.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

using models::together;

namespace {

models::Facets unit_box() {
  return models::box({0, 0, 0}, {1, 1, 1});
}

EnclosedVolume volume_of(const std::vector<Facet>& facets) {
  return enclosed_volume(facets, bounds_of(facets));
}

}  // namespace

TEST_CASE("The parts of a mesh that share no vertex are counted") {
  CHECK(inspect_mesh({}).parts == 0);
  CHECK(inspect_mesh(models::sphere(5, 8)).parts == 1);
  const models::Facets two = together(unit_box(), models::box({3, 0, 0}, {4, 1, 1}));
  CHECK(inspect_mesh(two).parts == 2);
  // A box that touches a corner of the first.
  CHECK(inspect_mesh(together(two, models::box({1, 1, 1}, {2, 2, 2}))).parts == 2);
  CHECK(inspect_mesh(together(two, models::box({1, 0, 0}, {3, 1, 1}))).parts == 1);
}

TEST_CASE("A sound model has nothing to report") {
  const MeshReport report = inspect_mesh(models::box({1, 2, 3}, {2, 4, 6}));
  CHECK(report.facets == 12);
  CHECK(report.watertight);
  CHECK(report.volume_mm3 == 6);
  CHECK_FALSE(report.inside_out);
  CHECK(report.open_edges == 0);
  CHECK(report.non_manifold_edges == 0);
  CHECK(report.flipped_edges == 0);
  CHECK(report.duplicate_facets == 0);
  CHECK(report.degenerate_facets == 0);
  CHECK(report.zero_area_facets == 0);
  CHECK(report.bounds.min_x == 1);
  CHECK(report.bounds.max_z == 6);
}

TEST_CASE("A model without facets is not watertight") {
  const MeshReport report = inspect_mesh({});
  CHECK(report.facets == 0);
  CHECK_FALSE(report.watertight);
  CHECK(report.volume_mm3 == 0);
  CHECK(report.bounds.empty());
}

TEST_CASE("A model that faces inwards is watertight and has a negative volume") {
  models::Facets facets = unit_box();
  models::invert(facets);
  const MeshReport report = inspect_mesh(facets);
  CHECK(report.watertight);
  CHECK(report.flipped_edges == 0);
  CHECK(report.volume_mm3 == -1);
  CHECK(report.inside_out);
}

TEST_CASE("A missing facet leaves three open edges") {
  models::Facets facets = unit_box();
  facets.pop_back();
  const MeshReport report = inspect_mesh(facets);
  CHECK(report.open_edges == 3);
  CHECK_FALSE(report.watertight);
  CHECK(report.flipped_edges == 0);
}

TEST_CASE("A turned facet has three flipped edges") {
  models::Facets facets = unit_box();
  std::swap(facets[4].vertices[0], facets[4].vertices[2]);
  const MeshReport report = inspect_mesh(facets);
  CHECK(report.flipped_edges == 3);
  CHECK(report.open_edges == 0);
  CHECK_FALSE(report.watertight);
  CHECK(report.duplicate_facets == 0);
}

TEST_CASE("A facet over an earlier one's vertices is a duplicate in any order and direction") {
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{2, 0, 1}, std::array{1, 0, 2}}) {
    models::Facets facets = unit_box();
    const auto vertices = facets[3].vertices;
    const auto at = [&vertices](int i) { return vertices[static_cast<std::size_t>(i)]; };
    facets.push_back({{at(a), at(b), at(c)}});
    const MeshReport report = inspect_mesh(facets);
    CHECK(report.duplicate_facets == 1);
    CHECK(report.non_manifold_edges == 3);
    CHECK_FALSE(report.watertight);
    facets.push_back(facets.back());
    CHECK(inspect_mesh(facets).duplicate_facets == 2);
  }
}

TEST_CASE("Two boxes that share a wall are watertight with non-manifold edges") {
  const MeshReport report = inspect_mesh(together(unit_box(), models::box({1, 0, 0}, {2, 1, 1})));
  CHECK(report.watertight);
  CHECK(report.volume_mm3 == 2);
  // The wall's four edges and, where both boxes cut it alike, its diagonal.
  CHECK(report.non_manifold_edges >= 4);
  CHECK(report.non_manifold_edges <= 5);
}

TEST_CASE("Two boxes that share an edge are watertight with one non-manifold edge") {
  const MeshReport report = inspect_mesh(together(unit_box(), models::box({1, 1, 0}, {2, 2, 1})));
  CHECK(report.watertight);
  CHECK(report.non_manifold_edges == 1);
}

TEST_CASE("Facets with equal vertices are degenerate and do not count as edges") {
  const Vertex a{0, 0, 0}, b{1, 0, 0};
  const MeshReport report =
      inspect_mesh(together(unit_box(), {{{a, a, b}}, {{a, b, a}}, {{b, a, a}}, {{a, a, a}}}));
  CHECK(report.degenerate_facets == 4);
  CHECK(report.zero_area_facets == 4);
  CHECK(report.duplicate_facets == 0);
  CHECK(report.watertight);
  const MeshReport alone = inspect_mesh(models::Facets{{{a, a, b}}});
  CHECK_FALSE(alone.watertight);
  CHECK(alone.open_edges == 0);
}

TEST_CASE("A facet of three points in a line has no area but is not degenerate") {
  const MeshReport report =
      inspect_mesh(models::Facets{{{Vertex{0, 0, 0}, Vertex{1, 2, 3}, Vertex{2, 4, 6}}}});
  CHECK(report.zero_area_facets == 1);
  CHECK(report.degenerate_facets == 0);
  CHECK(report.open_edges == 3);
}

TEST_CASE("Both zeros are one vertex") {
  models::Facets facets = unit_box();
  for (std::size_t i = 0; i < facets.size(); i += 2) {
    for (Vertex& v : facets[i].vertices) {
      if (v.x == 0) v.x = -0.0F;
      if (v.y == 0) v.y = -0.0F;
      if (v.z == 0) v.z = -0.0F;
    }
  }
  CHECK(inspect_mesh(facets).watertight);
}

TEST_CASE("Vertices that differ in one bit are different") {
  models::Facets facets = unit_box();
  facets[0].vertices[0].x = std::nextafter(facets[0].vertices[0].x, 2.0F);
  const MeshReport report = inspect_mesh(facets);
  CHECK(report.open_edges == 4);
  CHECK_FALSE(report.watertight);
}

TEST_CASE("A volume far from the origin keeps its digits") {
  // Whole numbers: every vertex, every difference and every product is exact.
  CHECK(inspect_mesh(models::box({1e6F, 2e6F, 3e6F}, {1e6F + 10, 2e6F + 10, 3e6F + 10})).volume_mm3 == 1000);
}

TEST_CASE("A ball has a ball's volume") {
  // A mesh of 40 cells across lies inside the ball: at most (cell / radius)^2 of the volume is missing, 0.3
  // %.
  const double ball = 4.0 / 3.0 * std::numbers::pi * 1000;
  const double volume = inspect_mesh(models::sphere(10, 40)).volume_mm3;
  CHECK(volume < ball);
  CHECK(volume > 0.997 * ball);
}

TEST_CASE("A report does not depend on the order of facets or on which corner comes first") {
  CHECK(rc::check([] {
    models::Facets facets = testing::draw_blobs(6);
    for (std::int64_t i = testing::draw(0, 5); i > 0 && facets.size() > 10; --i)
      facets.pop_back();
    facets.push_back(testing::draw_facet(5));
    const MeshReport report = inspect_mesh(facets);
    std::rotate(facets.begin(), facets.begin() + testing::draw(0, static_cast<std::int64_t>(facets.size())),
                facets.end());
    for (Facet& facet : facets)
      std::rotate(facet.vertices.begin(), facet.vertices.begin() + testing::draw(0, 2), facet.vertices.end());
    const MeshReport other = inspect_mesh(facets);
    RC_ASSERT(other.open_edges == report.open_edges);
    RC_ASSERT(other.non_manifold_edges == report.non_manifold_edges);
    RC_ASSERT(other.flipped_edges == report.flipped_edges);
    RC_ASSERT(other.duplicate_facets == report.duplicate_facets);
    RC_ASSERT(other.watertight == report.watertight);
    RC_ASSERT(report.open_edges >= 3U);
    // Sums of some thousand terms in another order.
    RC_ASSERT(std::fabs(other.volume_mm3 - report.volume_mm3) <= 1e-6);
  }));
}

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
