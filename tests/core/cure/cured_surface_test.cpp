// Tests that the surface of a cured part is closed, encloses the volume that the comparison reports, and lies
// at the heights that the working curve gives.
#include "core/cure/cured_surface.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "core/model/mesh_report.hpp"
#include "core/repair/mesh_soundness.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Nanometers kSurfaceLayer{50'000};
constexpr WorkingCurve kSurfaceCurve{Micrometers{150}, MillijoulesPerCm2{8}};

struct SurfacePrinting {
  DisplayGeometry display{Pixels{160}, Pixels{120}, Micrometers{50}};
  CureSettings cure{kSurfaceCurve};
  PixelLight pixel{};
  double overcure_um = 50;
};

struct Surface {
  models::Facets facets;
  MeshReport mesh;
  CureFigures figures;

  [[nodiscard]] double cured_mm3() const {
    return figures.model_mm3 + figures.too_much_mm3 - figures.too_little_mm3;
  }
};

Surface surface_of(models::Facets facets, const SurfacePrinting& printing = {}, std::int32_t step = 1) {
  auto model = std::make_shared<const HeightIndex>(std::move(facets));
  const LayerStack stack = layers_for(Millimeters{model->bounds().size_z()}, kSurfaceLayer);
  const PixelMap map = PixelMap::true_scale(printing.display, model->bounds().center());
  std::vector<PlateModel> models;
  models.push_back({{std::move(model)}, {map}});
  ContourEngine engine(std::move(models), {.display = printing.display});
  std::vector<LayerDose> layers;
  for (std::int32_t layer = 0; layer < stack.count; ++layer)
    layers.push_back({kSurfaceLayer * (layer + 1), kSurfaceLayer,
                      kSurfaceCurve.dose_for(Micrometers{50 + printing.overcure_um})});
  PrintCure print(engine, printing.display,
                  {.layers = layers, .cure = printing.cure, .pixel = printing.pixel}, {});
  Surface surface;
  surface.figures = print.compare(nullptr).value().figures;
  print.make_surface(step, [&](const Facet& facet) { surface.facets.push_back(facet); });
  surface.mesh = inspect_mesh(surface.facets);
  return surface;
}

void check_closed(const Surface& surface) {
  CHECK(surface.mesh.watertight);
  CHECK(surface.mesh.degenerate_facets == 0);
  CHECK(is_sound(surface.facets));
}

// Returns the least height of the surface over the middle of the plate.
double height_of_middle(const models::Facets& facets) {
  double lowest = 1e9;
  for (const Facet& facet : facets)
    for (const Vertex& vertex : facet.vertices)
      if (std::hypot(vertex.x, vertex.y) < 0.5) lowest = std::min(lowest, static_cast<double>(vertex.z));
  return lowest;
}

models::Facets bridge_of(int slab_layers) {
  const float slab_mm = 0.05F * static_cast<float>(slab_layers);
  return models::together({models::box({-3, -2, 0}, {-2, 2, 2}), models::box({2, -2, 0}, {3, 2, 2}),
                           models::box({-3, -2, 2}, {3, 2, 2 + slab_mm})});
}

}  // namespace

TEST_CASE("The surface of a cured box has its size, and encloses it but for chamfers of half a pixel") {
  const Surface box = surface_of(models::box({0, 0, 0}, {4, 3, 1}));
  check_closed(box);
  CHECK(box.mesh.bounds.min_x == Approx(-2));
  CHECK(box.mesh.bounds.max_x == Approx(2));
  CHECK(box.mesh.bounds.min_y == Approx(-1.5));
  CHECK(box.mesh.bounds.max_y == Approx(1.5));
  CHECK(box.mesh.bounds.min_z == 0);
  CHECK(box.mesh.bounds.max_z == Approx(1));
  CHECK(box.mesh.volume_mm3 == Approx(12 - 4 * 0.025 * 0.025 / 2).epsilon(1e-6));
}

TEST_CASE("Undersides of the surface lie at the height that the print-through gives, within a float") {
  for (const auto& [layers, too_low_um] :
       {std::pair(1, 50.0), {2, 131.0}, {4, 193.0}, {8, 228.0}, {16, 238.0}}) {
    CAPTURE(layers);
    const Surface bridge = surface_of(bridge_of(layers));
    check_closed(bridge);
    CHECK((2 - height_of_middle(bridge.facets)) * 1000 == Approx(too_low_um).margin(0.6));
    CHECK((2 - height_of_middle(bridge.facets)) * 1000 ==
          Approx(bridge.figures.undersides.median_um).margin(0.001));
  }
}

