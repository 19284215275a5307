// Tests the cured part of models whose print-through is known, by its distances from the model.
#include "core/cure/cured_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/layers/layers.hpp"
#include "core/support/supports.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Nanometers kLayer{50'000};
constexpr double kOvercureUm = 50;
constexpr WorkingCurve kCurve{Micrometers{150}, MillijoulesPerCm2{8}};

struct Printing {
  DisplayGeometry display{Pixels{300}, Pixels{200}, Micrometers{50}};
  double memory = 1;
  Compensation compensation{};
  PixelLight pixel{};
  double dead_zone_um = 0;
  double oxygen = 0;  // mJ/cm2
  double overcure_um = kOvercureUm;
  WorkingCurve curve = kCurve;
  std::vector<SupportPrimitive> supports{};
  std::vector<SupportPrimitive> holes{};  // in the model's own millimetres
};

CuredPart cured(models::Facets facets, const Printing& printing = {}) {
  auto model = std::make_shared<const HeightIndex>(std::move(facets));
  const double top = model->bounds().size_z();
  const PixelMap map = PixelMap::true_scale(printing.display, model->bounds().center());
  std::vector<PlateModel> models;
  models.push_back({{std::move(model)}, {map}});
  if (!printing.holes.empty())
    models.front().holes = std::make_shared<const SupportStructure>(printing.holes);
  Supports supports;
  if (!printing.supports.empty())
    supports.structure = std::make_shared<const SupportStructure>(printing.supports);
  ContourEngine engine(std::move(models),
                       {.display = printing.display, .compensation = printing.compensation},
                       supports.structure);
  std::vector<LayerDose> layers;
  const LayerStack stack = layers_for(Millimeters{top}, kLayer);
  for (std::int32_t layer = 0; layer < stack.count; ++layer)
    layers.push_back(
        {kLayer * (layer + 1), kLayer, printing.curve.dose_for(Micrometers{50 + printing.overcure_um})});
  return cure_part(engine, printing.display,
                   {.layers = layers,
                    .cure = {.curve = printing.curve,
                             .peel_memory = printing.memory,
                             .oxygen_dose = MillijoulesPerCm2{printing.oxygen},
                             .dead_zone = Micrometers{printing.dead_zone_um}},
                    .pixel = printing.pixel},
                   supports.structure ? &supports : nullptr);
}

// Returns a slab of a height on two pillars, whose sides lie between pixels.
models::Facets bridge(float slab_mm, float gap_mm = 3) {
  return models::together({models::box({-3, -2, 0}, {-2, 2, gap_mm}), models::box({2, -2, 0}, {3, 2, gap_mm}),
                           models::box({-3, -2, gap_mm}, {3, 2, gap_mm + slab_mm})});
}

constexpr double kRounding = 0.1;  // um: floats of some millimetres

// Two copies of a roof on a pillar, beside each other, of which one is left dark from a layer on.
class TwoRoofs {
 public:
  static constexpr float kRoof = 2;  // height of the roof's underside, in mm

  // `supports` hold the roofs.
  explicit TwoRoofs(bool supports) {
    const models::Facets facets = models::together(
        {models::box({-1, -1, 0}, {0, 1, kRoof}), models::box({-1, -1, kRoof}, {2, 1, kRoof + 1})});
    model_ = std::make_shared<const HeightIndex>(facets);
    if (!supports) return;
    std::vector<SupportPrimitive> primitives;
    for (const double x : kPlaces)
      primitives.emplace_back(pin(x));
    supports_.structure = std::make_shared<const SupportStructure>(std::move(primitives));
  }

