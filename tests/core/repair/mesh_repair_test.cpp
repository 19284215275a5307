// Files with one kind of dirt each, whose areas are known.
#include "core/repair/mesh_repair.hpp"

#include "core/contour/filled_area.hpp"
#include "core/model/mesh_report.hpp"
#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::Facets;
using models::inverted;
using models::together;

namespace {

// Returns the printed area at z 5.05, in mm2.
double area_of(const Facets& facets) {
  return filled_area_mm2(testing::contours_of(facets, 5.05));
}

MeshRepairs repairs_of(Facets facets) {
  return repair_mesh(facets);
}

void turn(Facet& facet) {
  std::swap(facet.vertices[0], facet.vertices[1]);
}

void add_quad(Facets& facets, const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) {
  facets.insert(facets.end(), {{{a, b, c}}, {{a, c, d}}});
}

// Returns the wall between two prisms of this many sides (the outer corners on these radii), 20 mm high in
// several bands.
Facets tube(double outer, double inner, int sides, int bands = 1) {
  const auto at = [sides](double radius, int side, float z) {
    const double angle = (side % sides + 0.5) * 2 * std::numbers::pi / sides;
    return Vertex{static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)),
                  z};
  };
  Facets facets;
  for (int i = 0; i < sides; ++i) {
    for (int band = 0; band < bands; ++band) {
      const float low = 20.F * static_cast<float>(band) / static_cast<float>(bands);
      const float high = 20.F * static_cast<float>(band + 1) / static_cast<float>(bands);
      add_quad(facets, at(outer, i, low), at(outer, i + 1, low), at(outer, i + 1, high), at(outer, i, high));
      add_quad(facets, at(inner, i + 1, low), at(inner, i, low), at(inner, i, high), at(inner, i + 1, high));
    }
    add_quad(facets, at(inner, i, 20), at(outer, i, 20), at(outer, i + 1, 20), at(inner, i + 1, 20));
    add_quad(facets, at(inner, i + 1, 0), at(outer, i + 1, 0), at(outer, i, 0), at(inner, i, 0));
  }
  return facets;
}

// 20 mm square outside and 10 mm inside: 300 mm2.
Facets square_tube(int bands = 1) {
  return tube(10 * std::numbers::sqrt2, 5 * std::numbers::sqrt2, 4, bands);
}
const Approx kSquareTube = Approx(300).epsilon(1e-6);

bool is_inner(const Facet& facet) {
  return std::ranges::all_of(facet.vertices, [](const Vertex& v) { return std::hypot(v.x, v.y) < 8; });
}

// Returns a one-sided wall from z 2 to z 18.
void add_wall(Facets& facets, float x0, float y0, float x1, float y1) {
  add_quad(facets, {x0, y0, 2}, {x1, y1, 2}, {x1, y1, 18}, {x0, y0, 18});
}

const Facets& cube() {
  static const Facets facets = models::box({0, 0, 0}, {20, 20, 20});
  return facets;
}

}  // namespace

TEST_CASE("A sound mesh stays as it is, and so do solids that touch or overlap") {
  const Facets touching = together(cube(), models::box({20, 0, 0}, {40, 20, 20}));
  const Facets overlapping = together(cube(), models::box({10, 5, 5}, {40, 15, 35}));
  const Facets within = together(cube(), models::box({5, 5, 5}, {15, 15, 15}));
  const Facets at_an_edge = together(cube(), models::box({20, 20, 0}, {40, 40, 20}));
  const Facets hollow = together(cube(), inverted(models::box({5, 5, 5}, {15, 15, 15})));
  for (const Facets& sound : {cube(), touching, overlapping, within, at_an_edge, hollow,
                              together(tube(10, 5, 64), tube(8, 5, 64)), models::gyroid_sphere(8, 5, 20)}) {
    Facets facets = sound;
    CHECK(repair_mesh(facets) == MeshRepairs{});
    REQUIRE(facets.size() == sound.size());
    for (std::size_t i = 0; i < sound.size(); ++i)
      CHECK(facets[i].vertices == sound[i].vertices);
  }
}

