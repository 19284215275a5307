#include "core/contour/contour_loops.hpp"

#include "tests/catch.hpp"
#include "tests/core/near.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"
#include "tests/random_shapes.hpp"

using models::inverted;
using models::together;

namespace {

Contours linked(const std::vector<Segment>& segments, Millimeters tolerance = kPixel) {
  Contours contours;
  ContourLinker().link(segments, tolerance, contours);
  return contours;
}

// All loops lie in `points` one after the other, without a gap and without overlapping.
bool loops_share_out_the_points(const Contours& contours) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  for (const ContourLoop& loop : contours.loops)
    ranges.emplace_back(loop.first_point, loop.point_count);
  std::ranges::sort(ranges);
  std::uint32_t next = 0;
  for (const auto& [first, count] : ranges) {
    if (first != next || count == 0) return false;
    next = first + count;
  }
  return next == contours.points.size();
}

using Side = std::pair<std::pair<double, double>, std::pair<double, double>>;

Side side(const Point& from, const Point& to) {
  return {{from.x, from.y}, {to.x, to.y}};
}

std::multiset<Side> sides_of(const Contours& contours) {
  std::multiset<Side> sides;
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    for (std::size_t i = 0; i < points.size(); ++i) {
      sides.insert(side(points[i], points[(i + 1) % points.size()]));
    }
  }
  return sides;
}

std::multiset<Side> sides_of(const std::vector<Segment>& segments) {
  std::multiset<Side> sides;
  for (const Segment& s : segments)
    sides.insert(side(s.from, s.to));
  return sides;
}

std::vector<Segment> soup_between_few_points() {
  std::vector<Segment> segments(static_cast<std::size_t>(testing::draw(1, 60)));
  for (Segment& s : segments) {
    const auto coordinate = [] { return static_cast<double>(testing::draw(0, 3)); };
    s = {{coordinate(), coordinate()}, {coordinate(), coordinate()}};
    if (s.from == s.to) s.to.x += 1;
  }
  return segments;
}

// Checks a section without any fault.
void check_clean(const Contours& contours) {
  CHECK(contours.cracks.open_chains == 0);
  CHECK(contours.cracks.gaps_closed == 0);
  CHECK(contours.repaired_loops == 0);
  CHECK(contours.cracks.widest_gap == Millimeters{0});
  CHECK(contours.closed_loops() == contours.loops.size());
}

// Returns a square prism whose front stands off by `crack` at the bottom and not at all at the top.
models::Facets cracked_box(float crack) {
  models::Facets facets = models::box({0, 0, 0}, {10, 10, 10});
  for (Facet& facet : facets) {
    const bool front = std::ranges::all_of(facet.vertices, [](const Vertex& v) { return v.y == 0; });
    for (Vertex& v : facet.vertices) {
      if (front && v.z == 0) v.y = -crack;
    }
  }
  return facets;
}

}  // namespace

TEST_CASE("A box is one loop that runs counter-clockwise") {
  const Contours contours = contours_of(models::box({0, 0, 0}, {10, 20, 5}), 2.5);
  REQUIRE(contours.loops.size() == 1);
  check_clean(contours);
  CHECK(near(signed_area(contours), 200));
  CHECK(near(perimeter_mm(contours), 60));
}

TEST_CASE("A cavity is a loop that runs clockwise") {
  const auto facets =
      together(models::box({0, 0, 0}, {20, 20, 20}), inverted(models::box({5, 5, 5}, {15, 15, 15})));
  const Contours contours = contours_of(facets, 10);
  REQUIRE(contours.loops.size() == 2);
  check_clean(contours);
  std::vector<double> areas;
  for (const ContourLoop& loop : contours.loops)
    areas.push_back(signed_area(contours.points_of(loop)));
  std::ranges::sort(areas);
  CHECK(near(areas[0], -100));
  CHECK(near(areas[1], 400));
}

TEST_CASE("Nested boxes are as many loops as there are boxes at a height") {
  auto facets =
      together(models::box({0, 0, 0}, {30, 30, 30}), inverted(models::box({5, 5, 5}, {25, 25, 25})));
  facets = together(facets, models::box({10, 10, 10}, {20, 20, 20}));
  CHECK(contours_of(facets, 2).loops.size() == 1);
  CHECK(contours_of(facets, 7).loops.size() == 2);
  CHECK(contours_of(facets, 15).loops.size() == 3);
  check_clean(contours_of(facets, 15));
  CHECK(near(signed_area(contours_of(facets, 15)), 600));
}

