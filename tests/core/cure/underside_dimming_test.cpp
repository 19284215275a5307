// Tests prints with dimmed undersides: the cured part's distance from the model, and which pixels keep their
// light.
#include "core/cure/underside_dimming.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Nanometers kHeight{50'000};
constexpr WorkingCurve kResin{Micrometers{150}, MillijoulesPerCm2{8}};
constexpr std::chrono::seconds kBudget{60};
const DisplayGeometry kScreen{Pixels{300}, Pixels{200}, Micrometers{50}};

// Counts the cuts, and has more sides than any budget allows in one layer; elsewhere none.
class CostlySections : public SectionSource {
 public:
  explicit CostlySections(std::int32_t layer) : layer_(layer) {}

  void section_at(Nanometers height, Contours& contours) const override {
    ++cuts_;
    contours = Contours{};
    if (height / kHeight == layer_) contours.points.resize(MaskBudget::kMaxSides + 1);
  }
  [[nodiscard]] int cuts() const { return cuts_; }

 private:
  std::int32_t layer_;
  mutable int cuts_ = 0;
};

// Changes of the model's masks; null: none.
struct Changes {
  std::shared_ptr<const SectionSource> holes{}, supports{};
  Compensation compensation{};
  Micrometers cure_depth{100};  // of each layer's light
};

// A model on the plate whose undersides are dimmed.
class DimmedPrint {
 public:
  explicit DimmedPrint(models::Facets facets, double memory = 1, const WorkingCurve& resin = kResin,
                       Changes changes = {}) {
    settings_.compensation = changes.compensation;
    auto model = std::make_shared<const HeightIndex>(std::move(facets));
    const LayerStack stack = layers_for(Millimeters{model->bounds().size_z()}, kHeight);
    for (std::int32_t layer = 0; layer < stack.count; ++layer)
      cure_.layers.push_back({kHeight * (layer + 1), kHeight, resin.dose_for(changes.cure_depth)});
    cure_.resin = {.curve = resin, .peel_memory = memory};
    cure_.mask_budget = kBudget;
    const PixelMap map = PixelMap::true_scale(settings_.display, model->bounds().center());
    std::vector<PlateModel> models;
    models.push_back({{std::move(model)}, {map}, std::move(changes.holes)});
    engine_.emplace(std::move(models), settings_);
    undersides_.emplace(engine_->models(), std::move(changes.supports), settings_, cure_);
  }

  UndersideDimming& undersides() { return *undersides_; }
  [[nodiscard]] std::size_t layers() const { return cure_.layers.size(); }

  CuredPart part() {
    return cure_part(*engine_, settings_.display,
                     {.layers = cure_.layers, .cure = cure_.resin, .undersides = &*undersides_}, nullptr);
  }
  CureFigures figures() { return part().figures; }
  CureFigures plain_figures() {
    return cure_part(*engine_, settings_.display, {.layers = cure_.layers, .cure = cure_.resin}, nullptr)
        .figures;
  }
  Mask light(std::size_t layer) {
    Mask light = engine_->mask_at(cure_.layers[layer].top - kHeight / 2);
    dim(undersides_->dimmed(layer), light);
    return light;
  }

 private:
  EngineSettings settings_{.display = kScreen};
  UndersideCure cure_;
  std::optional<ContourEngine> engine_;
  std::optional<UndersideDimming> undersides_;
};

// Returns a slab on two pillars, 3 mm high, with the slab's underside at a height.
models::Facets table(float slab_mm, float underside_mm = 3) {
  return models::together({models::box({-3, -2, 0}, {-2, 2, underside_mm}),
                           models::box({2, -2, 0}, {3, 2, underside_mm}),
                           models::box({-3, -2, underside_mm}, {3, 2, underside_mm + slab_mm})});
}