  // Returns the part in which the first copy, or none, is left dark from a layer on.
  [[nodiscard]] CuredPart part(std::optional<std::size_t> dark_from) const {
    std::vector<DarkCopy> dark;
    if (dark_from) dark.push_back({0, 0, *dark_from, supports_.structure ? pins({kPlaces[1]}) : nullptr});
    return cured({kPlaces[0], kPlaces[1]}, supports_.structure, dark, kLayers);
  }
  // Returns the part of one copy alone, in its place, after some layers of a model that ends with them.
  [[nodiscard]] CuredPart alone(std::size_t copy, std::size_t layers) const {
    const auto top = static_cast<float>(0.05 * static_cast<double>(layers));
    models::Facets facets = models::box({-1, -1, 0}, {0, 1, std::min(top, kRoof)});
    if (top > kRoof)
      facets = models::together(facets, models::box({-1, -1, kRoof}, {2, 1, std::min(top, kRoof + 1)}));
    return cured({kPlaces[copy]},
                 supports_.structure ? pins({kPlaces[copy]}, static_cast<double>(top)) : nullptr, {}, layers,
                 std::make_shared<const HeightIndex>(facets));
  }

  static constexpr std::size_t kLayers = 60;

 private:
  static constexpr std::array kPlaces{-3.0, 2.0};  // of the copies, in mm
  static constexpr DisplayGeometry kDisplay{Pixels{300}, Pixels{200}, Micrometers{50}};

  static Frustum pin(double x, double up_to = kRoof) {
    return {{x + 1.5, 0, 0}, {x + 1.5, 0, std::min<double>(up_to, kRoof)}, 0.3, 0.3};
  }
  static std::shared_ptr<const SupportStructure> pins(const std::vector<double>& places,
                                                      double up_to = kRoof) {
    std::vector<SupportPrimitive> primitives;
    for (const double x : places)
      primitives.emplace_back(pin(x, up_to));
    return std::make_shared<const SupportStructure>(std::move(primitives));
  }

  [[nodiscard]] CuredPart cured(const std::vector<double>& places,
                                std::shared_ptr<const SupportStructure> pins, std::span<const DarkCopy> dark,
                                std::size_t count, std::shared_ptr<const HeightIndex> model = nullptr) const {
    std::vector<PlateModel> models{{{model ? std::move(model) : model_}, {}}};
    for (const double x : places)
      models.front().copies.push_back(PixelMap::true_scale(kDisplay, {-x, 0}));
    ContourEngine engine(std::move(models), {.display = kDisplay}, pins);
    std::vector<LayerDose> layers;
    for (std::size_t layer = 0; layer < count; ++layer)
      layers.push_back(
          {kLayer * static_cast<std::int64_t>(layer + 1), kLayer, kCurve.dose_for(Micrometers{100})});
    Supports supports;
    supports.structure = std::move(pins);
    return cure_part(engine, kDisplay, {.layers = layers, .cure = {.curve = kCurve}, .dark = dark},
                     supports.structure ? &supports : nullptr);
  }

  std::shared_ptr<const HeightIndex> model_;
  Supports supports_;
};

// Checks that a surface of a part is that of two other parts together.
void check_sum(const SurfaceDistances& both, const SurfaceDistances& one, const SurfaceDistances& other) {
  CHECK(both.places == one.places + other.places);
  CHECK(both.missing == one.missing + other.missing);
  const SurfaceDistances& worse = std::abs(one.worst_um) > std::abs(other.worst_um) ? one : other;
  CHECK(both.worst_um == Approx(worse.worst_um).margin(kRounding));
}

}  // namespace

TEST_CASE("Holes and cavities are no part of the model that the cured part is compared with") {
  const models::Facets block = models::box({-3, -3, 0}, {3, 3, 4});
  // An upright cylinder within the block, and a level one that leads out of it.
  Printing printing;
  printing.holes = {Frustum{{-1, 0, 1}, {-1, 0, 3}, 1, 1}, Frustum{{1.5, -1, 2}, {1.5, 5, 2}, 0.5, 0.5}};
  const CureFigures solid = cured(block).figures, drilled = cured(block, printing).figures;
  const double removed = 3.14159 * (1 * 1 * 2 + 0.5 * 0.5 * 4);
  CHECK(solid.model_mm3 - drilled.model_mm3 == testing::Approx(removed).epsilon(0.03));
  // The print-through closes some of the holes; of the model, no more stays liquid than without them, but for
  // half a pixel around them.
  CHECK(drilled.too_little_mm3 < solid.too_little_mm3 + 0.1 * removed);
  CHECK(drilled.undersides.places == solid.undersides.places);
  CHECK(drilled.tops.worst_um == solid.tops.worst_um);
}