TEST_CASE("Solids that touch or share a place keep their area, without a fault") {
  const models::Facets box = models::box({0, 0, 0}, {10, 10, 10});
  const models::Facets cavities = together(inverted(models::box({0, 0, 1}, {10, 10, 9})),
                                           inverted(models::box({10, 10, 1}, {20, 20, 9})));
  struct Row {
    const char* what;
    models::Facets facets;
    std::vector<double> areas;  // of the loops; empty if only their sum is certain
    double sum;
  };
  for (const Row& row : {
           Row{"two boxes that touch along an edge",
               together(box, models::box({10, 10, 0}, {20, 20, 10})),
               {100, 100},
               200},
           Row{"two cavities that touch along an edge stay inside one solid",
               together(models::box({-5, -5, 0}, {25, 25, 10}), cavities),
               {},
               900 - 200},
           Row{"two boxes that share a wall", together(box, models::box({10, 0, 0}, {20, 10, 10})), {}, 200},
           Row{"a model three times in one file is one", together(together(box, box), box), {100}, 100},
       }) {
    CAPTURE(row.what);
    const Contours contours = contours_of(row.facets, 5);
    check_clean(contours);
    CHECK(near(signed_area(contours), row.sum));
    if (row.areas.empty()) continue;
    REQUIRE(contours.loops.size() == row.areas.size());
    for (std::size_t i = 0; i < row.areas.size(); ++i)
      CHECK(near(signed_area(contours.points_of(contours.loops[i])), row.areas[i]));
  }
}

TEST_CASE("A T-junction on an upright edge is one closed loop at all heights") {
  models::Facets facets = models::box({0, 0, 0}, {10, 10, 10});
  // The front's facet (0,0,0) (10,0,0) (10,0,10) becomes two that meet at (10,0,5); the neighbours do not
  // have this vertex.
  std::erase_if(facets, [](const Facet& f) {
    return std::ranges::all_of(f.vertices, [](const Vertex& v) { return v.y == 0; }) &&
           std::ranges::count(f.vertices, Vertex{10, 0, 0}) == 1;
  });
  REQUIRE(facets.size() == 11);
  facets.push_back({{Vertex{0, 0, 0}, Vertex{10, 0, 0}, Vertex{10, 0, 5}}});
  facets.push_back({{Vertex{0, 0, 0}, Vertex{10, 0, 5}, Vertex{10, 0, 10}}});
  for (const double z : {0.0, 2.0, 5.0, 7.0}) {
    CAPTURE(z);
    const Contours contours = contours_of(facets, z);
    CHECK(contours.loops.size() == 1);
    check_clean(contours);
    CHECK(near(signed_area(contours), 100));
  }
}

TEST_CASE("A T-junction on a slanted edge is closed if the rounded points miss each other") {
  // A pyramid; one of its slanted edges has a vertex in the middle that belongs to only one of its two
  // facets.
  const Vertex a{0, 0, 0}, b{10, 0, 0}, c{10, 10, 0}, d{0, 10, 0}, top{3.3F, 4.7F, 9.1F};
  const Vertex on_edge{b.x + (top.x - b.x) / 3, b.y + (top.y - b.y) / 3, b.z + (top.z - b.z) / 3};
  const models::Facets facets{{{a, d, c}},   {{a, c, b}},   {{a, b, on_edge}}, {{a, on_edge, top}},
                              {{b, c, top}}, {{c, d, top}}, {{d, a, top}}};
  for (const double z : {0.5, 1.7, 3.0, 4.0, 8.0}) {
    CAPTURE(z);
    const Contours contours = contours_of(facets, z);
    CHECK(contours.loops.size() == 1);
    CHECK(contours.cracks.open_chains == 0);
    CHECK(contours.repaired_loops == 0);
    // A float's rounding at 10 mm is 1e-6 mm.
    CHECK(contours.cracks.widest_gap < Millimeters{2e-6});
  }
}

