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
      rasterizer_(display.width, display.height, anti_aliasing),
      mask_(display.width, display.height) {}

ContourEngine::ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                             std::vector<PixelMap> copies)
    : ContourEngine({PlateModel{std::make_shared<const HeightIndex>(std::move(model)), std::move(copies)}},
                    display, anti_aliasing) {}

void ContourEngine::slice(const HeightIndex& model, double z) {
  slice_at(model, z, section_);
  intersecting_facets_ += section_.intersecting_facets;
}

void ContourEngine::add_to_mask(const PlateModel& plate_model, double z) {
  slice(*plate_model.model, z);
  if (!section_.balanced) linker_.link(section_.segments, join_tolerance_, contours_);
  for (const PixelMap& copy : plate_model.copies) {
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
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  intersecting_facets_ = 0;
  for (const PlateModel& each : models_)
    add_to_mask(each, z_of(*each.model, height));
  rasterizer_.paint(mask_);
  return mask_;
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  intersecting_facets_ = 0;
  add_to_mask(models_.front(), z.count());
  rasterizer_.paint(mask_);
  return mask_;
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  intersecting_facets_ = 0;
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.open_chains = plate_contours_.gaps_closed = plate_contours_.repaired_loops = 0;
  plate_contours_.widest_gap = Millimeters{};
  for (const PlateModel& each : models_) {
    slice(*each.model, z_of(*each.model, height));
    linker_.link(section_.segments, join_tolerance_, contours_);
    append(contours_, plate_contours_);
  }
  return plate_contours_;
}

}  // namespace contourd
