#include "core/engine/contour_engine.hpp"

#include "core/support/support_structure.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/near.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/random_shapes.hpp"

using models::inverted;
using models::together;

namespace {

// The square from (0, 0) to (20, 20) is in the display's middle.
ContourEngine square_engine(models::Facets facets, const EngineSettings& settings = {kFineDisplay}) {
  return engine_for(std::move(facets), settings, {10, 10});
}

Mask mask_of(const models::Facets& facets, Nanometers height, AntiAliasing anti_aliasing = AntiAliasing::On) {
  return square_engine(facets, {kFineDisplay, anti_aliasing}).mask_at(height);
}

// Returns the lit area in square millimetres.
double area(const Mask& mask) {
  return mask.lit_area() * 0.05 * 0.05;
}

// A slab of 20 x 20 x 5 mm with a post of 10 x 10 x 5 mm on top.
models::Facets slab_and_post() {
  return together(models::box({0, 0, 0}, {20, 20, 5}), models::box({5, 5, 5}, {15, 15, 10}));
}

models::Facets ball() {
  models::Facets facets = models::sphere(8, 16);
  models::translate(facets, 10, 10, 0);
  return facets;
}

}  // namespace

TEST_CASE("A mask is the section just above its height") {
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine engine = square_engine(slab_and_post(), {kFineDisplay, mode});
    CHECK(engine.mask_at(Nanometers{-1}).lit_pixels() == 0);
    CHECK(near(area(engine.mask_at(Nanometers{0})), 400));
    CHECK(near(area(engine.mask_at(Nanometers{4'999'999})), 400));
    CHECK(near(area(engine.mask_at(Nanometers{5'000'000})), 100));
    CHECK(near(area(engine.mask_at(Nanometers{9'999'999})), 100));
    CHECK(engine.mask_at(Nanometers{10'000'000}).lit_pixels() == 0);
  }
}

TEST_CASE("A cavity under a roof opens and closes at its flat faces") {
  ContourEngine engine = square_engine(
      together(models::box({0, 0, 0}, {20, 20, 20}), inverted(models::box({5, 5, 5}, {15, 15, 15}))));
  CHECK(near(area(engine.mask_at(Nanometers{4'999'999})), 400));
  CHECK(near(area(engine.mask_at(Nanometers{5'000'000})), 300));
  CHECK(near(area(engine.mask_at(Nanometers{14'999'999})), 300));
  CHECK(near(area(engine.mask_at(Nanometers{15'000'000})), 400));
}

TEST_CASE("Solids that overlap or share a wall are lit once and without a dark line") {
  const Nanometers middle{5'000'000};
  const auto overlapping =
      together(models::box({0, 0, 0}, {10, 10, 10}), models::box({5, 5, 0}, {15, 15, 10}));
  CHECK(near(area(mask_of(overlapping, middle)), 175));
  const auto sharing = together(models::box({0, 0, 0}, {10, 10, 10}), models::box({10, 0, 0}, {20, 10, 10}));
  CHECK(near(area(mask_of(sharing, middle)), 200));
  const auto stacked = together(models::box({0, 0, 0}, {10, 10, 5}), models::box({0, 0, 5}, {10, 10, 10}));
  CHECK(near(area(mask_of(stacked, middle)), 100));
}

TEST_CASE("Heights count from the model's lowest point, wherever it is") {
  models::Facets low = slab_and_post();
  models::translate(low, 0, 0, -64);
  ContourEngine engine = square_engine(low);
  CHECK(near(area(engine.mask_at(Nanometers{1'000'000})), 400));
  CHECK(near(area(engine.mask_at(Nanometers{6'000'000})), 100));
  CHECK(near(area(engine.mask_at_z(Millimeters{-60})), 400));
  CHECK(near(area(engine.mask_at_z(Millimeters{-58})), 100));
  CHECK(engine.mask_at_z(Millimeters{1}).lit_pixels() == 0);
}

