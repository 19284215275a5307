// Tests that the calibration models are sound meshes, stand on the plate and have the measures that they are
// for.
#include "core/calibration/calibration_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/calibration/joined_blocks.hpp"
#include "core/model/mesh_report.hpp"
#include "core/repair/mesh_soundness.hpp"
#include "tests/catch.hpp"

namespace {

void check_sound(const std::vector<Facet>& facets, std::uint64_t parts = 1) {
  const MeshReport report = inspect_mesh(facets);
  CHECK(report.watertight);
  CHECK(is_sound(facets));
  CHECK(report.non_manifold_edges == 0);
  CHECK(report.zero_area_facets == 0);
  CHECK(report.duplicate_facets == 0);
  CHECK(report.volume_mm3 > 0);
  CHECK(report.parts == parts);
  CHECK(report.bounds.min_z == 0);
  // Files stay small, and a Raspberry Pi reads them at once.
  CHECK(facets.size() < 20'000);
}

}  // namespace

TEST_CASE("Blocks that overlap, touch or lie apart are joined to one closed surface") {
  const std::array blocks{Block{{0, 0, 0}, {2, 2, 1}}, Block{{1, 1, 0}, {3, 3, 1}},
                          Block{{0, 0, 1}, {1, 1, 3}}, Block{{5, 0, 0}, {6, 1, 1}},
                          Block{{5, 0, 0}, {6, 1, 1}}};
  const std::vector<Facet> facets = joined(blocks);
  check_sound(facets, 2);
  CHECK(inspect_mesh(facets).volume_mm3 == Approx(4 + 4 - 1 + 2 + 1));
  CHECK(joined({}).empty());
}

TEST_CASE("Bridges begin at a layer's lower side, over the clearance") {
  for (const double layer_mm : {0.01, 0.025, 0.0333, 0.05, 0.1, 0.2})
    for (const double clearance_mm : {1.0, 4.0, 9.3}) {
      CAPTURE(layer_mm, clearance_mm);
      const std::vector<Facet> facets = bridge_model(Millimeters{layer_mm}, Millimeters{clearance_mm});
      check_sound(facets);
      const double top = inspect_mesh(facets).bounds.max_z;
      CHECK(std::abs(top / layer_mm - std::round(top / layer_mm)) < 1e-3);
      for (const int layers : kBridgeLayers) {
        const double underside = top - layers * layer_mm;
        CHECK(std::ranges::any_of(facets, [underside](const Facet& facet) {
          return std::abs(heights_of(facet).low - underside) < 1e-5 &&
                 heights_of(facet).high == heights_of(facet).low;
        }));
        CHECK(underside - 1 > clearance_mm - 1e-5);
      }
    }
}

TEST_CASE("The ladder has the lengths that are measured on it, along both axes") {
  const std::vector<Facet> facets = ladder_model();
  check_sound(facets, 2);
  const auto has_face = [&facets](auto coordinate, double at) {
    return std::ranges::any_of(facets, [&](const Facet& facet) {
      return std::ranges::all_of(
          facet.vertices, [&](const Vertex& vertex) { return std::abs(coordinate(vertex) - at) < 1e-5; });
    });
  };
  const double back = inspect_mesh(facets).bounds.max_y - 30;
  for (const LadderLength& length : ladder_lengths())
    for (const double end : {length.from.count(), length.to.count()}) {
      CAPTURE(end);
      CHECK(has_face([](const Vertex& vertex) { return static_cast<double>(vertex.x); }, end));
      CHECK(has_face([](const Vertex& vertex) { return static_cast<double>(vertex.y); }, back + end));
      CHECK(length.drawn_mm == Approx(length.to.count() - length.from.count()));
    }
}

TEST_CASE("A tower has a rib for each step's number, and nothing hangs over") {
  for (int steps = 1; steps <= kMostTowerSteps; ++steps) {
    CAPTURE(steps);
    const std::vector<Facet> facets = tower_model({steps, Millimeters{0.8}, Millimeters{2}});
    check_sound(facets);
    CHECK(inspect_mesh(facets).bounds.max_z == Approx(0.8 + 2 * steps));
    for (const Facet& facet : facets) {
      const auto& [a, b, c] = facet.vertices;
      const bool faces_down = heights_of(facet).low == heights_of(facet).high &&
                              (b.x - a.x) * (c.y - a.y) < (c.x - a.x) * (b.y - a.y);
      CHECK((!faces_down || heights_of(facet).low == 0));
    }
  }
}