TEST_CASE("A hole shared by two overlapping solids stays a hole") {
  // The part of a circle's area that a polygon of 64 sides has.
  const double part = std::sin(2 * std::numbers::pi / 64) / (2 * std::numbers::pi / 64);
  const Facets tubes = together(tube(10, 5, 64), tube(8, 5, 64));
  CHECK(area_of(tubes) == Approx(75 * std::numbers::pi * part).epsilon(1e-6));
  // A cavity within two solids: its facets are there twice, and needed twice.
  const Facets cavity = inverted(models::box({8, 8, 2}, {12, 12, 18}));
  const Facets both =
      together(together(cube(), cavity), together(models::box({5, 5, 1}, {15, 15, 19}), cavity));
  CHECK(area_of(both) == Approx(400 - 16).epsilon(1e-12));
  CHECK(repairs_of(both) == MeshRepairs{});
  // With a third solid around the cavity, it is needed three times.
  CHECK(area_of(together(both, together(models::box({6, 6, 1}, {14, 14, 19}), cavity))) ==
        Approx(400 - 16).epsilon(1e-12));
}

TEST_CASE("A hole shared by two solids stays a hole whichever facet is turned, doubled or added reversed") {
  const Facets tubes = together(tube(10, 5, 16), tube(8, 5, 16));
  const Facets cavity = inverted(models::box({8, 8, 2}, {12, 12, 18}));
  const Facets boxes =
      together(together(cube(), cavity), together(models::box({5, 5, 1}, {15, 15, 19}), cavity));
  for (const Facets& clean : {tubes, boxes}) {
    const double area = area_of(clean);
    for (std::size_t i = 0; i < clean.size(); ++i) {
      Facets turned = clean, doubled = clean;
      turn(turned[i]);
      doubled.push_back(clean[i]);
      Facets reversed = doubled;
      turn(reversed.back());
      CAPTURE(clean.size(), i);
      for (const Facets& dirty : {turned, doubled, reversed})
        CHECK(area_of(dirty) == Approx(area).epsilon(1e-9));
    }
  }
}

TEST_CASE("A hole stays a hole if one, some or all of its walls are turned") {
  for (unsigned turned = 1; turned < 256; ++turned) {
    Facets facets = square_tube();
    unsigned count = 0, inner = 0;
    for (Facet& facet : facets) {
      if (!is_inner(facet) || (turned >> inner++ & 1U) == 0) continue;
      turn(facet);
      ++count;
    }
    REQUIRE(inner == 8);
    CAPTURE(turned);
    CHECK(area_of(facets) == kSquareTube);
    CHECK(repairs_of(facets) == MeshRepairs{count, 0, 0, 0});
  }
}

TEST_CASE("A turned band of a wall, or half of a part, is turned back") {
  Facets band = square_tube(10), half = band;
  std::uint64_t of_band = 0, of_half = 0;
  for (std::size_t i = 0; i < band.size(); ++i) {
    const auto& [a, b, c] = band[i].vertices;
    const auto within = [](const Vertex& v) { return v.z >= 4 && v.z <= 8; };
    if (is_inner(band[i]) && within(a) && within(b) && within(c)) {
      turn(band[i]);
      ++of_band;
    }
    if (a.x + b.x + c.x > 0) {
      turn(half[i]);
      ++of_half;
    }
  }
  CHECK(area_of(band) == kSquareTube);
  CHECK(repairs_of(band).turned == of_band);
  CHECK(area_of(half) == kSquareTube);
  CHECK(of_half > half.size() / 3);
  const std::uint64_t turned = repairs_of(half).turned;
  CHECK((turned == of_half || turned == half.size() - of_half));
}

TEST_CASE("Cavities within cavities survive half of all facets turned at random") {
  Facets clean = together(models::sphere(14, 24), inverted(models::sphere(10, 20)));
  clean = together(clean, models::sphere(6, 16));
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    models::Dice dice(seed);
    Facets facets = clean;
    for (Facet& facet : facets) {
      if (dice.below(2) == 0) turn(facet);
    }
    CHECK(area_of(facets) == Approx(area_of(clean)).epsilon(1e-12));
  }
}