TEST_CASE("A mask has the display's size") {
  ContourEngine engine = square_engine(slab_and_post());
  CHECK(engine.mask_at(Nanometers{1}).width() == kFineDisplay.width);
  CHECK(engine.mask_at(Nanometers{1}).height() == kFineDisplay.height);
  CHECK(engine.join_tolerance() == Millimeters{0.05});
}

TEST_CASE("A display without pixels or with too many is refused") {
  const auto engine = [](int width, int height) {
    return ContourEngine(HeightIndex(), {.display = {Pixels{width}, Pixels{height}}}, {});
  };
  CHECK_THROWS_AS(engine(0, 100), std::invalid_argument);
  CHECK_THROWS_AS(engine(100, 16385), std::invalid_argument);
}

TEST_CASE("Every copy of a model is lit at its place") {
  const HeightIndex post(models::box({0, 0, 0}, {2, 2, 5}));
  const PixelMap left = PixelMap::true_scale(kFineDisplay, {6, 1}),
                 right = PixelMap::true_scale(kFineDisplay, {-4, 1});
  const auto mask_with = [&](const std::vector<PixelMap>& copies) {
    return Mask(ContourEngine(post, {.display = kFineDisplay}, copies).mask_at(Nanometers{1}));
  };
  const Mask both = mask_with({left, right}), one = mask_with({left}), other = mask_with({right});
  CHECK(both.lit_area() == 2 * 40.0 * 40.0);
  for (std::size_t i = 0; i < both.pixels().size(); ++i) {
    if (both.pixels()[i] != one.pixels()[i] + other.pixels()[i]) FAIL("pixel " << i);
  }
  CHECK(mask_with({}).lit_pixels() == 0);
}

TEST_CASE("A darkened copy is dark from its height on, and the others keep every pixel") {
  models::Facets facets = models::sphere(1, 24);
  models::translate(facets, 1, 1, 1);
  const PixelMap left = PixelMap::true_scale(kFineDisplay, {6, 1}),
                 right = PixelMap::true_scale(kFineDisplay, {-4, 1});
  const auto hole = std::make_shared<const SupportStructure>(
      std::vector<SupportPrimitive>{Frustum{{1, 1, 0}, {1, 1, 2}, 0.2, 0.2}});
  for (const double growth_um : {0.0, 120.0}) {
    const EngineSettings settings{.display = kFineDisplay,
                                  .compensation = {.growth = Micrometers{growth_um}}};
    const auto engine_of = [&](std::vector<PixelMap> copies) {
      return ContourEngine({PlateModel{{shared_index(facets)}, std::move(copies), hole}}, settings);
    };
    ContourEngine both = engine_of({left, right}), changed = engine_of({left, right}),
                  one = engine_of({right});
    changed.darken(0, 0, mm(1));
    CHECK(changed.models().front().copies.size() == 2);
    for (const std::int64_t um : {50, 990, 999, 1000, 1500, 1990}) {
      const Nanometers height{um * 1000};
      CHECK(changed.mask_at(height) == (um < 1000 ? both : one).mask_at(height));
    }
  }
}

TEST_CASE("Sections beside the models are replaced from a height on") {
  const auto pillar = [](double x) {
    return std::make_shared<const SupportStructure>(
        std::vector<SupportPrimitive>{Frustum{{x, 0, 0}, {x, 0, 9}, 1, 1}});
  };
  const std::vector<PlateModel> post{plate_model(models::box({0, 0, 0}, {1, 1, 5}))};
  const EngineSettings settings{.display = kCoarseDisplay};
  ContourEngine changed(post, settings, pillar(-5)), left(post, settings, pillar(-5)),
      right(post, settings, pillar(5)), middle(post, settings, pillar(0)), none(post, settings);
  changed.replace_beside(pillar(0), mm(2));
  changed.replace_beside(pillar(5), mm(2));
  CHECK(changed.mask_at(mm(2) - Nanometers{1}) == left.mask_at(mm(1)));
  CHECK(changed.mask_at(mm(2)) == right.mask_at(mm(2)));
  changed.replace_beside(pillar(0), mm(3));
  CHECK(changed.mask_at(mm(4)) == middle.mask_at(mm(4)));
  const Mask bare = none.mask_at(mm(4));
  none.replace_beside(pillar(0), mm(3));
  CHECK(none.mask_at(mm(4)) == bare);
}