TEST_CASE("The surface of a cured ball encloses the volume of its columns, on coarser lines, too") {
  const Surface ball = surface_of(models::globe(2.5F, 64, 96));
  check_closed(ball);
  // Between pixels, walls are interpolated: they lie up to a 20th of a pixel farther out on average.
  CHECK(ball.mesh.volume_mm3 == Approx(ball.cured_mm3()).epsilon(3 * 0.05 / 50));
  CHECK(ball.mesh.parts == 1);
  for (const std::int32_t step : {2, 3, 7}) {
    CAPTURE(step);
    const Surface coarse = surface_of(models::globe(2.5F, 64, 96), {}, step);
    check_closed(coarse);
    CHECK(coarse.facets.size() < ball.facets.size() / static_cast<std::size_t>(step));
    CHECK(coarse.mesh.volume_mm3 == Approx(ball.mesh.volume_mm3).epsilon(0.01));
  }
}

TEST_CASE("Surfaces with little memory, oxygen, a dead zone or spread light are closed", "[long]") {
  SurfacePrinting printing;
  SECTION("no memory") {
    printing.cure.peel_memory = 0;
  }
  SECTION("memory and oxygen") {
    printing.cure.peel_memory = 0.75;
    printing.cure.oxygen_dose = MillijoulesPerCm2{0.3};
  }
  SECTION("a dead zone") {
    printing.cure.dead_zone = Micrometers{12};
  }
  SECTION("a dead zone higher than a layer") {
    printing.cure.dead_zone = Micrometers{60};
  }
  SECTION("light that does not reach down to the layer beneath") {
    printing.overcure_um = -10;
  }
  SECTION("light that solidifies just a layer") {
    printing.overcure_um = 0;
  }
  SECTION("light that solidifies nothing but rounding") {
    printing.overcure_um = -50;
  }
  SECTION("spread light") {
    printing.pixel = {{{0.5, 1}}};
  }
  const Surface globe = surface_of(models::globe(2, 32, 48), printing);
  if (printing.overcure_um > -50) check_closed(globe);
  CHECK(globe.mesh.volume_mm3 ==
        Approx(globe.cured_mm3()).epsilon(printing.pixel.gaussians.empty() ? 0.004 : 0.03));
  const Surface bridge = surface_of(bridge_of(20), printing);
  if (printing.overcure_um > -50) check_closed(bridge);
}

TEST_CASE("A gap that is thinner than a layer stays open in the surface") {
  // 239 um of a gap of 250 um close; 11 um are left below the middle.
  const Surface gap = surface_of(models::together(bridge_of(60), models::box({-2, -2, 0}, {2, 2, 1.75F})));
  check_closed(gap);
  CHECK(gap.figures.closed_mm2 == 0);
  CHECK(gap.mesh.volume_mm3 == Approx(gap.cured_mm3()).epsilon(0.0005));
}

TEST_CASE("A part at the display's edges is closed there, and faces outwards on mirrored displays") {
  for (const bool mirror_x : {false, true}) {
    for (const bool mirror_y : {false, true}) {
      const Surface wide = surface_of(
          models::together(models::box({0, 0, 0}, {9, 9, 0.5F}), models::box({0, 0, 0.5F}, {4, 3, 1})),
          {.display = {Pixels{160}, Pixels{120}, Micrometers{50}, mirror_x, mirror_y}});
      check_closed(wide);
      CHECK(wide.mesh.volume_mm3 == Approx(8 * 6 * 0.5 + 3.5 * 1.5 * 0.5).epsilon(0.001));
      CHECK(wide.mesh.bounds.max_x == Approx(4));
      CHECK(wide.mesh.bounds.min_y == Approx(-3));
    }
  }
}

TEST_CASE("A part of one pixel and one layer has a surface, one beside all lines has none") {
  const SurfacePrinting one{.display = {Pixels{1}, Pixels{1}, Micrometers{50}}};
  const Surface pixel = surface_of(models::box({0, 0, 0}, {1, 1, 0.05F}), one);
  check_closed(pixel);
  CHECK(pixel.mesh.bounds.max_z == Approx(0.05));
  CHECK(surface_of(models::box({0, 0, 0}, {0.1F, 0.1F, 0.5F}), {}, 1000).facets.size() > 0);
}

TEST_CASE("A surface requires lines through pixels, and a dose for each pixel") {
  const DisplayGeometry display;
  const auto ignore = [](const Facet&) {};
  CHECK(contract_broken_by([&] {
          CuredSurface(display, {0, 0, 2, 2}, 0, ignore);
        }) == "there are lines through pixels");
  CHECK(contract_broken_by([&] {
          CuredSurface(display, {0, 0, 0, 2}, 1, ignore);
        }) == "there are lines through pixels");
  CHECK(contract_broken_by([&] {
          const std::vector<float> dose(3);
          CuredSurface(display, {0, 0, 2, 2}, 1, ignore)
              .add_layer({kSurfaceLayer, kSurfaceLayer}, CuredLayers({.curve = kSurfaceCurve}, 4), dose);
        }) == "each pixel has a dose");
}
