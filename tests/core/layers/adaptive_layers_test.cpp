#include "core/layers/adaptive_layers.hpp"

#include "core/layers/print_layers.hpp"
#include "core/model/placement.hpp"
#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

constexpr Nanometers um(std::int64_t count) {
  return Nanometers{count * 1000};
}

constexpr AdaptiveLayers kLimits{um(20), um(100), um(15)};

struct PlacedLayer {
  Nanometers bottom, thickness;
};

std::vector<PlacedLayer> layers_of(const std::vector<models::Facets>& all,
                                   const AdaptiveLayers& limits = kLimits, Elevation elevation = {}) {
  std::vector<StandingModel> models;
  for (const models::Facets& facets : all)
    models.push_back({std::make_shared<const HeightIndex>(facets), elevation});
  std::vector<PlacedLayer> layers;
  Nanometers bottom{};
  for (const Nanometers thickness : PrintLayers(models, limits).all()) {
    layers.push_back({bottom, thickness});
    bottom += thickness;
  }
  return layers;
}

bool has_boundary(const std::vector<PlacedLayer>& layers, Nanometers height) {
  return std::ranges::any_of(layers, [&](const PlacedLayer& layer) { return layer.bottom == height; });
}

// Returns the widest cusp of a layer, by the definition and without the index: t |n_z| over all facets with
// more than half a micrometre of height in the layer, or a flat facet well within it.
double widest_cusp_um(const models::Facets& facets, double plate_z, const PlacedLayer& layer) {
  const double low = plate_z + to_millimeters(layer.bottom).count() + 0.00051;
  const double high = plate_z + to_millimeters(layer.bottom + layer.thickness).count() - 0.00051;
  double widest = 0;
  for (const Facet& f : facets) {
    const auto [a, b, c] = f.vertices;
    if (std::max({a.z, b.z, c.z}) <= low || std::min({a.z, b.z, c.z}) >= high) continue;
    const double ux = double(b.x) - a.x, uy = double(b.y) - a.y, uz = double(b.z) - a.z;
    const double vx = double(c.x) - a.x, vy = double(c.y) - a.y, vz = double(c.z) - a.z;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double length = std::hypot(nx, ny, nz);
    if (length > 0)
      widest = std::max(widest, to_millimeters(layer.thickness).count() * 1000 * std::fabs(nz) / length);
  }
  return widest;
}

}  // namespace

TEST_CASE("A box has layers of the largest thickness up to its top") {
  const std::vector<PlacedLayer> layers = layers_of({models::box({0, 0, -3}, {5, 5, -1})});
  REQUIRE(layers.size() == 20);
  for (const PlacedLayer& layer : layers)
    CHECK(layer.thickness == um(100));
}