TEST_CASE("The copies of a cracked model are lit alike") {
  models::Facets box = models::box({0, 0, 0}, {2, 2, 5});
  box.pop_back();
  const HeightIndex model(box);
  ContourEngine engine(
      model, {.display = kFineDisplay},
      {PixelMap::true_scale(kFineDisplay, {6, 1}), PixelMap::true_scale(kFineDisplay, {-4, 1})});
  CHECK(engine.mask_at(Nanometers{1'000'000}).lit_area() == 2 * 40.0 * 40.0);
}

TEST_CASE("Two models on a plate are lit together and each stands on it") {
  const auto low = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {2, 2, 5}));
  const auto sunk = std::make_shared<const HeightIndex>(models::box({0, 0, -90}, {2, 2, -88}));
  ContourEngine engine({{{low}, {PixelMap::true_scale(kFineDisplay, {6, 1})}},
                        {{sunk}, {PixelMap::true_scale(kFineDisplay, {-4, 1})}}},
                       {kFineDisplay, AntiAliasing::On});
  CHECK(engine.mask_at(Nanometers{1'000'000}).lit_area() == 2 * 40.0 * 40.0);
  CHECK(engine.intersecting_facets() == 16);
  CHECK(engine.mask_at(Nanometers{3'000'000}).lit_area() == 40.0 * 40.0);
}

TEST_CASE("A layer reports the gaps bridged to close it, and an intact layer reports none") {
  models::Facets box = models::box({0, 0, 0}, {2, 2, 5});
  ContourEngine intact = square_engine(box);
  box.pop_back();
  ContourEngine engine = square_engine(box);
  (void)intact.mask_at(Nanometers{1'000'000});
  CHECK(intact.cracks() == LayerCracks{});
  (void)engine.mask_at(Nanometers{1'000'000});
  const LayerCracks of_mask = engine.cracks();
  CHECK(of_mask.open_chains == 1);
  CHECK(of_mask.gaps_closed == 0);
  CHECK(of_mask.widest_gap.count() > 0.05);
  (void)engine.contours_at(Nanometers{1'000'000});
  CHECK(engine.cracks() == of_mask);
  // Above the model: cracks of an earlier height are no longer reported.
  (void)engine.mask_at(Nanometers{9'000'000});
  CHECK(engine.cracks() == LayerCracks{});
}

TEST_CASE("A missing, turned or doubled facet changes no pixel if its gap is a straight line") {
  const models::Facets whole = ball();
  CHECK(rc::check([&] {
    const auto chosen =
        static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(whole.size()) - 1));
    const Bounds bounds = bounds_of(std::span(whole).subspan(chosen, 1));
    const Millimeters z{(bounds.min_z + bounds.max_z) / 2};
    const auto mask_at = [z](const models::Facets& facets) {
      return Mask(square_engine(facets).mask_at_z(z));
    };
    const Mask intact = mask_at(whole);
    RC_ASSERT(intact.lit_pixels() > 0);
    models::Facets missing = whole;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(chosen));
    RC_ASSERT(mask_at(missing) == intact);
    models::Facets turned = whole;
    std::swap(turned[chosen].vertices[0], turned[chosen].vertices[1]);
    RC_ASSERT(mask_at(turned) == intact);
    models::Facets doubled = whole;
    doubled.push_back(whole[chosen]);
    RC_ASSERT(mask_at(doubled) == intact);
  }));
}

