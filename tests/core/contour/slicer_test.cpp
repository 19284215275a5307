#include "core/contour/slicer.hpp"

#include "core/geometry/point_hash.hpp"
#include "core/model/placement.hpp"
#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/random_shapes.hpp"

namespace {

// True if as many segments start as end at every point, by counting.
bool closes(const Section& section) {
  std::map<std::pair<double, double>, int> starts_minus_ends;
  for (const Segment& s : section.segments) {
    ++starts_minus_ends[{s.from.x, s.from.y}];
    --starts_minus_ends[{s.to.x, s.to.y}];
  }
  return std::ranges::all_of(starts_minus_ends, [](const auto& entry) { return entry.second == 0; });
}

std::set<double> vertex_heights(const models::Facets& facets) {
  std::set<double> heights;
  for (const Facet& facet : facets) {
    for (const Vertex& v : facet.vertices)
      heights.insert(v.z);
  }
  return heights;
}

struct Case {
  std::string name;
  Facet facet;
  std::uint32_t intersecting;
  std::vector<Segment> segments;
};

bool same(const std::vector<Segment>& a, const std::vector<Segment>& b) {
  return std::ranges::equal(
      a, b, [](const Segment& s, const Segment& t) { return s.from == t.from && s.to == t.to; });
}

}  // namespace

// All facets are cut at z = 1, lie roughly in the plane y = x / 2, and face -y where they are upright: their
// inside is at larger y, on the left of a segment that runs towards larger x.
TEST_CASE("The thesis's six cases of a facet and a plane leave one segment or none") {
  const std::vector<Case> cases{
      {"I, the third vertex above",
       {{Vertex{0, 0, 1}, Vertex{4, 2, 1}, Vertex{2, 1, 3}}},
       1,
       {{{0, 0}, {4, 2}}}},
      {"I, the third vertex below", {{Vertex{0, 0, 1}, Vertex{2, 1, 0}, Vertex{4, 2, 1}}}, 0, {}},
      {"II, the vertex left, its side from below",
       {{Vertex{0, 0, 1}, Vertex{4, 2, 0}, Vertex{4, 2, 2}}},
       1,
       {{{0, 0}, {4, 2}}}},
      {"II, the vertex right", {{Vertex{4, 2, 1}, Vertex{0, 0, 2}, Vertex{0, 0, 0}}}, 1, {{{0, 0}, {4, 2}}}},
      {"III, one vertex above",
       {{Vertex{0, 0, 0}, Vertex{4, 2, 0}, Vertex{2, 1, 2}}},
       1,
       {{{1, 0.5}, {3, 1.5}}}},
      {"III, two vertices above",
       {{Vertex{2, 1, 0}, Vertex{4, 2, 2}, Vertex{0, 0, 2}}},
       1,
       {{{1, 0.5}, {3, 1.5}}}},
      {"IV, above", {{Vertex{0, 0, 2}, Vertex{4, 2, 2}, Vertex{2, 1, 3}}}, 0, {}},
      {"IV, below", {{Vertex{0, 0, -2}, Vertex{4, 2, -2}, Vertex{2, 1, 0.5F}}}, 0, {}},
      {"V, touching from below", {{Vertex{0, 0, 0}, Vertex{4, 2, 0}, Vertex{2, 1, 1}}}, 0, {}},
      {"V, touching from above", {{Vertex{2, 1, 1}, Vertex{4, 2, 3}, Vertex{0, 0, 3}}}, 1, {}},
      {"VI, in the plane", {{Vertex{0, 0, 1}, Vertex{4, 0, 1}, Vertex{0, 4, 1}}}, 0, {}},
      {"VI, parallel", {{Vertex{0, 0, 2}, Vertex{4, 0, 2}, Vertex{0, 4, 2}}}, 0, {}},
  };
  for (const Case& c : cases) {
    for (int turn = 0; turn < 3; ++turn) {
      CAPTURE(c.name, turn);
      Facet facet = c.facet;
      std::rotate(facet.vertices.begin(), facet.vertices.begin() + turn, facet.vertices.end());
      // A second facet far away extends the model's height, so that the index returns the first as a
      // candidate in all cases.
      const models::Facets facets{facet, {{Vertex{99, 0, -9}, Vertex{99, 0, -9}, Vertex{99, 0, 9}}}};
      Section section = section_of(facets, 1.0);
      CHECK(section.intersecting_facets == c.intersecting + 1);
      CHECK(same(section.segments, c.segments));
      // The other way round, the segment runs back.
      models::Facets turned{facet, facets[1]};
      models::invert(turned);
      section = section_of(turned, 1.0);
      CHECK(section.intersecting_facets == c.intersecting + 1);
      std::vector<Segment> reversed = c.segments;
      for (Segment& s : reversed)
        std::swap(s.from, s.to);
      CHECK(same(section.segments, reversed));
    }
  }
}