TEST_CASE("A solid within a solid stays solid when some of its facets are turned") {
  Facets facets = together(cube(), models::box({5, 5, 5}, {15, 15, 15}));
  turn(facets[14]);
  CHECK(area_of(facets) == Approx(400).epsilon(1e-12));
}

TEST_CASE("Reversed duplicates of facets are dropped") {
  for (std::size_t i = 0; i < cube().size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      Facets facets = cube();
      facets.insert(facets.end(), {cube()[i], cube()[j]});
      turn(facets[12]);
      turn(facets[13]);
      CHECK(area_of(facets) == Approx(400).epsilon(1e-12));
      CHECK(repairs_of(facets) == MeshRepairs{0, 0, 2, 0});
    }
  }
}

TEST_CASE("A model whose facets are all there in both directions is solid") {
  CHECK(area_of(together(cube(), inverted(cube()))) == Approx(400).epsilon(1e-12));
  CHECK(area_of(together(square_tube(), inverted(square_tube()))) == kSquareTube);
  const Facets hollow = together(cube(), inverted(models::box({5, 5, 2}, {15, 15, 15})));
  CHECK(area_of(together(hollow, inverted(hollow))) == Approx(300).epsilon(1e-12));
  CHECK(repairs_of(together(inverted(cube()), cube())).reversed == 12);
  // All facets twice.
  const Facets both = together(cube(), inverted(cube()));
  CHECK(area_of(together(both, both)) == Approx(400).epsilon(1e-12));
  // Beside a model that is not double-sided.
  Facets other = models::box({30, 0, 0}, {40, 20, 20});
  CHECK(area_of(together(together(cube(), inverted(cube())), other)) == Approx(600).epsilon(1e-12));
}

TEST_CASE("A double-sided sheet that encloses nothing stays dark") {
  Facets wall;
  add_wall(wall, 30, 0, 40, 10);
  CHECK(area_of(together(wall, inverted(wall))) == 0);
  CHECK(area_of(together(cube(), together(wall, inverted(wall)))) == Approx(400).epsilon(1e-12));
}

TEST_CASE("The same facets cut along other diagonals count once") {
  // A lid twice: four facets instead of two.
  Facets facets = cube();
  add_quad(facets, {0, 0, 20}, {20, 0, 20}, {20, 20, 20}, {0, 20, 20});
  add_quad(facets, {20, 0, 20}, {20, 20, 20}, {0, 20, 20}, {0, 0, 20});
  CHECK(area_of(facets) == Approx(400).epsilon(1e-12));
  CHECK(inspect_mesh(HeightIndex(facets).facets()).watertight);
}

TEST_CASE("One-sided walls within a solid are dropped, whichever way they are turned") {
  Facets crossing, level, grid, u, cross, near, full;
  add_wall(crossing, 5, 5, 15, 15);
  add_wall(crossing, 5, 15, 15, 5);
  for (const float at : {5.F, 10.F, 15.F}) {
    add_wall(grid, 2, at, 18, at);
    add_wall(grid, at, 18, at, 2);
    add_quad(full, {0, at, 0}, {20, at, 0}, {20, at, 20}, {0, at, 20});
    add_quad(full, {at, 0, 0}, {at, 20, 0}, {at, 20, 20}, {at, 0, 20});
  }
  add_wall(u, 5, 15, 5, 5);
  add_wall(u, 5, 5, 15, 5);
  add_wall(u, 15, 5, 15, 15);
  add_wall(cross, 10, 10, 5, 10);
  add_wall(cross, 10, 10, 15, 10);
  add_wall(cross, 10, 10, 10, 5);
  add_wall(cross, 10, 10, 10, 15);
  add_wall(near, 15, 9, 5, 9);
  add_wall(near, 5, 10.6F, 15, 10.6F);
  add_quad(level, {5, 5, 5}, {15, 5, 5}, {15, 15, 5.1F}, {5, 15, 5.1F});
  for (const Facets& walls : {crossing, grid, u, cross, near, level, full}) {
    for (const Facets& dirt : {walls, inverted(walls)}) {
      const Facets facets = together(cube(), dirt);
      CHECK(area_of(facets) == Approx(400).epsilon(1e-12));
      CHECK(repairs_of(facets) == MeshRepairs{0, 0, 0, dirt.size()});
    }
  }
}

