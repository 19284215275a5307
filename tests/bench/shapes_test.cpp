#include "tests/bench/shapes.hpp"

#include "core/contour/contour_loops.hpp"
#include "core/contour/filled_area.hpp"
#include "core/contour/slicer.hpp"
#include "tests/catch.hpp"

namespace {

Contours contours_at(const models::Facets& facets, double z, std::size_t expected_segments) {
  Section section;
  slice_at(HeightIndex(facets), Millimeters{z}, section);
  CHECK(section.balanced);
  CHECK(section.segments.size() == expected_segments);
  Contours contours;
  ContourLinker().link(section.segments, Millimeters{0}, contours);
  CHECK(contours.cracks.open_chains == 0);
  return contours;
}

// The area of a regular polygon. Vertices are floats: 7 digits, two coordinates in each product.
double polygon_area(int sides, double radius) {
  return sides * radius * radius * std::sin(2 * std::numbers::pi / sides) / 2;
}

}  // namespace

TEST_CASE("A plane through a prism crosses two facets a side, however many bands it has") {
  for (const int bands : {1, 7, 60}) {
    const models::Facets facets = bench::prism({12, bands, 3, 10}, 1, 2);
    CHECK(facets.size() == static_cast<std::size_t>(2 * 12 * (bands + 1)));
    const Contours contours = contours_at(facets, 4.567, 24);
    CHECK(contours.loops.size() == 1);
    CHECK_THAT(filled_area_mm2(contours), Catch::Matchers::WithinRel(polygon_area(12, 3), 1e-6));
  }
}

TEST_CASE("A field of prisms has a loop and 32 segments for each, none touching another") {
  const Contours contours = contours_at(bench::field_of_prisms(100), 0.3, 3200);
  CHECK(contours.loops.size() == 100);
  CHECK_THAT(filled_area_mm2(contours), Catch::Matchers::WithinRel(100 * polygon_area(16, 0.4), 1e-5));
}

TEST_CASE("A full field lies within its columns and rows") {
  const Bounds bounds = bounds_of(bench::field_of_prisms(bench::kFieldColumns * bench::kFieldRows));
  CHECK(bounds.min_x > 0);
  CHECK(bounds.min_y > 0);
  CHECK(bounds.max_x < bench::kFieldColumns);
  CHECK(bounds.max_y < bench::kFieldRows);
}
