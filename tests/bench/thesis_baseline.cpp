#include "tests/bench/thesis_baseline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace contourd::bench {

ThesisSlicer::ThesisSlicer(std::span<const Facet> facets, std::uint16_t display_width,
                           std::uint16_t display_height)
    : bounds_(bounds_of(facets)) {
  facets_.reserve(facets.size());
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.vertices;
    facets_.push_back({facet, std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z})});
  }
  const double device = static_cast<double>(display_width) / display_height;  // equation 3.6
  const double object = bounds_.size_x() / bounds_.size_y();                  // equation 3.7
  const bool to_width = object >= device;
  const double r = (to_width ? display_width : display_height) - 1.0;  // equation 3.8
  scale_x_ = to_width ? r : r * object;                                // equation 3.16: V
  scale_y_ = to_width ? r / object : r;                                // equation 3.17: W
}

const std::vector<ThesisLine>& ThesisSlicer::contours_at(float z) {
  collect_intersecting(z);
  slice(z);
  // Section 3.4: "first sorted by P_o.Y value then P_o.X value".
  std::sort(lines_.begin(), lines_.end(), [](const ThesisLine& a, const ThesisLine& b) {
    return std::pair(a.from.y, a.from.x) < std::pair(b.from.y, b.from.x);
  });
  join();
  return lines_;
}

// Algorithm 1, step 1.
void ThesisSlicer::collect_intersecting(float z) {
  intersecting_.clear();
  for (const StoredFacet& facet : facets_) {
    if (facet.min_z <= z && z <= facet.max_z) intersecting_.push_back(&facet);
  }
}

// Algorithm 1, steps 2 to 14.
void ThesisSlicer::slice(float z) {
  lines_.clear();
  for (const StoredFacet* stored : intersecting_) {
    const auto& v = stored->facet.vertices;
    handle_case({cut_side(v[0], v[1], z), cut_side(v[1], v[2], z), cut_side(v[2], v[0], z)});
  }
}

// Equations 3.1 and 3.5 with n = (0, 0, 1). A side in the plane (n . u = 0) is not cut.
ThesisSlicer::Cut ThesisSlicer::cut_side(const Vertex& start, const Vertex& end, float z) {
  const double rise = static_cast<double>(end.z) - start.z;
  if (rise == 0) return {};
  const double s = (static_cast<double>(z) - start.z) / rise;
  if (s < 0 || s > 1) return {};
  return {{start.x + s * (static_cast<double>(end.x) - start.x),
           start.y + s * (static_cast<double>(end.y) - start.y)},
          true};
}

// Table 3.1 by the number of points. None: the facet lies in the plane (VI). Two: the plane passes through
// two sides (I, III), or twice through the same vertex (V), which is no line. Three: it passes through a
// vertex and a side (II), two points coincide, and the longest line counts.
void ThesisSlicer::handle_case(const Cut (&cuts)[3]) {
  const auto length = [](const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y); };
  double longest = -1;
  std::pair<Point, Point> line;
  for (int k = 0; k < 3; ++k) {
    const Cut &a = cuts[k], &b = cuts[(k + 1) % 3];
    if (!a.exists || !b.exists || length(a.point, b.point) <= longest) continue;
    longest = length(a.point, b.point);
    line = {a.point, b.point};
  }
  if (longest < 0) return;
  const ThesisLine mapped{to_pixel(line.first), to_pixel(line.second)};
  if (mapped.from != mapped.to) lines_.push_back(mapped);
}

// Equations 3.18 and 3.19.
ThesisPixel ThesisSlicer::to_pixel(const Point& point) const {
  return {static_cast<std::uint16_t>((point.x - bounds_.min_x) / bounds_.size_x() * scale_x_),
          static_cast<std::uint16_t>((point.y - bounds_.min_y) / bounds_.size_y() * scale_y_)};
}

// Algorithm 2.
void ThesisSlicer::join() {
  if (lines_.empty()) return;
  std::uint32_t loop = 0;
  ThesisPixel init = lines_[0].from;
  for (std::size_t i = 0; i + 1 < lines_.size(); ++i) {
    ThesisLine& next = lines_[i + 1];
    const ThesisPixel wanted = lines_[i].to;
    if (wanted == init) {
      ++loop;
      init = next.from;
    } else if (const std::size_t found = find(i + 1, wanted); found < lines_.size()) {
      const bool inverted = lines_[found].to == wanted;
      std::swap(lines_[found], next);
      if (inverted) std::swap(next.from, next.to);
    }
    next.loop = loop;
  }
}

// Returns the first line at or after `first` that starts or ends in the point; the number of lines if there
// is none.
std::size_t ThesisSlicer::find(std::size_t first, const ThesisPixel& point) const {
  std::size_t i = first;
  while (i < lines_.size() && lines_[i].from != point && lines_[i].to != point)
    ++i;
  return i;
}

}  // namespace contourd::bench
