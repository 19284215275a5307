#include "core/contour_engine.hpp"

#include <utility>

namespace contourd {
namespace {

double z_of(const HeightIndex& model, Nanometers height) {
  return model.bounds().min_z + to_millimeters(height).count();
}

std::vector<PlateModel> only(HeightIndex model, std::vector<PixelMap> copies) {
  return {{std::make_shared<const HeightIndex>(std::move(model)), std::move(copies)}};
}

}  // namespace

ContourEngine::ContourEngine(std::vector<PlateModel> models, const DisplayGeometry& display,
                             AntiAliasing anti_aliasing)
    : models_(std::move(models)),
      join_tolerance_(to_millimeters(display.pixel_pitch)),
      rasterizer_(display.width, display.height, anti_aliasing) {}

ContourEngine::ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                             std::vector<PixelMap> copies)
    : ContourEngine(only(std::move(model), std::move(copies)), display, anti_aliasing) {}

void ContourEngine::begin_section() {
  intersecting_facets_ = 0;
  cracks_ = LayerCracks{};
}

void ContourEngine::cut(const HeightIndex& model, double z) {
  slice_at(model, z, section_);
  intersecting_facets_ += section_.intersecting_facets;
}

void ContourEngine::link() {
  linker_.link(section_.segments, join_tolerance_, contours_);
  cracks_ += LayerCracks{contours_.gaps_closed, contours_.widest_gap, contours_.open_chains};
}

void ContourEngine::add_sides(const PlateModel& plate_model, double z) {
  cut(*plate_model.model, z);
  if (!section_.balanced) link();
  for (const PixelMap& copy : plate_model.copies) {
    // Balanced segments close by themselves, in whatever order they come.
    if (section_.balanced) {
      rasterizer_.add_segments(section_.segments, copy);
    } else {
      rasterizer_.add_loops(contours_, copy);
    }
  }
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  begin_section();
  for (const PlateModel& each : models_)
    add_sides(each, z_of(*each.model, height));
  return rasterizer_.paint();
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  begin_section();
  for (const PlateModel& each : models_)
    add_sides(each, z.count());
  return rasterizer_.paint();
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section();
  cut(model(), z_of(model(), height));
  link();
  return contours_;
}

}  // namespace contourd