TEST_CASE("A wall across a solid along its own edges is dropped") {
  Facets wall;
  add_quad(wall, {0, 0, 0}, {20, 20, 0}, {20, 20, 20}, {0, 0, 20});
  for (const Facets& dirt : {wall, inverted(wall)})
    CHECK(area_of(together(cube(), dirt)) == Approx(400).epsilon(1e-12));
}

TEST_CASE("A wall outside a solid and a part of its surface are not dropped as inner walls", "[long]") {
  Facets outside = cube();
  add_wall(outside, 30, 0, 30, 10);
  CHECK(repairs_of(outside) == MeshRepairs{});
  // A facet whose neighbours are all missing.
  const Facets ball = models::sphere(8, 24);
  for (std::size_t chosen = 0; chosen < ball.size(); chosen += 97) {
    Facets facets = ball;
    const auto touches = [&](const Facet& facet) {
      std::size_t shared = 0;
      for (const Vertex& v : facet.vertices)
        shared += static_cast<std::size_t>(std::ranges::count(ball[chosen].vertices, v));
      return shared == 2;
    };
    std::erase_if(facets, touches);
    CHECK(facets.size() == ball.size() - 3);
    CHECK(repairs_of(facets) == MeshRepairs{});
  }
}

TEST_CASE("Solids whose facets narrowly miss each other are not walls inside another solid") {
  const Facets& solid = cube();
  Facets cavity = inverted(models::sphere(6, 24)), bar = models::globe(6, 24, 36);
  models::translate(cavity, 10, 10, 7);
  models::translate(bar, 18, 10, 7);
  models::Dice dice(6);
  // Less than the tolerance within which ends meet, so that each facet is a patch of its own.
  for (Facets* facets : {&cavity, &bar})
    models::shake_corners(*facets, 0.0005, dice);
  for (const Facets& dirty : {together(solid, cavity), together(solid, bar)})
    CHECK(repairs_of(dirty) == MeshRepairs{});
  CHECK(area_of(together(solid, cavity)) < 400 - 90);
}

TEST_CASE("A wall of facets that narrowly miss each other is dropped") {
  Facets walls;
  add_wall(walls, 5, 15, 5, 5);
  add_wall(walls, 5, 5, 15, 5);
  add_wall(walls, 15, 5, 15, 15);
  models::Dice dice(6);
  models::shake_corners(walls, 0.0005, dice);
  CHECK(repairs_of(together(cube(), walls)) == MeshRepairs{0, 0, 0, walls.size()});
  CHECK(area_of(together(cube(), walls)) == Approx(400).epsilon(1e-12));
}

TEST_CASE("A soup of facets is left as it is, and takes little time") {
  models::Dice dice(4);
  Facets soup(100'000);
  for (Facet& facet : soup) {
    for (Vertex& v : facet.vertices)
      v = dice.in_ball(20);
  }
  CHECK(repairs_of(soup) == MeshRepairs{});
}

TEST_CASE("A repaired mesh needs no further repair") {
  models::Dice dice(9);
  Facets facets = together(models::gyroid_sphere(8, 5, 20), inverted(models::sphere(2, 8)));
  models::turn_facets(facets, 0.4, dice);
  models::double_facets(facets, 0.1, dice);
  models::double_facets_reversed(facets, 0.05, dice);
  CHECK(repair_mesh(facets).has_guesses());
  CHECK(repair_mesh(facets) == MeshRepairs{});
}