// Returns a square bar on the plate, 2 mm high, whose upper end is moved by a distance.
models::Facets leaning_bar(float side_mm, float lean_mm) {
  models::Facets bar = models::box({0, 0, 0}, {side_mm, side_mm, 2});
  for (Facet& facet : bar)
    for (Vertex& vertex : facet.vertices)
      vertex.x += lean_mm * vertex.z / 2;
  return bar;
}

// Returns the number of parts of a layer's light that lie on no light of the layer beneath.
int unheld_parts(const Mask& light, const Mask& beneath) {
  const std::int32_t width = light.width().count(), height = light.height().count();
  std::vector<bool> seen(static_cast<std::size_t>(width * height));
  int unheld = 0;
  for (std::int32_t start = 0; start < width * height; ++start) {
    std::vector<std::int32_t> open{start};
    bool is_held = false, is_lit = false;
    while (!open.empty()) {
      const std::int32_t at = open.back();
      open.pop_back();
      const std::int32_t x = at % width, y = at / width;
      if (seen[static_cast<std::size_t>(at)] || light.row(y)[static_cast<std::size_t>(x)] == 0) continue;
      seen[static_cast<std::size_t>(at)] = true;
      is_lit = true;
      is_held = is_held || beneath.row(y)[static_cast<std::size_t>(x)] > 0;
      if (x > 0) open.push_back(at - 1);
      if (x + 1 < width) open.push_back(at + 1);
      if (y > 0) open.push_back(at - width);
      if (y + 1 < height) open.push_back(at + width);
    }
    unheld += is_lit && !is_held ? 1 : 0;
  }
  return unheld;
}

// Grey values of 255ths move an underside by at most this.
constexpr double kGreyStep = 2.5;  // um

}  // namespace

TEST_CASE("The underside of a bridge cures at its drawn height, with any memory") {
  for (const double memory : {1.0, 0.95, 0.9, 0.75, 0.5}) {
    CAPTURE(memory);
    DimmedPrint print(table(3), memory);
    const CureFigures figures = print.figures();
    CHECK(print.plain_figures().undersides.median_um > 75);
    CHECK(figures.undersides.missing == 0);
    CHECK(figures.undersides.median_um == Approx(0).margin(kGreyStep));
    CHECK(figures.undersides.p95_um < kGreyStep);
    CHECK(figures.tops.p95_um < 0.1);
    CHECK(figures.too_little_mm3 < 0.001 * figures.model_mm3);
  }
}

TEST_CASE("An underside within a layer cures there, not at the layer's bottom") {
  for (const float height : {3.004F, 3.01F, 3.02F, 3.031F, 3.046F}) {
    CAPTURE(height);
    const CureFigures figures = DimmedPrint(table(3, height)).figures();
    CHECK(figures.undersides.median_um == Approx(0).margin(kGreyStep));
    CHECK(figures.undersides.p95_um < kGreyStep);
  }
}

TEST_CASE("The lowest layers of a dimmed underside bond by the light that passes through them") {
  // Full light bonds with exp(50 / 150); Ec is reached at the underside, 30 um below the first layer's top.
  DimmedPrint print(table(3, 3.02F));
  const CuredPart part = print.part();
  CHECK(part.weakest_bond == Approx(std::exp(30.0 / 150)).epsilon(kGreyStep / 150));
  CHECK(part.weakest_bond_layer == 61);
}

TEST_CASE("A roof of eight layers cures at its drawn height, and a thinner one is never thinner than drawn") {
  CHECK(DimmedPrint(table(0.4F)).figures().undersides.p95_um < kGreyStep);
  for (const float slab : {0.05F, 0.1F, 0.15F, 0.2F, 0.3F}) {
    CAPTURE(slab);
    DimmedPrint print(table(slab));
    const CureFigures figures = print.figures();
    CHECK(figures.undersides.missing == 0);
    CHECK(figures.undersides.median_um > -kGreyStep);
    CHECK(figures.undersides.median_um <= print.plain_figures().undersides.median_um);
  }
}