TEST_CASE("A box cures to its size") {
  const CureFigures of = cured(models::box({0, 0, 0}, {4, 3, 1})).figures;
  CHECK(of.model_mm3 == Approx(12));
  CHECK(of.too_much_mm3 == Approx(0).margin(1e-4));
  CHECK(of.too_little_mm3 == Approx(0).margin(1e-4));
  CHECK(of.undersides.places == 0);
  CHECK(of.tops.places == 80 * 60);
  CHECK(of.tops.p95_um == Approx(0).margin(kRounding));
  CHECK(of.walls.places > 0);
  CHECK(of.walls.missing == 0);
}

TEST_CASE("The underside of a thick bridge is 239 um too low, that of a thin one less") {
  const CureFigures thick = cured(bridge(3)).figures;
  CHECK(thick.undersides.places == 80 * 80);  // the span between the pillars
  CHECK(thick.undersides.median_um == Approx(239).margin(0.6));
  CHECK(thick.undersides.p95_um == Approx(239).margin(0.6));
  CHECK(thick.undersides.worst.height_mm == Approx(3));
  CHECK(std::abs(thick.undersides.worst.plate_mm.x) < 2);
  CHECK(thick.tops.p95_um == Approx(0).margin(kRounding));
  CHECK(thick.too_much_mm3 == Approx(16 * 0.239).epsilon(0.003));
  CHECK(cured(bridge(0.1F)).figures.undersides.median_um == Approx(131).margin(0.6));
  CHECK(cured(bridge(3), {.memory = 0.9}).figures.undersides.median_um == Approx(168).margin(0.6));
}

TEST_CASE("Dose that is lost to oxygen at each peel lets a thick bridge print through less", "[long]") {
  struct Row {
    double memory, oxygen;
    std::array<double, 2> um;  // for Dp of 150 and 100 um
  };
  // Resin that is followed through all layers above it: D = max(m D - oxygen, 0) + E, solid from Ec on.
  for (const Row& row : {Row{0.9, 0.001, {167.5, 107.3}}, Row{0.9, 0.1, {161.2, 104.0}},
                         Row{0.9, 0.5, {140.6, 93.2}}, Row{0.9, 1, {120.3, 83.1}}, Row{0.9, 2, {93.3, 68.7}},
                         Row{0.9, 4, {61.2, 50.4}}, Row{1, 1, {146.9, 96.9}}}) {
    for (const double depth_um : {150.0, 100.0}) {
      const double um = row.um[depth_um == 150 ? 0 : 1];
      const Printing printing{
          .memory = row.memory, .oxygen = row.oxygen, .curve = {Micrometers{depth_um}, kCurve.critical_dose}};
      const CureFigures of = cured(bridge(3), printing).figures;
      CAPTURE(row.memory, row.oxygen, depth_um);
      CHECK(of.undersides.median_um == Approx(um).margin(0.1));  // rounded to 0.1 um
      CHECK(of.too_much_mm3 == Approx(16 * um / 1000).epsilon(0.003));
      CHECK(of.too_little_mm3 == Approx(0).margin(1e-4));
      const auto closed_mm2 = [&](double gap_um) {
        const auto floor = static_cast<float>(3 - gap_um / 1000);
        return cured(models::together(bridge(3), models::box({-2, -2, 0}, {2, 2, floor})), printing)
            .figures.closed_mm2;
      };
      const double whole_layers_um = std::floor(um / 50) * 50;
      CHECK(closed_mm2(whole_layers_um) == Approx(16));
      CHECK(closed_mm2(whole_layers_um + 50) == 0);
    }
  }
}