TEST_CASE("A cracked model's mask differs from the intact one only near the crack") {
  const models::Facets whole = ball();
  CHECK(rc::check([&] {
    const auto chosen =
        static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(whole.size()) - 1));
    models::Facets cracked = whole;
    // A crack of 10 um, a fifth of a pixel.
    for (Vertex& v : cracked[chosen].vertices)
      v.x += 0.01F;
    const Bounds bounds = bounds_of(std::span(cracked).subspan(chosen, 1));
    const Millimeters z{(bounds.min_z + bounds.max_z) / 2};
    const Mask intact = square_engine(whole).mask_at_z(z);
    const Mask mask = square_engine(cracked).mask_at_z(z);
    // The facet's box on the display and a pixel around it.
    const PixelMap map = PixelMap::true_scale(kFineDisplay, {10, 10});
    const PixelPoint upper_left = map.to_pixels({bounds.min_x, bounds.max_y});
    const PixelPoint lower_right = map.to_pixels({bounds.max_x, bounds.min_y});
    int worst_near = 0, worst_elsewhere = 0;
    for (std::int32_t row = 0; row < mask.height().count(); ++row) {
      const auto pixels = mask.row(row), intact_pixels = intact.row(row);
      for (std::int32_t column = 0; column < mask.width().count(); ++column) {
        const auto at = static_cast<std::size_t>(column);
        const bool near_crack = row + 1 >= upper_left.y - 1 && row <= lower_right.y + 1 &&
                                column + 1 >= upper_left.x - 1 && column <= lower_right.x + 1;
        int& worst = near_crack ? worst_near : worst_elsewhere;
        worst = std::max(worst, std::abs(pixels[at] - intact_pixels[at]));
      }
    }
    RC_ASSERT(worst_elsewhere == 0);
    // A fifth of a pixel's width, and 1.5 levels for the roundings of both masks.
    RC_ASSERT(worst_near <= 0.2 * 255 + 1.5);
  }));
}

