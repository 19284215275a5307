#include "core/contour_engine.hpp"

#include <utility>

namespace contourd {

ContourEngine::ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                             std::vector<PixelMap> copies)
    : model_(std::move(model)),
      copies_(std::move(copies)),
      join_tolerance_(to_millimeters(display.pixel_pitch)),
      rasterizer_(display.width, display.height, anti_aliasing),
      mask_(display.width, display.height) {}

double ContourEngine::z_of(Nanometers height) const {
  return model_.bounds().min_z + to_millimeters(height).count();
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  return mask_at_z(Millimeters{z_of(height)});
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  slice_at(model_, z.count(), section_);
  if (!section_.balanced) linker_.link(section_.segments, join_tolerance_, contours_);
  for (const PixelMap& copy : copies_) {
    if (section_.balanced) {
      // The segments close by themselves, in whatever order they come.
      for (const Segment& segment : section_.segments) {
        rasterizer_.add_side(copy.to_pixels(segment.from), copy.to_pixels(segment.to));
      }
      continue;
    }
    for (const ContourLoop& loop : contours_.loops) {
      const std::span<const Point> points = contours_.points_of(loop);
      PixelPoint last = copy.to_pixels(points.back());
      for (const Point& point : points) {
        const PixelPoint next = copy.to_pixels(point);
        rasterizer_.add_side(last, next);
        last = next;
      }
    }
  }
  rasterizer_.paint(mask_);
  return mask_;
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  slice_at(model_, z_of(height), section_);
  linker_.link(section_.segments, join_tolerance_, contours_);
  return contours_;
}

}  // namespace contourd