TEST_CASE("Light that just reaches the bottom of its layer leaves no gap between layers") {
  for (const double depth_um : {80.0, 100.0, 120.0, 150.0, 200.0}) {
    for (const double memory : {1.0, 0.9, 0.0}) {
      CAPTURE(depth_um, memory);
      const Printing printing{.memory = memory,
                              .oxygen = 1,
                              .overcure_um = 0,
                              .curve = {Micrometers{depth_um}, kCurve.critical_dose}};
      const CureFigures of = cured(models::box({0, 0, 0}, {4, 3, 1}), printing).figures;
      CHECK(of.tops.p95_um == Approx(0).margin(kRounding));
      CHECK(of.undersides.places == 0);
      // One gap of any thickness, in the row of the worst top.
      CHECK(of.section.cured.size() == of.section.model.size());
    }
  }
}

TEST_CASE("Mirrors change no distance, and places stay where they are on the plate") {
  const models::Facets lopsided = models::together(bridge(1), models::box({-3, 2.5F, 0}, {3, 3, 4.5F}));
  const CureFigures plain = cured(lopsided).figures;
  const CureFigures turned =
      cured(lopsided, {.display = {Pixels{300}, Pixels{200}, Micrometers{50}, true, true}}).figures;
  CHECK(turned.undersides.places == plain.undersides.places);
  CHECK(turned.undersides.median_um == Approx(plain.undersides.median_um));
  CHECK(turned.walls.places == plain.walls.places);
  CHECK(turned.walls.p95_um == Approx(plain.walls.p95_um).margin(kRounding));
  CHECK(turned.too_much_mm3 == Approx(plain.too_much_mm3).epsilon(1e-6));
}

TEST_CASE("A gap lower than the print-through is closed, with its place") {
  const CureFigures low = cured(models::together(bridge(3), models::box({-2, -2, 0}, {2, 2, 2.85F}))).figures;
  CHECK(low.closed_mm2 == Approx(16));
  CHECK(low.tallest_closed_mm == Approx(0.15).margin(1e-4));
  CHECK(low.closed.height_mm == Approx(2.85));
  CHECK(low.tops.places == 120 * 80);  // the slab's; none in the closed gap
  CHECK(low.tops.p95_um == Approx(0).margin(kRounding));
  const CureFigures high = cured(models::together(bridge(3), models::box({-2, -2, 0}, {2, 2, 2.7F}))).figures;
  CHECK(high.closed_mm2 == 0);
}

TEST_CASE("Gaps beside a support are no channels of the model, others are") {
  // A roof 2 mm above a floor, held by a thick column, in which a channel of 0.15 mm is closed.
  const models::Facets floor = models::box({-3, -2, 0}, {3, 2, 1}),
                       roof = models::box({-3, -2, 3}, {3, 2, 6});
  const Frustum column{{0, 0, 1}, {0, 0, 3}, 1.3, 1.3};
  const CureFigures open = cured(models::together(floor, roof), {.supports = {column}}).figures;
  CHECK(open.closed_mm2 == 0);
  CHECK(open.tallest_closed_mm == 0);
  // Two columns with a gap of one pixel between them, each on a foot.
  const std::vector<SupportPrimitive> narrow{Frustum{{0, 0, 1}, {0, 0, 2}, 0.5, 0.5},
                                             Frustum{{0, 0, 2.1}, {0, 0, 3}, 0.5, 0.5}};
  CHECK(cured(models::together(floor, roof), {.supports = narrow}).figures.closed_mm2 == 0);
  const models::Facets low = models::box({1.6F, -2, 1}, {3, 2, 2.85F});
  const CureFigures closed = cured(models::together({floor, low, roof}), {.supports = {column}}).figures;
  CHECK(closed.closed_mm2 == Approx(1.4 * 4));
  CHECK(closed.tallest_closed_mm == Approx(0.15).margin(1e-4));
}

