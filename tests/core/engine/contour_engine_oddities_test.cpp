// Meshes as people really have them: parts that are not on a solid's outside must not show in the masks.

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::Facets;
using models::inverted;
using models::together;

namespace {

// True if both have the same masks at heights all over the first, including the heights of its vertices.
bool same_masks(const Facets& clean, const Facets& odd) {
  const Bounds bounds = bounds_of(clean);
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine one = engine_for(clean, {kFineDisplay, mode}),
                  other = engine_for(odd, {kFineDisplay, mode});
    for (int i = 0; i <= 16; ++i) {
      const Millimeters z{bounds.min_z + bounds.size_z() * i / 16};
      if (one.mask_at_z(z) != other.mask_at_z(z)) return false;
    }
  }
  return true;
}

std::vector<Facets> clean_models() {
  return {models::box({-6, -5, 0}, {6, 5, 8}), models::sphere(8, 16), models::gyroid_sphere(8, 5, 20)};
}

}  // namespace

TEST_CASE("Duplicate facets do not change the masks") {
  for (const Facets& clean : clean_models()) {
    models::Dice dice(3);
    Facets odd = clean;
    for (int i = 0; i < 30; ++i)
      odd.push_back(clean[dice.below(clean.size())]);
    CHECK(same_masks(clean, odd));
  }
}

TEST_CASE("Neighbouring duplicate facets do not change the masks and are no cracks") {
  struct Patch {
    Facets clean;
    double reach;  // smaller than any loop, so that a section has runs of doubled segments
  };
  for (const auto& [clean, reach] :
       {Patch{clean_models()[0], 8.5}, Patch{clean_models()[1], 1.6}, Patch{clean_models()[2], 1.6}}) {
    CAPTURE(clean.size());
    Facets odd = clean;
    for (const Facet& facet : clean) {
      const Vertex& v = facet.vertices[0];
      const double x = v.x - 6.0, y = v.y - 2.0, z = v.z - 4.0;
      if (x * x + y * y + z * z < reach * reach) odd.push_back(facet);
    }
    CHECK(odd.size() > clean.size() + 1);
    CHECK(odd.size() < 2 * clean.size());
    CHECK(same_masks(clean, odd));
    ContourEngine engine = engine_for(odd);
    for (double z = 0.3; z < 8; z += 0.7) {
      (void)engine.mask_at_z(Millimeters{z});
      CHECK(engine.cracks() == LayerCracks{});
    }
  }
}

TEST_CASE("Loops that are there two or three times do not change the masks and do not fill a hole") {
  for (const Facets& clean : clean_models()) {
    Facets twice = together(clean, clean);
    CHECK(same_masks(clean, twice));
    CHECK(same_masks(clean, together(twice, clean)));
  }
  const Facets box = models::box({-6, -5, 0}, {6, 5, 8});
  const Facets cavity = inverted(models::sphere(3, 16));
  const Facets hollow = together(models::box({-6, -5, -8}, {6, 5, 8}), cavity);
  CHECK(same_masks(hollow, together(hollow, cavity)));
  // Only the ring around it is doubled: no facet of the caps.
  Facets ring = box;
  std::ranges::copy_if(box, std::back_inserter(ring), [](const Facet& facet) {
    const auto& [a, b, c] = facet.vertices;
    return a.z != b.z || b.z != c.z;
  });
  CHECK(ring.size() == box.size() + 8);
  CHECK(same_masks(box, ring));
}

TEST_CASE("A wall shared by a solid and another inside it is no crack") {
  const Facets box = models::box({-6, -5, 0}, {6, 5, 8});
  const Facets within = models::box({-3, -5, 0}, {6, 5, 8});
  CHECK(same_masks(box, together(box, within)));
  ContourEngine engine = engine_for(together(box, within));
  (void)engine.mask_at_z(Millimeters{4});
  CHECK(engine.cracks() == LayerCracks{});
  CHECK(testing::signed_area(engine.contours_at(Nanometers{4'000'000})) == 12 * 10 + 9 * 10);
}