TEST_CASE("Slopes and round undersides cure where they are drawn") {
  for (const double memory : {1.0, 0.75}) {
    CAPTURE(memory);
    DimmedPrint ball(models::globe(3, 60, 120), memory);
    const SurfaceDistances undersides = ball.figures().undersides;
    CHECK(undersides.p95_um < 15);  // what is asked for
    CHECK(ball.plain_figures().undersides.p95_um > 80);
  }
}

TEST_CASE("What stands on the plate, and what is less than three pixels wide, keeps all its light") {
  DimmedPrint on_plate(models::box({0, 0, 0}, {4, 3, 2}));
  for (std::size_t layer = 0; layer < on_plate.layers(); ++layer)
    CHECK(on_plate.undersides().dimmed(layer).empty());
  // A rail of two pixels' width from one pillar to another.
  DimmedPrint rail(models::together({models::box({-3, -1, 0}, {-2, 1, 2}), models::box({2, -1, 0}, {3, 1, 2}),
                                     models::box({-2.5F, -0.05F, 1}, {2.5F, 0.05F, 2})}));
  for (std::size_t layer = 0; layer < rail.layers(); ++layer)
    CHECK(rail.undersides().dimmed(layer).empty());
}

TEST_CASE("Dimming leaves no part of a layer without hold", "[long]") {
  for (const float lean_mm : {0.5F, 1.0F, 2.0F, 4.0F, 5.0F}) {
    for (const float thick_mm : {0.15F, 0.2F, 0.3F, 0.4F, 0.6F}) {
      // Strong light, by which nearly all layers above an underside would be dimmed.
      for (const double depth_um : {100, 200, 450}) {
        CAPTURE(lean_mm, thick_mm, depth_um);
        DimmedPrint print(leaning_bar(thick_mm, lean_mm), 1, kResin, {.cure_depth = Micrometers{depth_um}});
        Mask beneath = print.light(0);
        int unheld = 0;
        for (std::size_t layer = 1; layer < print.layers(); ++layer) {
          const Mask light = print.light(layer);
          unheld += unheld_parts(light, beneath);
          beneath = light;
        }
        CHECK(unheld == 0);
      }
    }
  }
}

TEST_CASE("The rim of an underside is not lit before the underside beside it") {
  for (const float beyond_mm : {0.006F, 0.012F, 0.02F, 0.03F, 0.045F}) {
    for (const float underside_mm : {3.0F, 3.02F, 3.04F}) {
      CAPTURE(beyond_mm, underside_mm);
      const float side = 2 + beyond_mm;
      DimmedPrint print(
          models::together({models::box({-1, -1, 0}, {1, 1, underside_mm}),
                            models::box({-side, -side, underside_mm}, {side, side, underside_mm + 2})}));
      Mask beneath = print.light(58);
      for (std::size_t layer = 59; layer < 70; ++layer) {
        const Mask light = print.light(layer);
        CAPTURE(layer);
        CHECK(unheld_parts(light, beneath) == 0);
        beneath = light;
      }
    }
  }
}

TEST_CASE("After one of two copies is excluded, the other's light is that of a print of its own") {
  const auto model = std::make_shared<const HeightIndex>(table(1, 2));
  const EngineSettings settings{.display = kScreen};
  const PixelMap left = PixelMap::true_scale(kScreen, {3.5, 0}),
                 right = PixelMap::true_scale(kScreen, {-3.5, 0});
  UndersideCure cure{.layers = {}, .resin = {.curve = kResin}, .mask_budget = kBudget};
  for (int layer = 0; layer < 60; ++layer)
    cure.layers.push_back({kHeight * (layer + 1), kHeight, kResin.dose_for(Micrometers{100})});
  const std::vector<PlateModel> two{{{model}, {left, right}}}, one{{{model}, {right}}};
  UndersideDimming both(two, nullptr, settings, cure), alone(one, nullptr, settings, cure);
  ContourEngine engine_of_two(two, settings), engine_of_one(one, settings);
  const auto light_of = [&](ContourEngine& engine, UndersideDimming& undersides, std::size_t layer) {
    Mask light = engine.mask_at(cure.layers[layer].top - kHeight / 2);
    dim(undersides.dimmed(layer), light);
    return light;
  };
  constexpr std::size_t kExcluded = 41;  // among the layers of the slabs' undersides
  bool dimmed = false;
  for (std::size_t layer = 1; layer < cure.layers.size(); ++layer) {
    if (layer == kExcluded) {
      both.exclude(0, 0, nullptr, layer);
      engine_of_two.darken(0, 0, cure.layers[layer].top - kHeight);
    }
    const Mask light = light_of(engine_of_two, both, layer), other = light_of(engine_of_one, alone, layer);
    CHECK((layer < kExcluded) == (light != other));
    if (layer >= kExcluded) dimmed = dimmed || !both.dimmed(layer).empty();
    for (const DimmedPixel& each : layer < kExcluded ? std::span<const DimmedPixel>() : both.dimmed(layer))
      CHECK(each.pixel % 300 >= 150);
  }
  CHECK(dimmed);
}