TEST_CASE("A missing facet leaves one open chain that is closed and reported") {
  models::Facets facets = models::box({0, 0, 0}, {10, 10, 10});
  const auto front = std::ranges::find_if(facets, [](const Facet& f) {
    return std::ranges::all_of(f.vertices, [](const Vertex& v) { return v.y == 0; });
  });
  facets.erase(front);
  const Contours contours = contours_of(facets, 5);
  CHECK(contours.loops.size() == 1);
  CHECK(contours.cracks.open_chains == 1);
  CHECK(contours.repaired_loops == 1);
  CHECK(contours.closed_loops() == 0);
  CHECK(contours.cracks.gaps_closed == 0);
  // The front's diagonal halves it.
  CHECK(near(contours.cracks.widest_gap.count(), 5));
  CHECK(near(signed_area(contours), 100));
}

TEST_CASE("An intact part beside a broken one does not count as repaired") {
  models::Facets broken = models::box({20, 0, 0}, {30, 10, 10});
  std::erase_if(broken, [](const Facet& f) {
    return std::ranges::all_of(f.vertices, [](const Vertex& v) { return v.y == 0; });
  });
  const Contours contours = contours_of(together(broken, models::box({0, 0, 0}, {10, 10, 10})), 5);
  CHECK(contours.loops.size() == 2);
  CHECK(contours.cracks.open_chains == 1);
  CHECK(contours.repaired_loops == 1);
  CHECK(contours.closed_loops() == 1);
  CHECK(near(signed_area(contours), 200));
}

TEST_CASE(
    "A crack of a micrometre is two gaps that close within a pixel, a wider one is reported as a guess") {
  for (const bool wide : {false, true}) {
    CAPTURE(wide);
    const Contours contours = contours_of(cracked_box(wide ? 0.2F : 0.001F), 5);
    CHECK(contours.loops.size() == 1);
    CHECK(contours.cracks.open_chains == (wide ? 2 : 0));
    CHECK(contours.repaired_loops == (wide ? 1 : 0));
    CHECK(contours.closed_loops() == (wide ? 0 : 1));
    CHECK(contours.cracks.gaps_closed == (wide ? 0 : 2));
    // Half the crack at half the height; 1e-6 mm for the float's rounding.
    CHECK(near(contours.cracks.widest_gap.count(), wide ? 0.1 : 0.0005, 1e-6));
    CHECK(near(signed_area(contours), wide ? 101 : 100.005, 1e-5));
  }
}

TEST_CASE("A turned facet changes nothing but the report") {
  const models::Facets whole = models::box({0, 0, 0}, {10, 10, 10});
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CAPTURE(i);
    models::Facets facets = whole;
    std::swap(facets[i].vertices[0], facets[i].vertices[1]);
    const Contours contours = linked(testing::segments_as_filed(facets, 5));
    CHECK(contours.loops.size() == 1);
    CHECK(contours.cracks.open_chains == 0);
    // The bottom and the top are not crossed; each facet of the sides is one chain.
    const auto& v = whole[i].vertices;
    const bool level = v[0].z == v[1].z && v[1].z == v[2].z;
    CHECK(contours.cracks.turned_chains == (level ? 0 : 1));
    CHECK(near(signed_area(contours), 100));
  }
}

TEST_CASE("Turned facets anywhere bridge no gap") {
  // 328 mm2 in the shape of a U.
  const std::vector<Point> outline{{0, 0}, {20, 0}, {20, 20}, {13, 20}, {13, 8}, {7, 8}, {7, 20}, {0, 20}};
  const std::size_t walls = outline.size();
  for (unsigned turned = 1; turned < (1U << walls); ++turned) {
    CAPTURE(turned);
    std::vector<Segment> segments;
    for (std::size_t i = 0; i < walls; ++i) {
      const Point &a = outline[i], &b = outline[(i + 1) % walls], c{(a.x + b.x) / 2, (a.y + b.y) / 2};
      // Two facets a wall.
      const bool back = (turned >> i & 1U) != 0;
      segments.push_back(back ? Segment{c, a} : Segment{a, c});
      segments.push_back(back ? Segment{b, c} : Segment{c, b});
    }
    const Contours contours = linked(segments);
    CHECK(contours.loops.size() == 1);
    CHECK(near(std::fabs(signed_area(contours)), 328));
    CHECK(contours.cracks.open_chains == 0);
    CHECK(contours.cracks.widest_gap == Millimeters{0});
  }
}

