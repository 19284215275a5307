// Fixture of the contour tests: a model's section and its loops in one call.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/slicer.hpp"
#include "core/model/height_index.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// A pixel of the default display.
inline constexpr Millimeters kPixel{0.05};

inline Section section_of(models::Facets facets, double z) {
  Section section;
  slice_at(HeightIndex(std::move(facets)), Millimeters{z}, section);
  return section;
}

inline Contours contours_of(models::Facets facets, double z) {
  Contours contours;
  ContourLinker().link(section_of(std::move(facets), z).segments, kPixel, contours);
  return contours;
}

// Returns the facets' segments as they are in the file: cut one by one, no facet can be repaired to match its
// neighbours.
inline std::vector<Segment> segments_as_filed(const models::Facets& facets, double z) {
  std::vector<Segment> segments;
  for (const Facet& facet : facets) {
    const Section section = section_of({facet}, z);
    segments.insert(segments.end(), section.segments.begin(), section.segments.end());
  }
  return segments;
}

// Returns the loop's area, positive if it runs counter-clockwise.
inline double signed_area(std::span<const Point> points) {
  double twice = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& a = points[i];
    const Point& b = points[(i + 1) % points.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return twice / 2;
}

inline double signed_area(const Contours& contours) {
  double sum = 0;
  for (const ContourLoop& loop : contours.loops)
    sum += signed_area(contours.points_of(loop));
  return sum;
}

}  // namespace contourd::testing