TEST_CASE("A box and its copy with a hole have the masks of a box") {
  const Facets clean = models::box({-6, -5, 0}, {6, 5, 8});
  const Facets holed(clean.begin() + 1, clean.end());
  CHECK(same_masks(clean, together(clean, holed)));
}

TEST_CASE("Facets without area do not change the masks") {
  for (const Facets& clean : clean_models()) {
    models::Dice dice(5);
    Facets odd = clean;
    for (int i = 0; i < 30; ++i) {
      const Vertex a = dice.in_ball(9), b = dice.in_ball(9);
      odd.push_back({{a, a, a}});
      odd.push_back({{a, b, a}});
      odd.push_back({{a, b, b}});
    }
    CHECK(same_masks(clean, odd));
  }
}

namespace {

// Returns an upright strip of a cylinder's side, some degrees wide, about the z axis.
Facets bent_sheet(float radius, double degrees, float low, float high) {
  Facets facets;
  constexpr int kSteps = 12;
  const auto at = [&](int step, float z) {
    const double angle = degrees * std::numbers::pi / 180 * step / kSteps;
    return Vertex{static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)),
                  z};
  };
  for (int step = 0; step < kSteps; ++step) {
    facets.push_back({{at(step, low), at(step + 1, low), at(step + 1, high)}});
    facets.push_back({{at(step, low), at(step + 1, high), at(step, high)}});
  }
  return facets;
}

}  // namespace

TEST_CASE("One-sided internal walls do not change the masks, whichever side it is, but are reported") {
  const Facets clean = models::box({-6, -5, 0}, {6, 5, 8});
  for (const Facets& sheet : {bent_sheet(3, 20, 1, 7), bent_sheet(3, 100, 1, 7), bent_sheet(4, 180, 1, 7),
                              Facets{{{Vertex{-3, -3, 1}, Vertex{3, 2, 1}, Vertex{0, 0, 7}}}}}) {
    for (const Facets& wall : {sheet, inverted(sheet)}) {
      CHECK(same_masks(clean, together(clean, wall)));
      CHECK(HeightIndex(together(clean, wall)).repairs().inner_walls == wall.size());
    }
  }
}

TEST_CASE("A shaft that lacks a wall is still a shaft") {
  const Facets box = models::box({-6, -5, 0}, {6, 5, 8});
  const Facets shaft = inverted(models::box({-3, -2, 1}, {3, 2, 7}));
  Facets three_walls = shaft;
  std::erase_if(three_walls, [](const Facet& facet) {
    return std::ranges::all_of(facet.vertices, [](const Vertex& v) { return v.x == 3; });
  });
  CHECK(three_walls.size() == shaft.size() - 2);
  CHECK(same_masks(together(box, shaft), together(box, three_walls)));
}

TEST_CASE("Internal walls do not change the masks") {
  // A sheet of both windings, a shell within the solid, and one shared with another solid.
  const Facets clean = models::box({-6, -5, 0}, {6, 5, 8});
  Facets sheet{{{Vertex{-3, -3, 1}, Vertex{3, 2, 1}, Vertex{0, 0, 7}}}};
  CHECK(same_masks(clean, together(clean, together(sheet, inverted(sheet)))));
  CHECK(same_masks(clean, together(clean, models::box({-3, -3, 2}, {3, 3, 6}))));
  CHECK(same_masks(clean, together(models::box({-6, -5, 0}, {0, 5, 8}), models::box({0, -5, 0}, {6, 5, 8}))));
}

