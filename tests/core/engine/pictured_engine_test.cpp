#include "core/engine/contour_engine.hpp"
#include "core/mask/picture_solid.hpp"
#include "tests/catch.hpp"
#include "tests/core/warm_allocations.hpp"

namespace {

constexpr Nanometers kLayer{100'000};
const DisplayGeometry kDisplay{Pixels{40}, Pixels{20}, Micrometers{50}};

// Two layers: a grey pixel, then a block of white ones.
std::shared_ptr<const PictureStack> two_pictures(Pixels width = Pixels{40}) {
  auto stack = std::make_shared<PictureStack>(width, Pixels{20}, kLayer);
  Mask first(width, Pixels{20}), second = first;
  first.row(3)[5] = 100;
  for (std::int32_t y = 8; y < 12; ++y)
    std::fill_n(second.row(y).begin() + 10, 20, std::uint8_t{255});
  stack->add(first);
  stack->add(second);
  return stack;
}

std::vector<PlateModel> pictured(const std::shared_ptr<const PictureStack>& pictures,
                                 const DisplayGeometry& display = kDisplay) {
  PlateModel model{{std::make_shared<const HeightIndex>(box_of(*pictures, display))},
                   {PixelMap::true_scale(display, {0, 0})}};
  model.pictures = pictures;
  return {model};
}

}  // namespace

TEST_CASE("An engine exposes the picture of a height instead of the model, whatever the compensation is") {
  const auto pictures = two_pictures();
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    EngineSettings settings{kDisplay, mode};
    settings.compensation.growth = Micrometers{100};
    ContourEngine engine(pictured(pictures), settings);
    Mask expected(Pixels{40}, Pixels{20});
    pictures->draw(Nanometers{0}, expected);
    CHECK(engine.mask_at(kLayer / 2) == expected);
    CHECK(engine.coverage() == expected);
    pictures->draw(kLayer, expected);
    CHECK(engine.mask_at(kLayer * 3 / 2) == expected);
    CHECK(engine.count_loops() == 0);
    CHECK(engine.intersecting_facets() == 0);
    CHECK(engine.contours_at(kLayer / 2).loops.empty());
    CHECK(engine.mask_at(kLayer * 2).lit_pixels() == 0);
    CHECK(engine.mask_at(Nanometers{-1}).lit_pixels() == 0);
  }
}

TEST_CASE("The printer's gamma, threshold and uniformity mask apply to pictures as to masks of models") {
  EngineSettings settings{kDisplay};
  settings.tone = {2.0, 10};
  settings.uniformity.emplace(Pixels{40}, Pixels{20});
  for (std::int32_t y = 0; y < 20; ++y)
    std::ranges::fill(settings.uniformity->row(y), std::uint8_t{200});
  const auto pictures = two_pictures();
  ContourEngine engine(pictured(pictures), settings);
  const ExposureCorrection correction(settings.tone, settings.uniformity);
  Mask picture(Pixels{40}, Pixels{20}), expected = picture;
  for (const Nanometers height : {kLayer / 2, kLayer * 3 / 2}) {
    pictures->draw(height, picture);
    correction.apply(picture, expected);
    CHECK(engine.mask_at(height) == expected);
    CHECK(engine.coverage() == picture);
  }
}

TEST_CASE("A pictured copy that is left dark has no light from its height on") {
  ContourEngine engine(pictured(two_pictures()), {kDisplay});
  engine.darken(0, 0, kLayer);
  CHECK(engine.mask_at(kLayer / 2).lit_pixels() == 1);
  CHECK(engine.mask_at(kLayer * 3 / 2).lit_pixels() == 0);
  engine.light_all();
  CHECK(engine.mask_at(kLayer * 3 / 2).lit_pixels() == 80);
}

TEST_CASE("A warm engine draws pictures without allocating") {
  ContourEngine engine(pictured(two_pictures()), {kDisplay});
  CHECK(allocations_when_warm(2, [&engine] {
          for (int i = 0; i < 100; ++i)
            (void)engine.mask_at(Nanometers{2'500 * i});
        }) == 0);
}

TEST_CASE("Pictures of another size than the display's are refused") {
  CHECK_THROWS_AS(ContourEngine(pictured(two_pictures(Pixels{41}), {Pixels{41}, Pixels{20}}), {kDisplay}),
                  std::invalid_argument);
}

TEST_CASE("The box of pictures encloses their light where the display shows it") {
  for (const bool mirrored : {false, true}) {
    DisplayGeometry display = kDisplay;
    display.mirror_x = mirrored;
    const std::vector<Facet> facets = box_of(*two_pictures(), display);
    const HeightIndex box(facets);
    CHECK(!box.turned_outwards());
    const Bounds& bounds = box.bounds();
    const double left = (5 - 20) * 0.05, right = (30 - 20) * 0.05;
    CHECK(bounds.min_x == Approx(mirrored ? -right : left));
    CHECK(bounds.max_x == Approx(mirrored ? -left : right));
    CHECK(bounds.min_y == Approx((10 - 12) * 0.05));
    CHECK(bounds.max_y == Approx((10 - 3) * 0.05));
    CHECK(bounds.min_z == 0);
    CHECK(bounds.max_z == Approx(0.2));
  }
}
