#include "core/contour_engine.hpp"

#include <utility>

namespace contourd {

ContourEngine::ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                             std::vector<PixelMap> copies)
    : model_(std::move(model)),
      copies_(std::move(copies)),
      join_tolerance_(to_millimeters(display.pixel_pitch)),
      rasterizer_(display.width, display.height, anti_aliasing) {}

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
    // Balanced segments close by themselves, in whatever order they come.
    if (section_.balanced) {
      rasterizer_.add_segments(section_.segments, copy);
    } else {
      rasterizer_.add_loops(contours_, copy);
    }
  }
  return rasterizer_.paint();
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  slice_at(model_, z_of(height), section_);
  linker_.link(section_.segments, join_tolerance_, contours_);
  return contours_;
}

}  // namespace contourd
