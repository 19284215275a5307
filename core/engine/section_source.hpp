// What is exposed beside the models: sections of its own, such as those of supports. The engine lays them as
// a second plane that knows nothing of the models' and that theirs know nothing of; a pixel of the mask has
// the greater value of the two. In that plane a pixel is lit fully or not at all, by its centre: what is thin
// cures to its size only where its rim gets the full light, and the rim's area is right in the mean.
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
  // from above. Each loop is convex and runs counter-clockwise; they may overlap, and all that is in any of
  // them is exposed. Thread-safe; allocates only while contours grow.
  virtual void section_at(Nanometers height, Contours& contours) const = 0;

  // The same as conics, which are exposed without a polygon's error and in a fraction of its time. False for
  // a source that has none; its loops are what is asked for then.
  [[nodiscard]] virtual bool conics_at(Nanometers height, std::vector<ConicCut>& conics) const {
    (void)height, (void)conics;
    return false;
  }
};

}  // namespace contourd
