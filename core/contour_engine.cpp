#include "core/contour_engine.hpp"

#include <algorithm>
#include <utility>

namespace contourd {
namespace {

// The models stand on the plate: height 0 is each one's lowest point.
double z_of(const HeightIndex& model, Nanometers height) {
  return model.bounds().min_z + to_millimeters(height).count();
}

void append(const Contours& more, Contours& all) {
  const auto first_point = static_cast<std::uint32_t>(all.points.size());
  all.points.insert(all.points.end(), more.points.begin(), more.points.end());
  for (const ContourLoop& loop : more.loops)
    all.loops.push_back({first_point + loop.first_point, loop.point_count});
  all.open_chains += more.open_chains;
  all.gaps_closed += more.gaps_closed;
  all.repaired_loops += more.repaired_loops;
  all.widest_gap = std::max(all.widest_gap, more.widest_gap);
}

}  // namespace

ContourEngine::ContourEngine(std::vector<PlateModel> models, const DisplayGeometry& display,
                             AntiAliasing anti_aliasing)
    : models_(std::move(models)),
      join_tolerance_(to_millimeters(display.pixel_pitch)),
      rasterizer_(display.width, display.height, anti_aliasing) {}

ContourEngine::ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                             std::vector<PixelMap> copies)
    : ContourEngine({PlateModel{std::make_shared<const HeightIndex>(std::move(model)), std::move(copies)}},
                    display, anti_aliasing) {}

void ContourEngine::begin_section() {
  intersecting_facets_ = 0;
  cracks_ = LayerCracks{};
}

void ContourEngine::slice(const HeightIndex& model, double z) {
  slice_at(model, z, section_);
  intersecting_facets_ += section_.intersecting_facets;
}

void ContourEngine::link() {
  linker_.link(section_.segments, join_tolerance_, contours_);
  cracks_ += LayerCracks{contours_.gaps_closed, contours_.widest_gap, contours_.open_chains};
}

void ContourEngine::add_to_mask(const PlateModel& plate_model, double z) {
  slice(*plate_model.model, z);
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
    add_to_mask(each, z_of(*each.model, height));
  return rasterizer_.paint();
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  begin_section();
  add_to_mask(models_.front(), z.count());
  return rasterizer_.paint();
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section();
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.open_chains = plate_contours_.gaps_closed = plate_contours_.repaired_loops = 0;
  plate_contours_.widest_gap = Millimeters{};
  for (const PlateModel& each : models_) {
    slice(*each.model, z_of(*each.model, height));
    link();
    append(contours_, plate_contours_);
  }
  return plate_contours_;
}

}  // namespace contourd