TEST_CASE("A few turned facets of a gyroid leave its sections as they are", "[long]") {
  const models::Facets whole = models::gyroid_sphere(8, 5, 30);
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    models::Dice dice(seed);
    models::Facets facets = whole;
    models::turn_facets(facets, 0.03, dice);
    const double z = dice.between(1, 15);
    CAPTURE(seed, z);
    const Contours contours = linked(testing::segments_as_filed(facets, z));
    CHECK(contours.cracks.turned_chains > 0);
    CHECK(contours.cracks.open_chains == 0);
    CHECK(contours.cracks.gaps_closed == 0);
    CHECK(contours.cracks.widest_gap == Millimeters{0});
    CHECK(near(signed_area(contours), signed_area(contours_of(whole, z))));
  }
}

TEST_CASE("An inside-out model has the same loops as the right way out") {
  const Contours contours = contours_of(inverted(models::box({0, 0, 0}, {10, 10, 10})), 5);
  CHECK(contours.loops.size() == 1);
  check_clean(contours);
  CHECK(near(signed_area(contours), 100));
}

TEST_CASE("A doubled facet is dropped") {
  const models::Facets whole = models::sphere(10, 8);
  const double area = signed_area(contours_of(whole, 1.23));
  for (std::size_t i = 0; i < whole.size(); i += 7) {
    const Contours contours = contours_of(together(whole, {whole[i]}), 1.23);
    CHECK(contours.loops.size() == 1);
    check_clean(contours);
    CHECK(near(signed_area(contours), area));
  }
}

TEST_CASE("A doubled facet is dropped where a missing one keeps the repair from seeing it") {
  models::Facets facets =
      together(models::box({0, 0, 0}, {10, 10, 10}), models::box({10, 0, 0}, {20, 10, 10}));
  // The first box lacks half of its floor; the second has a facet of the wall between them twice.
  const std::array missing{Vertex{0, 0, 0}, Vertex{10, 10, 0}, Vertex{10, 0, 0}};
  std::erase_if(facets, [&missing](const Facet& f) { return f.vertices == missing; });
  REQUIRE(facets.size() == 23);
  facets.push_back({{Vertex{10, 0, 0}, Vertex{10, 10, 10}, Vertex{10, 10, 0}}});
  for (const double z : {0.1, 3.3, 7.7}) {
    CAPTURE(z);
    const Contours contours = contours_of(facets, z);
    check_clean(contours);
    CHECK(contours.loops.size() == 2);
    CHECK(near(signed_area(contours), 200));
  }
}

TEST_CASE("A closed mesh's loops consist of exactly its segments") {
  CHECK(rc::check([] {
    const HeightIndex model(testing::draw_blobs(8));
    Section section;
    slice_at(model, Millimeters{testing::draw_real(model.bounds().min_z, model.bounds().max_z)}, section);
    const Contours contours = linked(section.segments);
    RC_ASSERT(contours.cracks.open_chains == 0U);
    RC_ASSERT(contours.cracks.gaps_closed == 0U);
    RC_ASSERT(loops_share_out_the_points(contours));
    RC_ASSERT(sides_of(contours) == sides_of(section.segments));
    RC_ASSERT(section.segments.empty() || signed_area(contours) > 0.0);
  }));
}

TEST_CASE("The loops do not depend on the order of the segments") {
  CHECK(rc::check([] {
    const HeightIndex model(models::gyroid_sphere(10, 6, 12));
    Section section;
    slice_at(model, Millimeters{testing::draw_real(1, 19)}, section);
    const Contours contours = linked(section.segments);
    for (std::size_t i = section.segments.size(); i > 1; --i) {
      const auto other = static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(i) - 1));
      std::swap(section.segments[i - 1], section.segments[other]);
    }
    const Contours shuffled = linked(section.segments);
    RC_ASSERT(shuffled.loops.size() == contours.loops.size());
    RC_ASSERT(sides_of(shuffled) == sides_of(contours));
  }));
}