TEST_CASE("A flat face lies at a layer's boundary, and no layer before it is too thin") {
  for (const std::int64_t step_um : {1'000, 1'010, 1'019, 1'050, 1'099}) {
    CAPTURE(step_um);
    const auto z = static_cast<float>(static_cast<double>(step_um) / 1e3);
    const auto stairs =
        models::together(models::box({0, 0, 0}, {9, 9, z}), models::box({3, 3, z}, {6, 6, 3}));
    const std::vector<PlacedLayer> layers = layers_of({stairs});
    CHECK(has_boundary(layers, um(step_um)));
    CHECK(layers.back().bottom + layers.back().thickness == um(3'000));
    for (const PlacedLayer& layer : layers)
      CHECK((layer.thickness >= um(20) && layer.thickness <= um(100)));
    // No more layers than needed: ten or eleven below the step, twenty above or one more.
    CHECK(layers.size() <= 32);
  }
}

TEST_CASE("A flat face too near to the one below gets no layer boundary: the thinnest layer passes it") {
  const auto stairs =
      models::together(models::box({0, 0, 0}, {9, 9, 0.005F}), models::box({3, 3, 0.005F}, {6, 6, 1}));
  const std::vector<PlacedLayer> layers = layers_of({stairs});
  CHECK(layers[0].thickness == um(20));
  CHECK(layers[1].thickness == um(100));
}

TEST_CASE("Below a model above the plate layers are the thickest, and its own are as on the plate") {
  const std::vector<PlacedLayer> low = layers_of({models::cone(9, 1, 40)});
  const std::vector<PlacedLayer> high = layers_of({models::cone(9, 1, 40)}, kLimits, Elevation(um(5'000)));
  REQUIRE(high.size() == low.size() + 50);
  for (std::size_t i = 0; i < 50; ++i)
    CHECK(high[i].thickness == um(100));
  for (std::size_t i = 0; i < low.size(); ++i)
    CHECK(high[i + 50].thickness == low[i].thickness);
}

TEST_CASE("A layer ends where a model above the plate begins") {
  const std::vector<PlacedLayer> layers =
      layers_of({models::box({0, 0, 3}, {5, 5, 4})}, kLimits, Elevation(um(330)));
  const auto begins = [](const PlacedLayer& layer) { return layer.bottom == um(330); };
  CHECK(std::ranges::any_of(layers, begins));
}

TEST_CASE("A tip without a flat face gets a last layer of the thinnest thickness, not less") {
  const std::vector<PlacedLayer> layers = layers_of({models::cone(0.1F, 2.01F, 40)});
  REQUIRE(layers.size() == 21);
  CHECK(layers[18].thickness == um(100));
  CHECK(layers[19].thickness == um(90));
  CHECK(layers[20].thickness == um(20));
}

TEST_CASE("A remainder that does not reach the middle of the thinnest layer is no layer") {
  // Without a cusp that matters, layers of 100 um: 20 of them, and a remainder.
  constexpr AdaptiveLayers kWalls{um(100), um(100), um(15)};
  CHECK(layers_of({models::box({0, 0, 0}, {5, 5, 2.01F})}, kWalls).size() == 20);
  CHECK(layers_of({models::box({0, 0, 0}, {5, 5, 2.049F})}, kWalls).size() == 20);
  CHECK(layers_of({models::box({0, 0, 0}, {5, 5, 2.051F})}, kWalls).size() == 21);
  CHECK(
      layers_of({models::box({0, 0, 0}, {5, 5, 2}), models::box({0, 0, 0}, {5, 5, 2.01F})}, kWalls).size() ==
      20);
  CHECK(layers_of({models::box({0, 0, 0}, {5, 5, 0.04F})}, kWalls).empty());
}

TEST_CASE("A sphere's layers are thin at its poles and thick at its equator") {
  const models::Facets sphere = models::globe(5, 200, 64);
  const std::vector<PlacedLayer> layers = layers_of({sphere});
  CHECK(layers.front().thickness == um(20));
  CHECK(layers.back().thickness <= um(20));
  const auto equator =
      std::ranges::find_if(layers, [](const PlacedLayer& layer) { return layer.bottom >= um(4'950); });
  REQUIRE(equator != layers.end());
  CHECK(equator->thickness == um(100));
  // 20 um at a slope of 15/20, from there t = cusp / |n_z|: in the northern half never thicker than before.
  for (auto layer = equator; layer + 2 < layers.end(); ++layer)
    CHECK((layer + 1)->thickness <= layer->thickness);
  CHECK(std::ranges::count_if(
            layers, [](const PlacedLayer& l) { return l.thickness > um(40) && l.thickness < um(80); }) > 4);
}

TEST_CASE("No layer's cusp is wider than allowed unless it is the thinnest, and the layers reach the top") {
  CHECK(rc::check([] {
    const std::int64_t thinnest = draw(5, 40), thickest = thinnest + draw(0, 150);
    const AdaptiveLayers limits{um(thinnest), um(thickest), Nanometers{draw(1'000, 60'000)}};
    models::Facets model;
    switch (draw(0, 2)) {
      case 0:
        model = draw(0, 1) == 1 ? models::sphere(draw_real(0.5, 2), static_cast<int>(draw(4, 16)))
                                : models::globe(draw_real(0.5, 2), static_cast<int>(draw(3, 40)), 12);
        break;
      case 1:
        model = models::box({0, 0, 0}, {1, 2, static_cast<float>(draw_real(0.2, 3))});
        break;
      default:
        model = models::cone(2, draw_real(0.3, 3), static_cast<int>(draw(4, 30)));
    }
    Orientation turn;
    turn.up = Direction{draw_real(-1, 1), draw_real(-1, 1), draw_real(-1, 1)};
    if (draw(0, 1) == 1) orient(model, turn);
    const HeightIndex index(model);
    const std::vector<PlacedLayer> layers = layers_of({model}, limits);
    RC_ASSERT(!layers.empty());
    for (const PlacedLayer& layer : layers) {
      RC_ASSERT(layer.thickness >= limits.thinnest);
      RC_ASSERT(layer.thickness <= limits.thickest);
      RC_ASSERT(layer.thickness.count() % kLayerStep.count() == 0);
      const bool bound_holds = widest_cusp_um(model, index.bounds().min_z, layer) <=
                               static_cast<double>(limits.cusp.count()) / 1e3 * (1 + 1e-9);
      RC_ASSERT(bound_holds || layer.thickness == limits.thinnest);
    }
    const double top_um = index.bounds().size_z() * 1e3;
    const auto reached = [&](const PlacedLayer& layer) {
      return static_cast<double>((layer.bottom + layer.thickness).count()) / 1e3;
    };
    // Up to the top less half the thinnest layer, which would be cut above it, or beyond by less than the
    // thinnest layer, and not before the last.
    RC_ASSERT(reached(layers.back()) >= top_um - 0.5 - static_cast<double>(thinnest) / 2);
    RC_ASSERT(in_mm(layers.back().bottom + layers.back().thickness / 2) < index.bounds().size_z());
    RC_ASSERT(reached(layers.back()) < top_um + static_cast<double>(thinnest) + 0.5);
    if (layers.size() > 1) RC_ASSERT(reached(layers[layers.size() - 2]) < top_um - 0.5);
  }));
}

TEST_CASE("Of several models the most demanding one decides, up to its top") {
  const models::Facets box = models::box({0, 0, 0}, {5, 5, 6}), sphere = models::globe(1, 40, 32);
  const std::vector<PlacedLayer> together = layers_of({box, sphere}), alone = layers_of({sphere});
  REQUIRE(together.size() > alone.size());
  for (std::size_t i = 0; i + 1 < alone.size(); ++i)
    CHECK(together[i].thickness == alone[i].thickness);
  CHECK(together[together.size() - 3].thickness == um(100));
  CHECK(together.back().bottom + together.back().thickness == um(6'000));
}

TEST_CASE("Limits that are not whole micrometres are rounded inwards") {
  const std::vector<PlacedLayer> walls =
      layers_of({models::box({0, 0, 0}, {5, 5, 2})}, {Nanometers{20'500}, Nanometers{60'900}, um(15)});
  CHECK(walls.front().thickness == um(60));
  const std::vector<PlacedLayer> slope =
      layers_of({models::cone(9, 1, 40)}, {Nanometers{20'500}, Nanometers{60'900}, um(5)});
  CHECK(slope.front().thickness == um(21));
}

TEST_CASE("Uniform layers have the thickness and count of the stack") {
  const PrintLayers layers(LayerStack{um(50), 3});
  CHECK(layers.all() == std::vector(3, um(50)));
  CHECK(layers.thickness_at(um(100)) == um(50));
  CHECK_FALSE(layers.thickness_at(um(150)));
  CHECK(PrintLayers().all().empty());
  CHECK(PrintLayers(LayerStack{um(50), 0}).all().empty());
}

TEST_CASE("Adaptive layers of a model of any height are counted up to the most a print can have", "[long]") {
  const auto tower = [](float height_mm) {
    return std::vector{
        StandingModel{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {5, 5, height_mm}))}};
  };
  constexpr AdaptiveLayers kThin{um(1), um(1), um(1)};
  // Refused before any layer is counted, and as soon as there is one too many.
  CHECK_THROWS_AS((void)PrintLayers(tower(3e38F), kLimits).all(), TooManyLayers);
  CHECK_THROWS_AS((void)PrintLayers(tower(10'001), kThin).all(), TooManyLayers);
  // A single layer of such a model is still found.
  CHECK(next_thickness(tower(3e38F).front(), Nanometers{}, kLimits) == um(100));
}
