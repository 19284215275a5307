#include "core/engine/section_source.hpp"

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

constexpr double kPixelMm2 = 0.01;

// Upright boxes on the plate, in millimetres from its centre.
struct Box {
  double left, front, right, back;
  Nanometers bottom, top;
};

class Boxes final : public SectionSource {
 public:
  explicit Boxes(std::vector<Box> boxes) : boxes_(std::move(boxes)) {}

  void section_at(Nanometers height, Contours& contours) const override {
    contours.points.clear();
    contours.loops.clear();
    for (const Box& box : boxes_) {
      if (height < box.bottom || height >= box.top) continue;
      contours.loops.push_back({static_cast<std::uint32_t>(contours.points.size()), 4});
      for (const Point corner : {Point{box.left, box.front}, Point{box.right, box.front},
                                 Point{box.right, box.back}, Point{box.left, box.back}})
        contours.points.push_back(corner);
    }
  }

 private:
  std::vector<Box> boxes_;
};

ContourEngine boxed_engine(std::vector<PlateModel> models, std::vector<Box> boxes,
                           EngineSettings settings = {}) {
  if (settings.display.width == Pixels{1920}) settings.display = kCoarseDisplay;
  return {std::move(models), settings, std::make_shared<const Boxes>(std::move(boxes))};
}

EngineSettings with(AntiAliasing anti_aliasing, Micrometers growth = {}) {
  EngineSettings settings{kCoarseDisplay, anti_aliasing};
  settings.compensation.growth = growth;
  return settings;
}

double area_mm2(const Mask& mask) {
  return mask.lit_area() * kPixelMm2;
}

}  // namespace

