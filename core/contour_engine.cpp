#include "core/contour_engine.hpp"

#include <stdexcept>
#include <utility>

namespace contourd {

ContourEngine::ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies)
    : model_(std::move(model)),
      copies_(std::move(copies)),
      join_tolerance_(to_millimeters(settings.display.pixel_pitch)),
      compensation_(settings.compensation),
      correction_(settings.tone, settings.lamp),
      rasterizer_(settings.display.width, settings.display.height, settings.anti_aliasing),
      mask_(settings.display.width, settings.display.height) {
  if (settings.lamp &&
      (settings.lamp->width() != mask_.width() || settings.lamp->height() != mask_.height())) {
    throw std::invalid_argument("the lamp's mask is not as large as the display");
  }
  if (!correction_.is_none()) corrected_.emplace(settings.display.width, settings.display.height);
}

double ContourEngine::z_of(Nanometers height) const {
  return model_.bounds().min_z + to_millimeters(height).count();
}

Millimeters ContourEngine::offset_at_z(double z) const {
  const auto height = to_nanometers(Millimeters{z - model_.bounds().min_z});
  return height ? to_millimeters(compensation_.offset_at(*height)) : Millimeters{};
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  return mask_at_z(Millimeters{z_of(height)});
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  slice_at(model_, z.count(), section_);
  const Contours* const contours = contours_to_fill(z.count());
  for (const PixelMap& copy : copies_)
    add_sides(contours, copy);
  rasterizer_.paint(mask_);
  if (!corrected_) return mask_;
  correction_.apply(mask_, *corrected_);
  return *corrected_;
}

const Contours* ContourEngine::contours_to_fill(double z) {
  const Millimeters offset = offset_at_z(z);
  if (offset == Millimeters{} && section_.balanced) return nullptr;
  linker_.link(section_.segments, join_tolerance_, contours_);
  if (offset == Millimeters{}) return &contours_;
  offset_.offset(contours_, offset, moved_);
  return &moved_;
}

void ContourEngine::add_sides(const Contours* contours, const PixelMap& copy) {
  if (contours == nullptr) {
    // The segments close by themselves, in whatever order they come.
    for (const Segment& segment : section_.segments) {
      rasterizer_.add_side(copy.to_pixels(segment.from), copy.to_pixels(segment.to));
    }
    return;
  }
  for (const ContourLoop& loop : contours->loops) {
    const std::span<const Point> points = contours->points_of(loop);
    PixelPoint last = copy.to_pixels(points.back());
    for (const Point& point : points) {
      const PixelPoint next = copy.to_pixels(point);
      rasterizer_.add_side(last, next);
      last = next;
    }
  }
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  slice_at(model_, z_of(height), section_);
  linker_.link(section_.segments, join_tolerance_, contours_);
  return contours_;
}

}  // namespace contourd