TEST_CASE("Once copies are excluded, all layers have the light again with which they were printed") {
  // Roofs from layer 40 on, each on a pillar and a support, which ends with its copy.
  const auto model = std::make_shared<const HeightIndex>(
      models::together(models::box({-1, -1, 0}, {0, 1, 2}), models::box({-1, -1, 2}, {2, 1, 3})));
  const EngineSettings settings{.display = kScreen};
  const std::vector<PlateModel> three{
      {{model},
       {PixelMap::true_scale(kScreen, {4.5, 0}), PixelMap::true_scale(kScreen, {0, 0}),
        PixelMap::true_scale(kScreen, {-4.5, 0})}}};
  const auto pins = [](const std::vector<double>& places) {
    std::vector<SupportPrimitive> primitives;
    for (const double x : places)
      primitives.emplace_back(Frustum{{x + 1, 0, 0}, {x + 1, 0, 2}, 0.3, 0.3});
    return std::make_shared<const SupportStructure>(std::move(primitives));
  };
  UndersideCure cure{.layers = {}, .resin = {.curve = kResin}, .mask_budget = kBudget};
  for (int layer = 0; layer < 60; ++layer)
    cure.layers.push_back({kHeight * (layer + 1), kHeight, kResin.dose_for(Micrometers{100})});
  struct Excluded {
    std::size_t layer, copy;
    std::shared_ptr<const SectionSource> left;
  };
  const std::vector<Excluded> excluded{{42, 0, pins({0, 4.5})}, {43, 2, pins({0})}};
  const auto light_of = [](UndersideDimming& undersides, std::size_t layer) {
    const std::span<const DimmedPixel> dimmed = undersides.dimmed(layer);
    std::vector<std::pair<std::uint32_t, int>> light;
    for (const DimmedPixel& each : dimmed)
      light.emplace_back(each.pixel, each.share);
    std::ranges::sort(light);
    return light;
  };
  UndersideDimming print(three, pins({-4.5, 0, 4.5}), settings, cure),
      plain(three, pins({-4.5, 0, 4.5}), settings, cure);
  std::vector<std::vector<std::pair<std::uint32_t, int>>> printed;
  for (std::size_t layer = 0; layer < cure.layers.size(); ++layer) {
    for (const Excluded& each : excluded)
      if (each.layer == layer) print.exclude(0, each.copy, each.left, layer);
    printed.push_back(light_of(print, layer));
    const auto whole = light_of(plain, layer);
    CHECK((printed.back() == whole) == (layer < excluded.front().layer || whole.empty()));
  }
  CHECK_FALSE(printed[41].empty());
  const auto check = [&](UndersideDimming& undersides) {
    for (const std::size_t layer : {41U, 43U, 42U, 40U, 59U, 44U})
      CHECK(light_of(undersides, layer) == printed[layer]);
    for (std::size_t layer = 0; layer < printed.size(); ++layer) {
      CAPTURE(layer);
      CHECK(light_of(undersides, layer) == printed[layer]);
    }
  };
  check(print);
  plain.include_all();
  for (const Excluded& each : excluded)
    plain.exclude(0, each.copy, each.left, each.layer);
  check(plain);
  plain.include_all();
  CHECK(light_of(plain, 43) != printed[43]);
}

