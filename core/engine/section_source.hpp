// What is exposed beside the models: sections of its own, such as those of supports. The engine lays them as
// a second plane that knows nothing of the models' and that theirs know nothing of; the mask is the union of
// the two.
#pragma once

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
  // from above. Outer loops run counter-clockwise, holes clockwise. Loops may overlap, but none may wind
  // around a point a negative number of times. Thread-safe; allocates only while contours grow.
  virtual void section_at(Nanometers height, Contours& contours) const = 0;
};

}  // namespace contourd
