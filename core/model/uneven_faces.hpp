// Flat faces that the rounding of coordinates, in the file or by a turn of the model, has made uneven: the
// vertices of one face differ in height by a few steps of a float. A cut between these heights would give
// scraps of the face; instead, it is moved to the highest of them. So a whole face counts as below a cut that
// meets it, as a vertex at exactly the height of a cut does. Immutable; any number of threads may call it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

class UnevenFaces {
 public:
  // Collects the heights of the facets that are level within the rounding of coordinates in `bounds`.
  class Collector {
   public:
    explicit Collector(const Bounds& bounds);
    // Returns the height up to which a facet may be level.
    [[nodiscard]] float rounding_mm() const { return rounding_mm_; }
    void add(const Facet& facet, HeightRange heights) {
      if (heights.high - heights.low <= rounding_mm_ && heights != last_) add_level(facet, heights);
    }
    [[nodiscard]] UnevenFaces take();

   private:
    void add_level(const Facet& facet, HeightRange heights);

    float rounding_mm_;
    HeightRange last_;
    std::vector<HeightRange> levels_{};
  };

  // Returns the height at which to cut instead of z.
  [[nodiscard]] double cut_at(double z) const { return faces_.empty() ? z : moved(z); }
  // Returns the height from which on cuts are moved to `top` or above, which is `top` itself unless an uneven
  // face ends there.
  [[nodiscard]] double below(double top) const {
    return !faces_.empty() && faces_.back().high == top ? faces_.back().low : top;
  }

 private:
  [[nodiscard]] double moved(double z) const;

  std::vector<HeightRange> faces_{};  // from low to high; apart from each other
};

}  // namespace contourd