TEST_CASE("Both facets of a side give its cut the very same bits") {
  CHECK(rc::check([] {
    const Vertex p = testing::draw_vertex(300), q = testing::draw_vertex(300);
    RC_PRE(p.z != q.z);
    const Facet one{{p, q, testing::draw_vertex(300)}};
    const Facet other{{testing::draw_vertex(300), q, p}};
    const double low = std::fmin(p.z, q.z), high = std::fmax(p.z, q.z);
    const double z = low + (high - low) * static_cast<double>(testing::draw(0, 999)) / 1000.0;
    const Section a = section_of({one}, z), b = section_of({other}, z);
    // A cut of no length: a third vertex exactly on the plane and on the side.
    RC_PRE(a.segments.size() == 1 && b.segments.size() == 1);
    RC_ASSERT(a.segments[0].to == b.segments[0].from || a.segments[0].from == b.segments[0].to);
  }));
}

TEST_CASE("A side is cut exactly at an end that the plane meets, and otherwise between its ends") {
  CHECK(rc::check([] {
    const Vertex lower = testing::draw_vertex(300);
    Vertex upper = testing::draw_vertex(300);
    upper.z = lower.z + testing::draw_float(0.001, 300);
    RC_PRE(upper.z > lower.z);
    const Point start = intersect_side(lower, upper, lower.z);
    RC_ASSERT(start.x == static_cast<double>(lower.x) && start.y == static_cast<double>(lower.y));
    const double z = lower.z + (static_cast<double>(upper.z) - lower.z) * testing::draw_real(0, 0.999);
    const Point point = intersect_side(lower, upper, z);
    // Two roundings of numbers below 600 mm, each half a unit in the 53rd bit: 1e-13 mm.
    constexpr double kRoundingMm = 2e-13;
    RC_ASSERT(point.x >= std::fmin(lower.x, upper.x) - kRoundingMm);
    RC_ASSERT(point.x <= std::fmax(lower.x, upper.x) + kRoundingMm);
    // Equation 3.4: on the line through both ends.
    const double s = (z - lower.z) / (static_cast<double>(upper.z) - lower.z);
    RC_ASSERT(std::fabs(point.y - ((1 - s) * lower.y + s * upper.y)) <= kRoundingMm);
  }));
}

TEST_CASE("A facet's segment has exactly the ends that its two sides give, and no -0") {
  CHECK(rc::check([] {
    const Facet facet = testing::draw_facet(30);
    const double z = testing::draw_real(-30, 30);
    const Section section = section_of({facet}, z);
    std::vector<Point> ends;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vertex& a = facet.vertices[i];
      const Vertex& b = facet.vertices[(i + 1) % 3];
      if (a.z <= z && b.z > z) ends.push_back(intersect_side(a, b, z));
      if (b.z <= z && a.z > z) ends.push_back(intersect_side(b, a, z));
    }
    const bool cut = ends.size() == 2 && ends[0] != ends[1];
    RC_PRE(cut);
    RC_ASSERT(section.segments.size() == 1U);
    const Segment& segment = section.segments[0];
    RC_ASSERT((segment.from == ends[0] && segment.to == ends[1]) ||
              (segment.from == ends[1] && segment.to == ends[0]));
  }));
  const Vertex zero{-0.0F, -0.0F, 0};
  CHECK(section_of({Facet{{zero, {-1, -1, 1}, {-2, 3, 1}}}}, 0.0).segments.empty());
  const Section along_zero = section_of({Facet{{zero, {-0.0F, 2, 0}, {-2, -3, 1}}}}, 0.0);
  REQUIRE(along_zero.segments.size() == 1);
  for (const Point& end : {along_zero.segments[0].from, along_zero.segments[0].to}) {
    CHECK_FALSE(std::signbit(end.x));
    CHECK_FALSE(std::signbit(end.y));
  }
}

TEST_CASE("A closed mesh's section closes at every height and at every vertex's own") {
  CHECK(rc::check([] {
    models::Facets facets = testing::draw_blobs(8);
    if (testing::draw(0, 1) == 1) {
      orient(facets, {testing::draw_real(0, 360), testing::draw_real(0, 360), testing::draw_real(0, 360),
                      Scale{1.7}});
    }
    const HeightIndex index(facets);
    Section section;
    for (const double z : vertex_heights(facets)) {
      slice_at(index, Millimeters{z}, section);
      RC_ASSERT(section.balanced);
      RC_ASSERT(closes(section));
    }
    for (int i = 0; i < 10; ++i) {
      slice_at(index, Millimeters{testing::draw_real(index.bounds().min_z, index.bounds().max_z)}, section);
      RC_ASSERT(section.balanced);
    }
  }));
}