TEST_CASE("Walls that are moved outwards by the compensation are found there") {
  const CureFigures grown =
      cured(models::box({0, 0, 0}, {4, 3, 1}), {.compensation = {.growth = Micrometers{50}}}).figures;
  CHECK(grown.walls.median_um == Approx(50).margin(kRounding));
  CHECK(grown.too_much_mm3 == Approx(4.1 * 3.1 - 12).epsilon(0.01));
  const CureFigures shrunk =
      cured(models::box({0, 0, 0}, {4, 3, 1}), {.compensation = {.growth = Micrometers{-100}}}).figures;
  CHECK(shrunk.walls.median_um == Approx(-100).margin(kRounding));
  CHECK(shrunk.too_little_mm3 == Approx(12 - 3.8 * 2.8).epsilon(0.01));
}

TEST_CASE("A part of the model that no mask lights is missing") {
  // A roof of 20 um between two cutting heights.
  const CureFigures of =
      cured(models::together(models::box({0, 0, 0}, {1, 3, 2}), models::box({1, 0, 1.03F}, {3, 3, 1.05F})))
          .figures;
  CHECK(of.undersides.missing == 40 * 60);
  CHECK(of.too_little_mm3 == Approx(2 * 3 * 0.02).epsilon(0.01));
}

TEST_CASE("A dead zone makes all tops lower by its thickness") {
  const CureFigures of = cured(bridge(3), {.dead_zone_um = 12}).figures;
  CHECK(of.tops.median_um == Approx(-12).margin(kRounding));
  // Light that reaches the solid is less by 1 - exp(-12/150), and the film is 12 um further away.
  CHECK(of.undersides.median_um == Approx(239 - 12 + 12).margin(0.6));
}

TEST_CASE("A dead zone higher than a layer leaves no solid below the plate") {
  // The lowest layer would have its solid below the plate. The topmost one, which no later light reaches, is
  // solid over 150 ln(exp(100 / 150) exp(-60 / 150)) = 40 um, and has 10 um of liquid beneath.
  const CureFigures of = cured(bridge(3), {.dead_zone_um = 60}).figures;
  CHECK(of.tops.median_um == Approx(-60).margin(kRounding));
  CHECK(of.too_little_mm3 == Approx(6 * 4 * (0.06 + 0.01)).epsilon(0.001));
  CHECK(of.too_much_mm3 == Approx(4 * 4 * of.undersides.median_um / 1000).epsilon(0.001));  // below the slab
  // No part of a single layer solidifies above the plate.
  const CureFigures thin = cured(models::box({0, 0, 0}, {4, 3, 0.05F}), {.dead_zone_um = 60}).figures;
  CHECK(thin.too_little_mm3 == Approx(4 * 3 * 0.05));
  CHECK(thin.too_much_mm3 == 0);
}

TEST_CASE("Walls bulge where spread light of all layers adds up, as far as the Gaussian says") {
  const CureFigures of = cured(bridge(3), {.pixel = {{{0.5, 1}}}}).figures;
  // The middle of a layer is solid from exp(25/150) Ec on. All layers together give its top up to E0 / (1 -
  // q).
  const double share = std::exp(25.0 / 150) * (1 - std::exp(-50.0 / 150)) / std::exp(100.0 / 150);
  // The light of a lit area, beside its edge.
  const auto light = [](double x) { return std::erfc(x / (0.5 * std::sqrt(2))) / 2; };
  double inside = 0, outside = 1;
  for (int halving = 0; halving < 30; ++halving)
    (light((inside + outside) / 2) > share ? inside : outside) = (inside + outside) / 2;
  CHECK(of.walls.p95_um == Approx(inside * 50).margin(0.5));  // a hundredth of a pixel
  CHECK(of.tops.median_um == Approx(0).margin(kRounding));
  CHECK(of.undersides.median_um == Approx(239).margin(0.6));
}

TEST_CASE("The weakest bond is the dose at the lower side of the layer with the least light") {
  const CuredPart part = cured(models::box({0, 0, 0}, {4, 3, 1}));
  CHECK(part.weakest_bond == Approx(std::exp(kOvercureUm / 150)));
  CHECK(part.weakest_bond_layer == 1);
  CHECK(part.abandoned_layers == 0);
}

