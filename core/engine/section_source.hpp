// A source of sections that are exposed beside the models, such as those of supports. The engine paints them
// as a second plane, independent of the models' plane; a pixel of the mask has the greater value of the two.
// In the second plane a pixel is lit fully or not at all, by its centre: thin parts cure to their size only
// if their rim gets the full light, and the rim's area is right on average.
#pragma once

#include <vector>

#include "core/contour/conic_cut.hpp"
#include "core/contour/contour_loops.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

class SectionSource {
 public:
  SectionSource() = default;
  SectionSource(const SectionSource&) = delete;
  SectionSource& operator=(const SectionSource&) = delete;
  virtual ~SectionSource() = default;

  // Replaces `contours` by the section at a height above the plate: millimetres from the plate's centre, seen
  // from above. Each loop is convex and runs counter-clockwise; loops may overlap, and the area inside any of
  // them is exposed. Thread-safe; allocates only while contours grow.
  virtual void section_at(Nanometers height, Contours& contours) const = 0;

  // Replaces `conics` by the section as conics, which are exposed without a polygon's error and in a fraction
  // of its time. False if the source has none; then its loops are used.
  [[nodiscard]] virtual bool conics_at(Nanometers height, std::vector<ConicCut>& conics) const {
    (void)height, (void)conics;
    return false;
  }
};

}  // namespace contourd
