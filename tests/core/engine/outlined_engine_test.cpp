// The engine with finished outlines instead of a model's sections.
#include "core/contour/contour_union.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/picture_solid.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/core/warm_allocations.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Nanometers kOutlineLayer{100'000};
const DisplayGeometry kOutlineDisplay{Pixels{200}, Pixels{160}, Micrometers{50}};

// A hollow block with a post beside it, off the pixels' grid.
models::Facets block_with_hole() {
  return models::together({models::box({-3.013F, -2.021F, 0}, {1.507F, 2.033F, 1}),
                           models::inverted(models::box({-2.111F, -1.007F, 0}, {0.413F, 0.909F, 1})),
                           models::cone(1.3, 1, 31)});
}

std::shared_ptr<const HeightIndex> indexed(const models::Facets& facets) {
  return std::make_shared<const HeightIndex>(facets);
}

// Returns the outlines of the model's layers, cut at their middles.
std::shared_ptr<const OutlineStack> outlines_of(const models::Facets& facets, std::int64_t layers) {
  ContourEngine engine({PlateModel{{indexed(facets)}, {PixelMap::true_scale(kOutlineDisplay, {0, 0})}}},
                       {kOutlineDisplay});
  auto stack = std::make_shared<OutlineStack>(kOutlineLayer);
  Contours united;
  for (std::int64_t layer = 0; layer < layers; ++layer) {
    ContourUnion().unite(engine.contours_at(kOutlineLayer * layer + kOutlineLayer / 2), FillRule::NonZero,
                         ContourUnion::kDoubleRounding, united);
    stack->add(united);
  }
  return stack;
}

PlateModel outlined(const std::shared_ptr<const OutlineStack>& outlines) {
  PlateModel model{{indexed(box_of(*outlines))}, {PixelMap::true_scale(kOutlineDisplay, {0, 0})}};
  model.outlines = outlines;
  return model;
}

// Returns the largest difference of two masks' pixels.
int difference(const Mask& a, const Mask& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i)
    most = std::max(most, std::abs(int{a.pixels()[i]} - int{b.pixels()[i]}));
  return most;
}

}  // namespace

TEST_CASE("Finished outlines give the masks of the model that they were cut from, with all corrections") {
  const models::Facets facets = block_with_hole();
  for (const bool corrected : {false, true}) {
    EngineSettings settings{kOutlineDisplay};
    if (corrected) {
      settings.compensation = {Micrometers{-60}, Micrometers{80}, Nanometers{400'000}};
      settings.tone = {1.8, 12};
      settings.uniformity.emplace(kOutlineDisplay.width, kOutlineDisplay.height);
      for (std::int32_t y = 0; y < kOutlineDisplay.height.count(); ++y)
        std::ranges::fill(settings.uniformity->row(y), static_cast<std::uint8_t>(255 - y));
    }
    ContourEngine model({PlateModel{{indexed(facets)}, {PixelMap::true_scale(kOutlineDisplay, {0, 0})}}},
                        settings);
    ContourEngine finished({outlined(outlines_of(facets, 10))}, settings);
    for (std::int64_t layer = 0; layer < 10; ++layer) {
      const Nanometers middle = kOutlineLayer * layer + kOutlineLayer / 2;
      const Mask& expected = model.mask_at(middle);
      REQUIRE(expected.lit_pixels() > 1000);
      // Outlines are rounded to nanometres: a 50,000th of a pixel, and gamma makes it three times as much.
      CHECK(difference(finished.mask_at(middle), expected) <= 1);
      CHECK(finished.contours_at(middle).points.size() > 20);
    }
    CHECK(finished.mask_at(kOutlineLayer * 10).lit_pixels() == 0);
    CHECK(finished.mask_at(Nanometers{-1}).lit_pixels() == 0);
  }
}

TEST_CASE("A layer of outlines is the same at every height within it") {
  ContourEngine engine({outlined(outlines_of(block_with_hole(), 10))}, {kOutlineDisplay});
  const Mask lowest = engine.mask_at(kOutlineLayer * 3);
  CHECK(engine.mask_at(kOutlineLayer * 4 - Nanometers{1}) == lowest);
  CHECK_FALSE(engine.mask_at(kOutlineLayer * 4) == lowest);
  CHECK(engine.count_loops() > 1);
}

TEST_CASE("Outlines without anti-aliasing light the pixels whose centres they enclose") {
  ContourEngine engine({outlined(outlines_of(block_with_hole(), 2))}, {kOutlineDisplay, AntiAliasing::Off});
  const Mask& mask = engine.mask_at(kOutlineLayer);
  CHECK(std::ranges::all_of(mask.pixels(), [](std::uint8_t grey) { return grey == 0 || grey == 255; }));
  CHECK(mask.lit_pixels() > 1000);
}

TEST_CASE("An outlined copy that is left dark has no light from its height on") {
  ContourEngine engine({outlined(outlines_of(block_with_hole(), 10))}, {kOutlineDisplay});
  engine.darken(0, 0, kOutlineLayer * 2);
  CHECK(engine.mask_at(kOutlineLayer * 2 - Nanometers{1}).lit_pixels() > 0);
  CHECK(engine.mask_at(kOutlineLayer * 2).lit_pixels() == 0);
}

TEST_CASE("A warm engine draws outlines without allocating") {
  ContourEngine engine({outlined(outlines_of(block_with_hole(), 10))}, {kOutlineDisplay});
  CHECK(allocations_when_warm(2, [&engine] {
          for (int i = 0; i < 20; ++i)
            (void)engine.mask_at(Nanometers{50'000 * i});
        }) == 0);
}

TEST_CASE("Finished outlines are those of the whole plate") {
  const std::string whole = "finished layers are of the whole plate";
  const PlateModel model = outlined(outlines_of(block_with_hole(), 1));
  CHECK(contract_broken_by([&] { ContourEngine({model, model}, {kOutlineDisplay}); }) == whole);
  PlateModel twice = model;
  twice.copies.push_back(twice.copies.front());
  CHECK(contract_broken_by([&] { ContourEngine({twice}, {kOutlineDisplay}); }) == whole);
}