TEST_CASE("Overlapping shells unite and cavities stay empty") {
  const Facets outer = models::box({-6, -5, 0}, {6, 5, 8});
  const Facets cavity = inverted(models::box({-2, -2, 2}, {2, 2, 6}));
  // A second shell inside the first changes nothing, nor does a duplicate of the first.
  CHECK(same_masks(outer, together(outer, models::box({-5, -4, 0}, {5, 4, 8}))));
  const Facets hollow = together(outer, cavity);
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    ContourEngine engine = engine_for(hollow, {kFineDisplay, mode});
    CHECK(engine.mask_at_z(Millimeters{1}).lit_pixels() == 240 * 200);
    CHECK(engine.mask_at_z(Millimeters{4}).lit_pixels() == 240 * 200 - 80 * 80);
    CHECK(engine.mask_at_z(Millimeters{7}).lit_pixels() == 240 * 200);
    // A solid in the cavity is lit.
    ContourEngine filled =
        engine_for(together(hollow, models::box({-1, -1, 2}, {1, 1, 6})), {kFineDisplay, mode});
    CHECK(filled.mask_at_z(Millimeters{4}).lit_pixels() == 240 * 200 - 80 * 80 + 40 * 40);
  }
}

TEST_CASE("A model that is wound inside out has the same masks") {
  for (const Facets& clean : clean_models())
    CHECK(same_masks(clean, inverted(clean)));
}

TEST_CASE("A cube of 20 mm is 400 pixels wide at any whole pixel") {
  const DisplayGeometry display{Pixels{1000}, Pixels{900}, Micrometers{50.0}};
  models::Dice dice(11);
  for (int i = 0; i < 40; ++i) {
    // Whole pixels from the display's left and top edge: the lines of the grid.
    const int column = static_cast<int>(dice.below(600)), row = static_cast<int>(dice.below(500));
    const Point center{10 - (column + 200 - 500) * 0.05, 10 + (row + 200 - 450) * 0.05};
    for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
      ContourEngine engine(HeightIndex(models::box({0, 0, 0}, {20, 20, 20})), EngineSettings{display, mode},
                           {PixelMap::true_scale(display, center)});
      const Mask& mask = engine.mask_at_z(Millimeters{7});
      CAPTURE(column, row);
      CHECK(mask.lit_pixels() == 400 * 400);
      CHECK(mask.row(row)[static_cast<std::size_t>(column)] == 255);
      CHECK(mask.row(row + 399)[static_cast<std::size_t>(column + 399)] == 255);
      CHECK(mask.lit_area() == 400.0 * 400.0);
    }
  }
}

TEST_CASE("Masks at heights out of range or not a number are dark") {
  for (const Facets& facets : clean_models()) {
    for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
      ContourEngine engine = engine_for(facets, {kFineDisplay, mode});
      for (const double z :
           {-1e300, 1e300, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
            std::numeric_limits<double>::quiet_NaN()})
        CHECK(engine.mask_at_z(Millimeters{z}).lit_pixels() == 0);
    }
  }
}

TEST_CASE("Models without height and with the largest float coordinates have masks") {
  constexpr float kHuge = 3e38F, kTiny = 1e-44F;
  const Facets flat{{{Vertex{-1, -1, 2}, Vertex{1, -1, 2}, Vertex{0, 1, 2}}}};
  const Facets huge = models::box({-kHuge, -kHuge, -kHuge}, {kHuge, kHuge, kHuge});
  const Facets tiny = models::box({-kTiny, -kTiny, -kTiny}, {kTiny, kTiny, kTiny});
  for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
    CHECK(engine_for(flat, {kFineDisplay, mode}).mask_at_z(Millimeters{2}).lit_pixels() == 0);
    CHECK(engine_for(huge, {kFineDisplay, mode}).mask_at_z(Millimeters{0}).lit_pixels() == 480 * 440);
    CHECK(engine_for(tiny, {kFineDisplay, mode}).mask_at_z(Millimeters{0}).lit_pixels() <= 1);
  }
}

TEST_CASE("The smallest and the largest display are filled") {
  const Facets box = models::box({-500, -500, 0}, {500, 500, 1});
  for (const int side : {1, 16384}) {
    const DisplayGeometry display{Pixels{side}, Pixels{side}, Micrometers{50.0}};
    ContourEngine engine(HeightIndex(box), EngineSettings{display, AntiAliasing::Off},
                         {PixelMap::true_scale(display, {0, 0})});
    CHECK(engine.mask_at_z(Millimeters{0.5}).lit_pixels() == std::int64_t{side} * side);
  }
}
