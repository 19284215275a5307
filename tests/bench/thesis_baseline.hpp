// The thesis's contour generation, as described in its chapter 3, for comparison: algorithm 1 goes through
// all facets for every plane, distinguishes the six cases of table 3.1 and maps to whole pixels (equations
// 3.6 to 3.19); algorithm 2 finds each line's neighbour by searching the rest of the list. Written from the
// text and plain on purpose, so that its cost is the method's cost. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd::bench {

// A pixel in whole coordinates ("unsigned integer value", section 3.3.3): the fraction is dropped.
struct ThesisPixel {
  std::uint16_t x = 0, y = 0;
  bool operator==(const ThesisPixel&) const = default;
};

struct ThesisLine {
  ThesisPixel from, to;
  std::uint32_t loop = 0;  // number of the contour, set by algorithm 2
};

class ThesisSlicer {
 public:
  // REQUIRES: a model that has width, depth and height; a display of 2 to 65535 pixels a side.
  ThesisSlicer(std::span<const Facet> facets, std::uint16_t display_width, std::uint16_t display_height);

  // Runs both algorithms at z, in the model's own coordinates. Valid until the next call.
  const std::vector<ThesisLine>& contours_at(float z);

  // Returns the number of facets that step 1 of algorithm 1 selected in the last call.
  [[nodiscard]] std::size_t intersecting_facets() const { return intersecting_.size(); }

 private:
  struct StoredFacet {  // section 3.2
    Facet facet;
    float min_z, max_z;
  };
  struct Cut {
    Point point{};
    bool exists = false;
  };

  void collect_intersecting(float z);
  void slice(float z);
  [[nodiscard]] static Cut cut_side(const Vertex& start, const Vertex& end, float z);
  void handle_case(const Cut (&cuts)[3]);
  [[nodiscard]] ThesisPixel to_pixel(const Point& point) const;
  void join();
  [[nodiscard]] std::size_t find(std::size_t first, const ThesisPixel& point) const;

  std::vector<StoredFacet> facets_;
  Bounds bounds_;
  double scale_x_ = 0, scale_y_ = 0;  // pixels at x_max and y_max: R V and R W in equations 3.18 and 3.19
  std::vector<const StoredFacet*> intersecting_;
  std::vector<ThesisLine> lines_;
};

}  // namespace contourd::bench