TEST_CASE(
    "A plane through a box's corners and edges and faces gives closed sections however the box is turned") {
  for (const Orientation& turn :
       {Orientation{}, Orientation{45, 0, 0}, Orientation{0, 45, 0}, Orientation{45, 30, 10}}) {
    models::Facets facets = models::box({0, 0, 0}, {10, 20, 30});
    orient(facets, turn);
    for (const double z : vertex_heights(facets)) {
      CAPTURE(turn.x_deg, turn.y_deg, z);
      const Section section = section_of(facets, z);
      CHECK(section.balanced);
      CHECK(closes(section));
      const Bounds bounds = bounds_of(facets);
      if (z > bounds.min_z) CHECK(section.segments.empty() == (z == bounds.max_z));
    }
  }
}

TEST_CASE("The section is the one just above the plane") {
  const models::Facets box = models::box({0, 0, 0}, {10, 10, 5});
  // The facets around it that touch the bottom at one vertex leave nothing there.
  CHECK(section_of(box, 0.0).segments.size() == 4);
  CHECK(section_of(box, 0.0).balanced);
  CHECK(section_of(box, 0.0).intersecting_facets == 8);
  CHECK(section_of(box, std::nextafter(0.0, -1.0)).segments.empty());
  CHECK(section_of(box, std::nextafter(5.0, 0.0)).segments.size() == 8);
  CHECK(section_of(box, 5.0).segments.empty());
  CHECK(section_of(box, 5.0).intersecting_facets == 0);
  CHECK(section_of(box, 5.0).balanced);
}

TEST_CASE("A section replaces the previous one") {
  const HeightIndex index(models::box({0, 0, 0}, {10, 10, 5}));
  Section section = section_of({models::box({0, 0, 0}, {1, 1, 1})[4]}, 0.5);
  CHECK_FALSE(section.balanced);
  slice_at(index, Millimeters{2.5}, section);
  CHECK(section.segments.size() == 8);
  CHECK(section.balanced);
  slice_at(index, Millimeters{99.0}, section);
  CHECK(section.segments.empty());
  CHECK(section.intersecting_facets == 0);
  CHECK(section.balanced);
}

TEST_CASE("A missing facet unbalances the sections that cross it, a turned or doubled facet does not") {
  const models::Facets whole = models::sphere(10, 10);
  CHECK(rc::check([&] {
    const auto chosen =
        static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(whole.size()) - 1));
    const Bounds bounds = bounds_of(std::span(whole).subspan(chosen, 1));
    const double z = (bounds.min_z + bounds.max_z) / 2;
    RC_PRE(bounds.size_z() > 0.0);
    RC_ASSERT(section_of(whole, z).balanced);
    models::Facets missing = whole;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(chosen));
    RC_ASSERT(!section_of(missing, z).balanced);
    models::Facets turned = whole;
    std::swap(turned[chosen].vertices[0], turned[chosen].vertices[1]);
    RC_ASSERT(section_of(turned, z).balanced);
    models::Facets doubled = whole;
    doubled.push_back(whole[chosen]);
    RC_ASSERT(section_of(doubled, z).balanced);
  }));
}

TEST_CASE("A wall of two facets back to back is balanced") {
  models::Facets wall{{{Vertex{0, 0, 0}, Vertex{4, 0, 0}, Vertex{0, 0, 4}}}};
  wall.push_back(wall[0]);
  std::swap(wall[1].vertices[0], wall[1].vertices[1]);
  const Section section = section_of(wall, 1.0);
  CHECK(section.balanced);
  CHECK(section.segments.size() == 2);
}

TEST_CASE("The inside lies on a segment's left") {
  // Every segment of a box around (5, 5) has that point on its left.
  for (const Segment& s : section_of(models::box({0, 0, 0}, {10, 10, 5}), 2.5).segments) {
    CHECK((s.to.x - s.from.x) * (5 - s.from.y) - (s.to.y - s.from.y) * (5 - s.from.x) > 0);
  }
}

TEST_CASE("Points hash by their bits, and both zeros hash alike") {
  CHECK(hash_of({1.0, 2.0}) == hash_of({1.0, 2.0}));
  CHECK(hash_of({0.0, -0.0}) == hash_of({-0.0, 0.0}));
  CHECK(hash_of({1.0, 2.0}) != hash_of({2.0, 1.0}));
  CHECK(hash_of({1.0, 1.0}) != hash_of({2.0, 2.0}));
  CHECK(hash_of({1.0, 2.0}) != hash_of({std::nextafter(1.0, 2.0), 2.0}));
}
