#include "tests/bench/thesis_baseline.hpp"

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using bench::ThesisLine;
using bench::ThesisSlicer;

namespace {

constexpr std::uint16_t kWidth = 640, kHeight = 480;

// Area and length of a single loop, in pixels.
struct Outline {
  double area = 0, length = 0;
};

Outline outline_of(const std::vector<ThesisLine>& lines) {
  Outline outline;
  for (const ThesisLine& line : lines) {
    outline.area += (line.from.x * line.to.y - line.to.x * line.from.y) / 2.0;
    outline.length += std::hypot(line.to.x - line.from.x, line.to.y - line.from.y);
  }
  outline.area = std::fabs(outline.area);
  return outline;
}

std::uint32_t loops_of(const std::vector<ThesisLine>& lines) {
  return lines.empty() ? 0 : lines.back().loop + 1;
}

void check_closed_chain(const std::vector<ThesisLine>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i)
    REQUIRE(lines[i].to == lines[(i + 1) % lines.size()].from);
}

void check_area_equals_ours(const models::Facets& facets, float z) {
  ThesisSlicer baseline(facets, kWidth, kHeight);
  const std::vector<ThesisLine>& lines = baseline.contours_at(z);
  check_closed_chain(lines);
  CHECK(loops_of(lines) == 1);

  const DisplayGeometry display{Pixels{kWidth}, Pixels{kHeight}};
  HeightIndex index(facets);
  const PixelMap map = PixelMap::fit(display, index.bounds());
  ContourEngine engine(std::move(index), EngineSettings{display, AntiAliasing::On}, {map});
  const double ours = engine.mask_at_z(Millimeters{z}).lit_area();

  // Each point of the outline lost less than a pixel in x and in y, so the outline has moved by less than a
  // pixel's diagonal.
  const Outline theirs = outline_of(lines);
  CHECK(theirs.area > 0);
  CHECK_THAT(theirs.area, Catch::Matchers::WithinAbs(ours, theirs.length * std::numbers::sqrt2));
}

std::size_t lines_through(const Facet& facet) {
  // A second facet, away from the plane, gives the model its size.
  const models::Facets facets{facet, {{{{0, 0, 5}, {10, 0, 6}, {0, 10, 7}}}}};
  return ThesisSlicer(facets, kWidth, kHeight).contours_at(1).size();
}

}  // namespace

TEST_CASE("The baseline's contour of a cube has the area of our mask") {
  check_area_equals_ours(models::box({0, 0, 0}, {20, 20, 20}), 7);
}

TEST_CASE("The baseline's contour of a ball has the area of our mask") {
  check_area_equals_ours(models::sphere(10, 40), 0.3F);
  check_area_equals_ours(models::sphere(10, 40), -6.1F);
}

TEST_CASE("The baseline separates the contours of two cubes") {
  models::Facets facets = models::box({0, 0, 0}, {20, 20, 20});
  const models::Facets other = models::box({30, 5, 0}, {40, 15, 20});
  facets.insert(facets.end(), other.begin(), other.end());
  CHECK(loops_of(ThesisSlicer(facets, kWidth, kHeight).contours_at(7)) == 2);
}

TEST_CASE("The baseline treats each case of table 3.1 as the thesis says") {
  CHECK(lines_through({{{{0, 0, 1}, {10, 0, 1}, {5, 5, 3}}}}) == 1);  // I: a side in the plane
  CHECK(lines_through({{{{0, 0, 1}, {10, 0, 0}, {5, 5, 3}}}}) == 1);  // II: through a vertex and a side
  CHECK(lines_through({{{{0, 0, 0}, {10, 0, 0}, {5, 5, 3}}}}) == 1);  // III: through two sides
  CHECK(lines_through({{{{0, 0, 2}, {10, 0, 2}, {5, 5, 3}}}}) == 0);  // IV: not at all
  CHECK(lines_through({{{{0, 0, 1}, {10, 0, 2}, {5, 5, 3}}}}) == 0);  // V: in one vertex
  CHECK(lines_through({{{{0, 0, 1}, {10, 0, 1}, {5, 5, 1}}}}) == 0);  // VI: it lies in the plane
}