TEST_CASE("An underside is dimmed as far as its mask is moved outwards") {
  DimmedPrint print(table(3), 1, kResin, {.compensation = {.growth = Micrometers{500}}});
  const Mask light = print.light(60);
  CHECK(light.row(100)[150] == 0);       // in the middle of the span
  CHECK(light.row(100 - 48)[150] == 0);  // 2.4 mm beside it, of 2.5
}

TEST_CASE("A layer whose mask is not known in time keeps its light, and so does the one above") {
  constexpr std::int32_t kLate = 30;  // in the pillars
  DimmedPrint print(table(3), 1, kResin, {.holes = std::make_shared<CostlySections>(kLate)});
  for (std::size_t layer = 0; layer < print.layers(); ++layer) {
    CAPTURE(layer);
    CHECK(print.undersides().dimmed(layer).empty() == (layer < 60 || layer > 64));
    CHECK(print.undersides().are_found(layer) == (layer != kLate && layer != kLate + 1));
  }
}

TEST_CASE("A roof counts as far up as its masks are known in time") {
  constexpr std::int32_t kLate = 62;  // in the slab
  DimmedPrint print(table(3), 1, kResin, {.holes = std::make_shared<CostlySections>(kLate)});
  for (std::size_t layer = 0; layer < print.layers(); ++layer) {
    CAPTURE(layer);
    CHECK(print.undersides().dimmed(layer).empty());
    CHECK(print.undersides().are_found(layer) == (layer != kLate && layer != kLate + 1));
  }
}

TEST_CASE("A layer whose supports are not known in time keeps all its light") {
  constexpr std::int32_t kLate = 62;
  DimmedPrint print(table(3), 1, kResin, {.holes = {}, .supports = std::make_shared<CostlySections>(kLate)});
  for (std::size_t layer = 0; layer < print.layers(); ++layer) {
    CAPTURE(layer);
    CHECK(print.undersides().dimmed(layer).empty() == (layer < 60 || layer > 64 || layer == kLate));
    CHECK(print.undersides().are_found(layer) == (layer != kLate && layer != kLate + 1));
  }
}

TEST_CASE("The masks ahead of the second layer are computed once, also if the first one is asked for then") {
  const auto sections = std::make_shared<CostlySections>(-1);
  DimmedPrint print(table(3), 1, kResin, {.holes = sections});
  (void)print.undersides().dimmed(1);
  const int before = sections->cuts();
  CHECK(print.undersides().dimmed(0).empty());
  (void)print.undersides().dimmed(1);
  CHECK(sections->cuts() == before);
  (void)print.undersides().dimmed(2);
  CHECK(sections->cuts() == before + 1);
}

TEST_CASE("Layers asked for in any order have the same dimmed pixels") {
  DimmedPrint forwards(models::globe(2, 40, 80)), at_random(models::globe(2, 40, 80));
  const auto dimmed = [](DimmedPrint& print, std::size_t layer) {
    std::vector<std::pair<std::uint32_t, std::uint8_t>> pixels;
    for (const DimmedPixel& each : print.undersides().dimmed(layer))
      pixels.emplace_back(each.pixel, each.share);
    std::ranges::sort(pixels);
    return pixels;
  };
  std::vector<std::vector<std::pair<std::uint32_t, std::uint8_t>>> expected;
  for (std::size_t layer = 0; layer < forwards.layers(); ++layer)
    expected.push_back(dimmed(forwards, layer));
  for (const std::size_t layer : {40U, 3U, 3U, 60U, 61U, 20U, 79U, 0U, 1U}) {
    CAPTURE(layer);
    CHECK(dimmed(at_random, layer) == expected[layer]);
  }
}
