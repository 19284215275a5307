// Models with holes cut out of them, through the engine.

#include "core/engine/contour_engine.hpp"
#include "core/support/support_structure.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

std::shared_ptr<const SectionSource> structure(std::vector<SupportPrimitive> primitives) {
  return std::make_shared<const SupportStructure>(std::move(primitives));
}

// Returns a hole along z, in the model's own millimetres.
SupportPrimitive upright(double x, double y, double low, double high, double radius_mm) {
  return Frustum{{x, y, low}, {x, y, high}, radius_mm, radius_mm};
}

PlateModel block(std::vector<Point> centers, Elevation elevation,
                 std::shared_ptr<const SectionSource> holes) {
  PlateModel model{{std::make_shared<const HeightIndex>(models::box({-3, -3, 10}, {3, 3, 14})), elevation},
                   {}};
  for (const Point& center : centers)
    model.copies.push_back(PixelMap::true_scale(kCoarseDisplay, {-center.x, -center.y}));
  model.holes = std::move(holes);
  return model;
}

}  // namespace

TEST_CASE("A hole is dark at its own heights in every copy and nowhere else") {
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    const EngineSettings settings{kCoarseDisplay, mode};
    for (const Elevation elevation : {Elevation(), Elevation(mm(5))}) {
      const Nanometers up = elevation.above_plate();
      const auto hole = structure({upright(1, 0, 11, 13, 1)});
      ContourEngine drilled({block({{-4, 0}, {4, 2}}, elevation, hole)}, settings);
      ContourEngine whole({block({{-4, 0}, {4, 2}}, elevation, nullptr)}, settings);
      // The model's z begins at 10.
      for (const Nanometers height : {Nanometers{500'000}, Nanometers{3'500'000}})
        CHECK(drilled.mask_at(up + height) == whole.mask_at(up + height));
      const Mask mask = drilled.mask_at(up + mm(2)), full = whole.mask_at(up + mm(2));
      // A circle of 10 pixels' radius, by pixel centres: within 3 % of its area.
      CHECK(static_cast<double>(full.lit_pixels() - mask.lit_pixels()) ==
            testing::Approx(2 * 314.16).margin(2 * 9.5));
      // The plate's centre is (120, 110); the holes are at (-3, 0) and (5, 2).
      CHECK(mask.row(110)[90] == 0);
      CHECK(mask.row(90)[170] == 0);
      CHECK(mask.row(110)[78] == 255);
      // The next masks are not affected.
      CHECK(drilled.mask_at(up + Nanometers{3'500'000}) == whole.mask_at(up + Nanometers{3'500'000}));
      CHECK(drilled.mask_at(up + mm(9)).lit_pixels() == 0);
      CHECK(drilled.mask_at(up + mm(2)) == mask);
    }
  }
}

TEST_CASE("A hole removes nothing from the supports beside the models") {
  const EngineSettings settings{kCoarseDisplay, AntiAliasing::On};
  const auto pillar = structure({upright(0, 0, 0, 5, 0.5)});
  ContourEngine engine({block({{0, 0}}, {}, structure({upright(0, 0, 9, 15, 2)}))}, settings, pillar);
  const Mask& mask = engine.mask_at(mm(2));
  CHECK(mask.row(110)[120] == 255);
  CHECK(mask.row(110)[130] == 0);
  CHECK(mask.row(110)[145] == 255);
}

TEST_CASE("A hole is cut at the model's own z too") {
  ContourEngine engine({block({{0, 0}}, Elevation(mm(5)), structure({upright(0, 0, 12, 15, 2)}))},
                       EngineSettings{kCoarseDisplay, AntiAliasing::On});
  CHECK(engine.mask_at_z(Millimeters{11}).row(110)[120] == 255);
  CHECK(engine.mask_at_z(Millimeters{13}).row(110)[120] == 0);
}

TEST_CASE("Holes are dark in corrected masks too") {
  EngineSettings settings{kCoarseDisplay, AntiAliasing::On};
  settings.tone = {2.2, 10};
  ContourEngine engine({block({{0, 0}}, {}, structure({upright(0, 0, 9, 15, 1)}))}, settings);
  const Mask& mask = engine.mask_at(mm(2));
  CHECK(mask.row(110)[120] == 0);
  CHECK(mask.row(110)[140] == 255);
  CHECK(engine.coverage().row(110)[120] == 0);
}