TEST_CASE("A soup of open segments becomes closed loops through all their points") {
  std::uint64_t random = 1;
  const auto next = [&random] {
    random = random * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(random >> 40) / 1e5;  // 0 to 168 mm
  };
  for (const std::size_t count : {1U, 2U, 3U, 40U, 500U, 600U, 20'000U}) {
    CAPTURE(count);
    std::vector<Segment> segments(count);
    for (Segment& s : segments)
      s = {{next(), next()}, {next(), next()}};
    const Contours contours = linked(segments);
    CHECK(loops_share_out_the_points(contours));
    CHECK(contours.points.size() == 2 * count);
    CHECK(contours.cracks.open_chains > 0);
    std::set<std::pair<double, double>> points;
    for (const Point& p : contours.points)
      points.insert({p.x, p.y});
    CHECK(std::ranges::all_of(segments, [&points](const Segment& s) {
      return points.contains({s.from.x, s.from.y}) && points.contains({s.to.x, s.to.y});
    }));
  }
}

TEST_CASE("A soup of segments between few points becomes closed loops") {
  CHECK(rc::check([] {
    const std::vector<Segment> segments = soup_between_few_points();
    const Contours contours = linked(segments);
    RC_ASSERT(loops_share_out_the_points(contours));
    RC_ASSERT(contours.repaired_loops <= contours.loops.size());
    // Each side of a loop is a segment, or one of the reported joins (walked either way).
    std::size_t strange = 0;
    const std::multiset<Side> given = sides_of(segments);
    for (const auto& [from, to] : sides_of(contours)) {
      if (from != to && !given.contains({from, to}) && !given.contains({to, from})) ++strange;
    }
    RC_ASSERT(strange == 0U || contours.cracks.open_chains > 0U);
  }));
}

TEST_CASE("Closing only the open chains gives the same sides as linking everything") {
  const auto closed = [](std::vector<Segment> segments) {
    Contours contours;
    MaskBudget unlimited;
    ContourLinker().close_open_chains(segments, kPixel, contours, unlimited);
    std::multiset<Side> sides = sides_of(contours);
    sides.merge(sides_of(segments));
    return std::pair{std::move(sides), contours.cracks};
  };
  SECTION("a damaged model") {
    models::Dice dice(4);
    models::Facets facets = models::gyroid_sphere(8, 5, 20);
    const models::Facets again(facets.begin(), facets.begin() + 40);
    models::drop_facets(facets, 0.01, dice);
    models::split_sides(facets, 0.05, 0.02, dice);
    const Section section = testing::section_of(together(facets, again), 4.1);
    REQUIRE(!section.balanced);
    const Contours all = linked(section.segments);
    CHECK(all.cracks.gaps_closed + all.cracks.open_chains > 2);
    CHECK(all.loops.size() > 2);
    const auto [sides, cracks] = closed(section.segments);
    CHECK(sides == sides_of(all));
    CHECK(cracks == all.cracks);
  }
  SECTION("a soup between few points") {
    CHECK(rc::check([&closed] {
      const std::vector<Segment> segments = soup_between_few_points();
      const Contours all = linked(segments);
      const auto [sides, cracks] = closed(segments);
      RC_ASSERT(sides == sides_of(all));
      RC_ASSERT(cracks == all.cracks);
    }));
  }
  SECTION("no segments") {
    CHECK(closed({}).first.empty());
  }
}

TEST_CASE("No segments give no loops") {
  const Contours contours = linked({});
  CHECK(contours.loops.empty());
  CHECK(contours.points.empty());
  check_clean(contours);
  CHECK(perimeter_mm(contours) == 0.0);
}

TEST_CASE("A linker keeps nothing of the previous section") {
  ContourLinker linker;
  Contours contours;
  linker.link(testing::section_of({models::box({0, 0, 0}, {1, 1, 1})[4]}, 0.5).segments, kPixel, contours);
  CHECK(contours.cracks.open_chains == 1);
  linker.link(testing::section_of(models::box({0, 0, 0}, {10, 10, 10}), 5).segments, kPixel, contours);
  CHECK(contours.loops.size() == 1);
  check_clean(contours);
  CHECK(near(signed_area(contours), 100));
}