TEST_CASE("Pixels that the light of their neighbours lacks bond with less") {
  // A pin of two by two pixels; the light of a pixel reaches its neighbours.
  const CuredPart part = cured(models::box({0, 0, 0}, {0.1F, 0.1F, 1}), {.pixel = {{{0.5, 1}}}});
  // Along a row, and as much along a column: of its own square and of its neighbour's.
  const double share = (std::erf(1 / std::sqrt(2)) + std::erf(3 / std::sqrt(2))) / 2;
  CHECK(part.weakest_bond == Approx(share * share * std::exp(kOvercureUm / 150)).epsilon(1e-4));
}

TEST_CASE("The underside of a ball is too low by the print-through of the layers above it") {
  const CureFigures of = cured(models::globe(2, 64, 96)).figures;
  CHECK(of.model_mm3 == Approx(4.0 / 3 * 3.14159 * 8).epsilon(0.01));
  CHECK(of.undersides.median_um > 150);
  CHECK(of.undersides.worst_um < 240);
  CHECK(of.undersides.missing == 0);
  CHECK(of.tops.median_um < 25);  // half a layer: stairs
}

TEST_CASE("A copy that was left dark is compared as far up as it was printed, the others in full") {
  for (const bool supports : {false, true}) {
    const TwoRoofs roofs(supports);
    // Layers of the pillar, and of the roof: the fewer layers lie above an underside, the less it
    // prints through.
    for (const std::size_t dark_from : {20U, 40U, 41U, 43U, 50U}) {
      CAPTURE(supports, dark_from);
      const CuredPart part = roofs.part(dark_from);
      const CureFigures &both = part.figures, cut = roofs.alone(0, dark_from).figures,
                        kept = roofs.alone(1, TwoRoofs::kLayers).figures;
      CHECK(both.model_mm3 == Approx(cut.model_mm3 + kept.model_mm3).epsilon(1e-6));
      CHECK(both.too_much_mm3 == Approx(cut.too_much_mm3 + kept.too_much_mm3).margin(1e-4));
      CHECK(both.too_little_mm3 == Approx(cut.too_little_mm3 + kept.too_little_mm3).margin(1e-4));
      check_sum(both.undersides, cut.undersides, kept.undersides);
      check_sum(both.walls, cut.walls, kept.walls);
      CHECK(both.tops.places == kept.tops.places);  // the cut end is no surface of the model
      CHECK(both.tops.missing == kept.tops.missing);
      CHECK(both.closed_mm2 == 0);
      REQUIRE(part.cut_copies.size() == 1);
      CHECK(part.cut_copies.front().number == 0);
      CHECK(part.cut_copies.front().up_to_mm == Approx(0.05 * static_cast<double>(dark_from)));
    }
  }
}

TEST_CASE("Walls of a copy that was left dark are measured up to its last layer") {
  const TwoRoofs roofs(false);
  const std::uint64_t whole = roofs.part({}).figures.walls.places, none = roofs.part(0).figures.walls.places;
  CHECK(whole == 2 * none);
  std::uint64_t before = none;
  for (const std::size_t dark_from : {10U, 30U, 41U, 60U}) {
    CAPTURE(dark_from);
    const std::uint64_t places = roofs.part(dark_from).figures.walls.places;
    CHECK(places > before);
    before = places;
  }
  CHECK(before == whole);
}

TEST_CASE("A copy that was dark from its first layer on does not count") {
  for (const bool supports : {false, true}) {
    const TwoRoofs roofs(supports);
    const CuredPart part = roofs.part(0);
    const CureFigures &found = part.figures, kept = roofs.alone(1, TwoRoofs::kLayers).figures;
    CHECK(found.model_mm3 == Approx(kept.model_mm3));
    CHECK(found.too_much_mm3 == Approx(kept.too_much_mm3));
    CHECK(found.too_little_mm3 == Approx(kept.too_little_mm3).margin(1e-4));
    CHECK(found.undersides.places == kept.undersides.places);
    CHECK(found.undersides.missing == 0);
    CHECK(found.walls.places == kept.walls.places);
    CHECK(part.cut_copies.front().up_to_mm == 0);
  }
}