TEST_CASE("The same height gives the same bytes, whatever came before") {
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    for (const bool broken : {false, true}) {
      models::Facets facets = models::gyroid_sphere(9, 6, 20);
      models::translate(facets, 10, 10, 0);
      if (broken) facets.erase(facets.begin() + 5, facets.begin() + 50);
      ContourEngine engine = square_engine(facets, {kFineDisplay, mode});
      std::vector<Mask> first;
      for (std::int64_t um = 0; um < 18'000; um += 900)
        first.push_back(engine.mask_at(Nanometers{um * 1000}));
      CHECK(std::ranges::count_if(first, [](const Mask& mask) { return mask.lit_pixels() > 0; }) > 15);
      (void)engine.contours_at(Nanometers{5'000'000});
      for (std::size_t i = first.size(); i-- > 0;) {
        const Nanometers height{static_cast<std::int64_t>(i) * 900'000};
        CHECK(engine.mask_at(height) == first[i]);
        CHECK(engine.mask_at(height) == first[i]);
        CHECK(square_engine(facets, {kFineDisplay, mode}).mask_at(height) == first[i]);
      }
    }
  }
}

TEST_CASE("The order of the facets in the file does not matter") {
  CHECK(rc::check([] {
    models::Facets facets = ball();
    const Nanometers height{testing::draw(0, 16'000'000)};
    const Mask mask = mask_of(facets, height);
    std::rotate(facets.begin(), facets.begin() + testing::draw(0, static_cast<std::int64_t>(facets.size())),
                facets.end());
    std::ranges::reverse(facets);
    RC_ASSERT(mask_of(facets, height) == mask);
  }));
}

TEST_CASE("A section's contours are in the model's coordinates and count its facets") {
  ContourEngine engine = square_engine(slab_and_post());
  const Contours& contours = engine.contours_at(Nanometers{6'000'000});
  REQUIRE(contours.loops.size() == 1);
  CHECK(engine.intersecting_facets() == 8);
  for (const Point& p : contours.points) {
    CHECK((p.x == 5 || p.x == 15 || p.y == 5 || p.y == 15));
  }
  (void)engine.mask_at(Nanometers{20'000'000});
  CHECK(engine.intersecting_facets() == 0);
}

TEST_CASE("A model without facets is dark") {
  ContourEngine engine = square_engine({});
  CHECK(engine.mask_at(Nanometers{0}).lit_pixels() == 0);
  CHECK(engine.mask_at_z(Millimeters{0}).lit_pixels() == 0);
  CHECK(engine.contours_at(Nanometers{0}).loops.empty());
}

TEST_CASE("An engine returns its model") {
  const ContourEngine engine = square_engine(slab_and_post());
  CHECK(engine.model().facets().size() == 24);
  CHECK(engine.model().bounds().max_z == 10);
}

namespace {

// A slab with a post, and beside it a ball that floats far above 0 in its own coordinates.
std::vector<PlateModel> slab_and_ball() {
  models::Facets floating = models::sphere(3, 16);
  models::translate(floating, 100, 100, 75);
  return {{{shared_index(slab_and_post())}, {PixelMap::true_scale(kFineDisplay, {12, 10})}},
          {{shared_index(floating)},
           {PixelMap::true_scale(kFineDisplay, {91, 100}), PixelMap::true_scale(kFineDisplay, {100, 93})}}};
}

EngineSettings with_compensation(const Compensation& compensation,
                                 AntiAliasing anti_aliasing = AntiAliasing::On) {
  return {.display = kFineDisplay, .anti_aliasing = anti_aliasing, .compensation = compensation};
}

}  // namespace

TEST_CASE("Several models all stand on the plate and their masks unite") {
  const std::vector<PlateModel> models = slab_and_ball();
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine both(models, {kFineDisplay, mode});
    ContourEngine slab({models[0]}, {kFineDisplay, mode}), balls({models[1]}, {kFineDisplay, mode});
    bool overlap_seen = false, second_seen = false;
    for (std::int64_t um = 0; um < 11'000; um += 250) {
      const Nanometers height{um * 1000};
      const Mask& mask = both.mask_at(height);
      const Mask& first = slab.mask_at(height);
      const Mask& second = balls.mask_at(height);
      second_seen = second_seen || second.lit_pixels() > 0;
      CHECK((second.lit_pixels() > 0) == (um > 0 && um < 6'000));
      for (std::size_t i = 0; i < mask.pixels().size(); ++i) {
        const int a = first.pixels()[i], b = second.pixels()[i], united = mask.pixels()[i];
        overlap_seen = overlap_seen || (a > 0 && b > 0);
        // Where the models overlap their sides are cut, which rounds a grey value again.
        const bool right = a == 0 || b == 0 ? std::abs(united - a - b) <= 1 : united >= std::max(a, b) - 1;
        if (!right) FAIL("pixel " << i << " at " << um << " um: " << a << ", " << b << ": " << united);
      }
    }
    CHECK(overlap_seen);
    CHECK(second_seen);
  }
}

TEST_CASE("The contours of several models follow each other, each in its own coordinates") {
  ContourEngine engine(slab_and_ball(), {kFineDisplay, AntiAliasing::On});
  CHECK(engine.models().size() == 2);
  const Contours& both = engine.contours_at(Nanometers{3'000'000});
  REQUIRE(both.loops.size() == 2);
  CHECK(both.closed_loops() == 2);
  for (const Point& point : both.points_of(both.loops[0]))
    CHECK((point.x <= 20 && point.y <= 20));
  for (const Point& point : both.points_of(both.loops[1]))
    CHECK((point.x >= 97 && point.y >= 97));
  const std::uint32_t facets = engine.intersecting_facets();
  ContourEngine slab({slab_and_ball()[0]}, {kFineDisplay, AntiAliasing::On});
  (void)slab.contours_at(Nanometers{3'000'000});
  CHECK(slab.intersecting_facets() == 8);
  CHECK(facets > 8);
  CHECK(engine.contours_at(Nanometers{6'500'000}).loops.size() == 1);
}

TEST_CASE("The gaps of several models are counted together") {
  models::Facets cracked = slab_and_post();
  cracked.erase(cracked.begin() + 5);
  const auto model = shared_index(cracked);
  const PixelMap map = PixelMap::true_scale(kFineDisplay, {10, 10});
  const auto chains_at = [&](const std::vector<PlateModel>& models) {
    std::vector<std::uint32_t> chains;
    ContourEngine engine(models, {kFineDisplay, AntiAliasing::On});
    for (std::int64_t um = 500; um < 10'000; um += 500)
      chains.push_back(engine.contours_at(Nanometers{um * 1000}).cracks.open_chains);
    return chains;
  };
  const auto one = chains_at({{{model}, {map}}}), two = chains_at({{{model}, {map}}, {{model}, {map}}});
  CHECK(std::ranges::max(one) > 0);
  for (std::size_t i = 0; i < one.size(); ++i)
    CHECK(two[i] == 2 * one[i]);
}

TEST_CASE("The loops of a mask are counted from its own cut and equal those of the contours") {
  models::Facets cracked = slab_and_post();
  cracked.erase(cracked.begin() + 5);
  for (const Micrometers growth : {Micrometers{0}, Micrometers{100}}) {
    for (const models::Facets& facets : {slab_and_post(), ball(), cracked}) {
      const auto model = shared_index(facets);
      const PixelMap map = PixelMap::true_scale(kFineDisplay, {10, 10});
      const std::vector<PlateModel> models{{{model}, {map}}, {{model}, {map, map}}};
      ContourEngine engine(models, with_compensation({growth})), other(models, {.display = kFineDisplay});
      for (std::int64_t um = -250; um < 10'500; um += 250) {
        (void)engine.mask_at(Nanometers{um * 1000});
        const std::uint32_t facets_cut = engine.intersecting_facets();
        const LayerCracks cracks = engine.cracks();
        const Contours& contours = other.contours_at(Nanometers{um * 1000});
        CHECK(engine.count_loops() == contours.loops.size());
        CHECK(engine.count_loops() == contours.loops.size());
        CHECK(other.count_loops() == contours.loops.size());
        CHECK(facets_cut == other.intersecting_facets());
        CHECK(cracks == contours.cracks);
        CHECK(engine.cracks() == cracks);
      }
    }
  }
}

TEST_CASE("A plate without models is dark") {
  ContourEngine engine({}, {kFineDisplay, AntiAliasing::On});
  CHECK(engine.mask_at(Nanometers{0}).lit_pixels() == 0);
  CHECK(engine.contours_at(Nanometers{0}).loops.empty());
}

TEST_CASE("A part grows and shrinks by its compensation on every side") {
  for (const double um : {-500.0, -130.0, -10.0, 10.0, 130.0, 500.0}) {
    CAPTURE(um);
    const double d = um / 1000;
    ContourEngine engine = square_engine(slab_and_post(), with_compensation({.growth = Micrometers{um}}));
    const auto exact = [d](double side) {
      return d < 0 ? (side + 2 * d) * (side + 2 * d) : side * side + 4 * side * d + std::numbers::pi * d * d;
    };
    // The chords of four quarter circles, and half a level at each pixel of these and of the sides.
    const double tolerance =
        4 * d * d * 0.0005 + 2 * std::numbers::pi * std::fabs(d) * 0.0005 + 2000 * 0.5 / 255 * 0.05 * 0.05;
    CHECK(near(area(engine.mask_at(Nanometers{1'000'000})), exact(20), tolerance));
    CHECK(near(area(engine.mask_at(Nanometers{6'000'000})), exact(10), tolerance));
  }
}

TEST_CASE("The elephant foot is removed at the plate, and nothing above its height") {
  const Compensation foot{{}, Micrometers{200}, Nanometers{2'000'000}};
  ContourEngine engine = square_engine(slab_and_post(), with_compensation(foot));
  CHECK(near(area(engine.mask_at(Nanometers{0})), 19.6 * 19.6));
  CHECK(near(area(engine.mask_at(Nanometers{1'000'000})), 19.8 * 19.8));
  ContourEngine plain = square_engine(slab_and_post());
  for (const std::int64_t nm : {2'000'000, 3'000'000, 6'000'000})
    CHECK(engine.mask_at(Nanometers{nm}) == plain.mask_at(Nanometers{nm}));
}

TEST_CASE("A compensated 1-bit mask lights the pixels whose centres are within the distance of the part") {
  models::Facets facets = models::gyroid_sphere(9, 6, 24);
  models::translate(facets, 10, 10, 0);
  const Nanometers height{7'300'000};
  const Contours contours = square_engine(facets).contours_at(height);
  for (const double um : {-180.0, -60.0, 60.0, 180.0}) {
    CAPTURE(um);
    ContourEngine engine =
        square_engine(facets, with_compensation({.growth = Micrometers{um}}, AntiAliasing::Off));
    const Mask& mask = engine.mask_at(height);
    std::int64_t lit = 0, wrong = 0;
    for (std::int32_t row = 0; row < mask.height().count(); row += 3) {
      for (std::int32_t column = 0; column < mask.width().count(); column += 3) {
        const Point center{10 + (column + 0.5 - 240) * 0.05, 10 - (row + 0.5 - 220) * 0.05};
        const double away = testing::distance_to_sides(contours, center) *
                            (testing::winding_around(contours, center) != 0 ? -1 : 1);
        // The chords of arcs, and points within 2^-15 mm that count as equal.
        if (std::fabs(away - um / 1000) < 0.0006) continue;
        const bool is_lit = mask.row(row)[static_cast<std::size_t>(column)] != 0;
        lit += is_lit;
        wrong += is_lit != (away < um / 1000);
      }
    }
    CHECK(lit > 100);
    CHECK(wrong == 0);
  }
}

TEST_CASE("A compensated grey mask's light is the moved contours' area") {
  models::Facets facets = models::gyroid_sphere(9, 6, 24);
  models::translate(facets, 10, 10, 0);
  const Nanometers height{7'300'000};
  const Contours contours = square_engine(facets).contours_at(height);
  for (const double um : {-100.0, 100.0}) {
    Contours moved;
    ContourOffset().offset(contours, Millimeters{um / 1000}, moved);
    const double exact = testing::signed_area(moved);
    ContourEngine engine = square_engine(facets, with_compensation({.growth = Micrometers{um}}));
    CHECK(near(area(engine.mask_at(height)), exact, exact * 1e-4));
  }
}

TEST_CASE("Every copy of a compensated model is lit alike, mirrored or not") {
  const HeightIndex post(models::box({0, 0, 0}, {2, 2, 5}));
  DisplayGeometry mirrored = kFineDisplay;
  mirrored.mirror_x = true;
  EngineSettings settings = with_compensation({.growth = Micrometers{100}});
  const double one = 4 + 8 * 0.1 + std::numbers::pi * 0.01;
  ContourEngine engine(post, settings,
                       {PixelMap::true_scale(kFineDisplay, {6, 1}), PixelMap::true_scale(mirrored, {6, 1})});
  // Twice the chords of a circle of 0.1 mm, and half a level at 2 x 180 pixels.
  CHECK(near(area(engine.mask_at(Nanometers{1})), 2 * one, 2 * 0.63 * 0.0005 + 360 * 0.5 / 255 * 0.0025));
}

TEST_CASE("The uniformity mask, threshold and gamma are applied to the mask and not to its coverage") {
  EngineSettings settings = with_compensation({});
  settings.tone = {2.2, 10};
  settings.uniformity.emplace(kFineDisplay.width, kFineDisplay.height);
  for (std::int32_t y = 0; y < kFineDisplay.height.count(); ++y)
    std::ranges::fill(settings.uniformity->row(y), static_cast<std::uint8_t>(155 + y % 100));
  ContourEngine engine = square_engine(ball(), settings), plain = square_engine(ball());
  for (const std::int64_t nm : {8'000'000, 1'000'000}) {
    const Mask& mask = engine.mask_at(Nanometers{nm});
    const Mask& coverage = plain.mask_at(Nanometers{nm});
    CHECK(engine.coverage() == coverage);
    Mask expected(kFineDisplay.width, kFineDisplay.height);
    ExposureCorrection(settings.tone, settings.uniformity).apply(coverage, expected);
    CHECK(mask == expected);
    CHECK(mask != coverage);
    CHECK(plain.coverage() == coverage);
  }
}

TEST_CASE("A uniformity mask of another size than the display is refused") {
  EngineSettings settings = with_compensation({});
  settings.uniformity.emplace(kFineDisplay.height, kFineDisplay.width);
  CHECK_THROWS_AS(square_engine(ball(), settings), std::invalid_argument);
}