TEST_CASE("A source's sections are exposed at their place and heights") {
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine engine = boxed_engine({}, {{-3, 1, -1, 4, mm(1), mm(3)}}, with(mode));
    CHECK(engine.mask_at(Nanometers{999'999}).lit_pixels() == 0);
    const Mask mask = engine.mask_at(mm(1));
    CHECK(mask.lit_pixels() == 20 * 30);
    // 240 x 220 pixels of 0.1 mm: the plate's centre is (120, 110), and the back of the plate is at the top.
    CHECK(mask.row(70)[90] == 255);
    CHECK(mask.row(99)[109] == 255);
    CHECK(mask.row(69)[90] == 0);
    CHECK(mask.row(70)[89] == 0);
    CHECK(engine.mask_at(mm(3)).lit_pixels() == 0);
  }
}

TEST_CASE("A mirrored display mirrors a source's sections like the models") {
  DisplayGeometry mirrored = kCoarseDisplay;
  mirrored.mirror_x = true;
  const Box box{1, 1, 3, 4, mm(0), mm(5)};
  for (const DisplayGeometry& display : {kCoarseDisplay, mirrored}) {
    ContourEngine beside = boxed_engine({}, {box}, {display, AntiAliasing::On});
    ContourEngine model({plate_model(models::box({1, 1, 0}, {3, 4, 5}), {}, display)},
                        {display, AntiAliasing::On});
    CHECK(beside.mask_at(mm(1)) == model.mask_at(mm(1)));
  }
}

TEST_CASE("A pixel has the greater value of the models' and of the source's, which is never grey") {
  // The two share a wall within a pixel, overlap, or one contains the other; edges are not at whole pixels.
  const models::Facets model = models::box({-2, -2, 0}, {2.03F, 2, 5});
  for (const Box& box :
       {Box{2.03, -2, 4.07, 2, mm(0), mm(5)}, Box{1.01, -3.02, 4.07, 1.06, mm(0), mm(5)},
        Box{-1.04, -1, 1.02, 1.06, mm(0), mm(5)}, Box{-4.04, -4, 4.02, 4.06, mm(0), mm(5)}}) {
    ContourEngine both = boxed_engine({plate_model(model)}, {box});
    ContourEngine alone = boxed_engine({plate_model(model)}, {});
    ContourEngine beside = boxed_engine({}, {box}, with(AntiAliasing::Off));
    const Mask joined = both.mask_at(mm(1)), one = alone.mask_at(mm(1)), other = beside.mask_at(mm(1));
    CHECK(one.lit_area() != static_cast<double>(one.lit_pixels()));
    CHECK(other.lit_pixels() > 0);
    for (std::size_t i = 0; i < joined.pixels().size(); ++i) {
      if (joined.pixels()[i] != std::max(one.pixels()[i], other.pixels()[i])) FAIL("pixel " << i);
    }
    CHECK(both.coverage() == joined);
  }
}

TEST_CASE("Without anti-aliasing the mask is the union of both pictures") {
  const models::Facets model = models::sphere(4, 16);
  const Box box{1.01, -3.02, 7.07, 1.05, mm(0), mm(9)};
  ContourEngine both = boxed_engine({plate_model(model)}, {box}, with(AntiAliasing::Off));
  ContourEngine alone = boxed_engine({plate_model(model)}, {}, with(AntiAliasing::Off));
  ContourEngine beside = boxed_engine({}, {box}, with(AntiAliasing::Off));
  for (Nanometers height = mm(0); height < mm(10); height += Nanometers{700'000}) {
    const Mask united = both.mask_at(height), one = alone.mask_at(height), other = beside.mask_at(height);
    for (std::size_t i = 0; i < united.pixels().size(); ++i) {
      if (united.pixels()[i] != std::max(one.pixels()[i], other.pixels()[i])) FAIL("pixel " << i);
    }
  }
}

TEST_CASE("A source that does not touch the models does not change their pixels") {
  const models::Facets model =
      models::together(models::gyroid_sphere(4, 5, 24), models::box({-4, -4, -4}, {1, 1, 2}));
  const Box box{6.03, -3, 8.01, 4, mm(0), mm(9)};
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine both = boxed_engine({plate_model(model)}, {box}, with(mode));
    ContourEngine alone = boxed_engine({plate_model(model)}, {}, with(mode));
    ContourEngine beside = boxed_engine({}, {box}, with(AntiAliasing::Off));
    for (Nanometers height = mm(0); height < mm(8); height += Nanometers{700'000}) {
      const Mask united = both.mask_at(height), one = alone.mask_at(height), other = beside.mask_at(height);
      for (std::size_t i = 0; i < united.pixels().size(); ++i) {
        if (united.pixels()[i] != one.pixels()[i] + other.pixels()[i]) FAIL("pixel " << i);
      }
    }
  }
}

TEST_CASE("Compensation moves the models but not a source's sections") {
  for (const Micrometers growth : {Micrometers{200}, Micrometers{-200}}) {
    ContourEngine engine = boxed_engine({plate_model(models::box({-4, -4, 0}, {0, 0, 5}))},
                                        {{2, 2, 5, 5, mm(0), mm(5)}}, with(AntiAliasing::On, growth));
    ContourEngine alone =
        boxed_engine({plate_model(models::box({-4, -4, 0}, {0, 0, 5}))}, {}, with(AntiAliasing::On, growth));
    const double model_mm2 = area_mm2(alone.mask_at(mm(1)));
    CHECK(std::fabs(model_mm2 - 16) > 2);
    CHECK(area_mm2(engine.mask_at(mm(1))) - model_mm2 == contourd::testing::Approx(9.0).epsilon(1e-9));
  }
}

TEST_CASE("A source's sections are as white as the models, without faint pixels") {
  EngineSettings settings{kCoarseDisplay};
  settings.tone = {2.2, 255};
  settings.uniformity = Mask(kCoarseDisplay.width, kCoarseDisplay.height);
  for (std::int32_t y = 0; y < kCoarseDisplay.height.count(); ++y)
    std::ranges::fill(settings.uniformity->row(y), static_cast<std::uint8_t>(255 - y / 2));
  const Box box{1.02, -8.03, 9.04, 8.04, mm(0), mm(5)};
  ContourEngine engine = boxed_engine({plate_model(models::box({-9, -8, 0}, {-1, 8, 5}))}, {box}, settings);
  const Mask& mask = engine.mask_at(mm(1));
  for (std::int32_t y = 35; y < 185; ++y) {
    // A pixel inside the model, and the first and the last pixel of the source's section.
    const std::span<const std::uint8_t> row = mask.row(y);
    CHECK(row[60] > 0);
    CHECK(row[60] < 255);
    CHECK(row[130] == row[60]);
    CHECK(row[209] == row[60]);
    CHECK(row[210] == 0);
    CHECK(engine.coverage().row(y)[209] == 255);
  }
}

TEST_CASE("A source's section is gone in the next mask") {
  const models::Facets model = models::gyroid_sphere(4, 5, 24);
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine engine = boxed_engine(
        {plate_model(model)}, {{-9, -9, 9, -3, mm(1), mm(2)}, {-2, -2, 2, 2, mm(2), mm(3)}}, with(mode));
    ContourEngine alone = boxed_engine({plate_model(model)}, {}, with(mode));
    for (const Nanometers height : {mm(1), mm(2), mm(3), mm(1), mm(0), mm(2), mm(5)}) {
      const bool same = engine.mask_at(height) == alone.mask_at(height);
      CHECK(same == (height < mm(1) || height >= mm(3)));
    }
  }
}

TEST_CASE("Loops, gaps and facets are reported for the models alone") {
  models::Facets cracked = models::box({-4, -4, 0}, {4, 4, 5});
  cracked.erase(cracked.begin() + 5);
  ContourEngine both = boxed_engine({plate_model(cracked)}, {{-5, -1, 5, 1, mm(0), mm(5)}});
  ContourEngine alone = boxed_engine({plate_model(cracked)}, {});
  (void)both.mask_at(mm(1));
  (void)alone.mask_at(mm(1));
  CHECK(both.cracks() == alone.cracks());
  CHECK(both.intersecting_facets() == alone.intersecting_facets());
  CHECK(both.count_loops() == alone.count_loops());
  CHECK(both.contours_at(mm(1)).loops.size() == alone.contours_at(mm(1)).loops.size());
}

TEST_CASE("A model above the plate meets the supports that stand on the plate") {
  ContourEngine engine = boxed_engine({plate_model(models::box({-4, -4, 0}, {4, 4, 5}), Elevation(mm(5)))},
                                      {{-1, -1, 1, 1, mm(0), Nanometers{5'200'000}}});
  CHECK(engine.mask_at(mm(1)).lit_pixels() == 20 * 20);
  CHECK(engine.mask_at(Nanometers{5'100'000}).lit_pixels() == 80 * 80);
  CHECK(engine.mask_at(mm(6)).lit_pixels() == 80 * 80);
  // Cut at the model's own z.
  CHECK(engine.mask_at_z(Millimeters{-4}).lit_pixels() == 20 * 20);
}

TEST_CASE("A budget overrun by a source's sections leaves the engine usable") {
  std::vector<Box> boxes(4000, Box{-5, -5, 5, 5, mm(0), mm(5)});
  ContourEngine engine = boxed_engine({plate_model(models::box({-4, -4, 0}, {4, 4, 5}))}, std::move(boxes));
  MaskBudget small(std::nullopt, 1000);
  CHECK(engine.mask_within(mm(1), small) == nullptr);
  CHECK(small.overrun());
  CHECK(engine.mask_at(mm(1)).lit_pixels() == 100 * 100);
}