TEST_CASE("Solids of a copy that begin above its last mask do not count") {
  // The roof begins in the upper half of layer 41, whose mask does not show it.
  const auto facets =
      models::together({models::box({-1, -1, 0}, {0, 1, 2.03F}), models::box({-1, -1, 2.03F}, {2, 1, 3})});
  const auto model = std::make_shared<const HeightIndex>(facets);
  const DisplayGeometry display{Pixels{300}, Pixels{200}, Micrometers{50}};
  const std::vector<PlateModel> models{
      {{model}, {PixelMap::true_scale(display, {3, 0}), PixelMap::true_scale(display, {-2, 0})}}};
  ContourEngine engine(models, {.display = display});
  std::vector<LayerDose> layers;
  for (int layer = 0; layer < 60; ++layer)
    layers.push_back({kLayer * (layer + 1), kLayer, kCurve.dose_for(Micrometers{100})});
  const auto part = [&](std::span<const DarkCopy> dark) {
    return cure_part(engine, display, {.layers = layers, .cure = {.curve = kCurve}, .dark = dark}, nullptr)
        .figures;
  };
  const std::array<DarkCopy, 1> dark{DarkCopy{0, 0, 41}};
  const CureFigures found = part(dark), whole = part({});
  CHECK(found.undersides.missing == 0);
  CHECK(found.undersides.places == whole.undersides.places / 2);
  CHECK(found.too_little_mm3 == Approx(0).margin(1e-4));
  CHECK(whole.undersides.places == 2 * 40 * 40);  // no copy is dark any more
}

TEST_CASE("A computation that is stopped at any layer has no part") {
  auto model = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 0.5F}));
  const DisplayGeometry display{Pixels{40}, Pixels{40}, Micrometers{50}};
  std::vector<PlateModel> models;
  models.push_back({{std::move(model)}, {PixelMap::true_scale(display, {0.5, 0.5})}});
  ContourEngine engine(std::move(models), {.display = display});
  std::vector<LayerDose> layers;
  for (int layer = 0; layer < 10; ++layer)
    layers.push_back({kLayer * (layer + 1), kLayer, kCurve.dose_for(Micrometers{100})});
  int left = 0;
  const auto stopped_after = [&](int layers_asked) {
    left = layers_asked;
    PrintCure print(engine, display,
                    {.layers = layers, .cure = {.curve = kCurve}, .is_stopped = [&] { return left-- <= 0; }},
                    {});
    return !print.compare(nullptr);
  };
  for (const int asked : {0, 5, 10, 11, 15, 20})
    CHECK(stopped_after(asked));
  CHECK_FALSE(stopped_after(1000));
}

TEST_CASE("A comparison with a model ends soon after it was stopped, wherever it is") {
  const auto model = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {20, 20, 0.1F}));
  const DisplayGeometry display{Pixels{400}, Pixels{400}, Micrometers{50}};
  const std::vector<ComparedModel> models{{{{model}, {PixelMap::true_scale(display, {10, 10})}}}};
  const std::vector<LayerDose> layers{{kLayer, kLayer, {}}, {kLayer * 2, kLayer, {}}};
  int asked = 0;
  const auto compare = [&](int stopped_at) {
    asked = 0;
    CureComparison comparison(models, {}, display, {0, 0, 400, 400}, layers,
                              [&] { return ++asked == stopped_at; });
  };
  compare(0);
  const int all = asked;
  CHECK(all > 3);  // stops at the begin, on the way and at the end
  for (const int stopped_at : {1, all / 2, all}) {
    CHECK_THROWS_AS(compare(stopped_at), ComputationStopped);
    CHECK(asked == stopped_at);
  }
}
