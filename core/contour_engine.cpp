#include "core/contour_engine.hpp"

#include <stdexcept>
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
  all.cracks += more.cracks;
  all.repaired_loops += more.repaired_loops;
}

}  // namespace

ContourEngine::ContourEngine(std::vector<PlateModel> models, const EngineSettings& settings)
    : models_(std::move(models)),
      join_tolerance_(to_millimeters(settings.display.pixel_pitch)),
      compensation_(settings.compensation),
      correction_(settings.tone, settings.lamp),
      rasterizer_(settings.display.width, settings.display.height, settings.anti_aliasing) {
  const Mask& mask = rasterizer_.mask();
  if (settings.lamp && (settings.lamp->width() != mask.width() || settings.lamp->height() != mask.height())) {
    throw std::invalid_argument("the lamp's mask is not as large as the display");
  }
  if (!correction_.is_none()) corrected_.emplace(mask.width(), mask.height());
}

ContourEngine::ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies)
    : ContourEngine({PlateModel{std::make_shared<const HeightIndex>(std::move(model)), std::move(copies)}},
                    settings) {}

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
  cracks_ += contours_.cracks;
}

void ContourEngine::add_to_mask(const PlateModel& plate_model, double z) {
  const HeightIndex& model = *plate_model.model;
  slice(model, z);
  const auto height = to_nanometers(Millimeters{z - model.bounds().min_z});
  const Millimeters offset = height ? to_millimeters(compensation_.offset_at(*height)) : Millimeters{};
  if (offset != Millimeters{}) {
    link();
    offset_.offset(contours_, offset, moved_);
    for (const PixelMap& copy : plate_model.copies)
      rasterizer_.add_loops(moved_, copy);
    return;
  }
  // Balanced segments close by themselves, in whatever order they come.
  const bool open = !section_.balanced;
  if (open) {
    MaskBudget unlimited;
    linker_.close_open_chains(section_.segments, join_tolerance_, contours_, unlimited);
    cracks_ += contours_.cracks;
  }
  for (const PixelMap& copy : plate_model.copies) {
    rasterizer_.add_segments(section_.segments, copy);
    if (open) rasterizer_.add_loops(contours_, copy);
  }
}

const Mask& ContourEngine::paint() {
  const Mask& coverage = rasterizer_.paint();
  if (!corrected_) return coverage;
  correction_.apply(coverage, *corrected_);
  return *corrected_;
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  begin_section();
  for (const PlateModel& each : models_)
    add_to_mask(each, z_of(*each.model, height));
  return paint();
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  begin_section();
  add_to_mask(models_.front(), z.count());
  return paint();
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section();
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.cracks = LayerCracks{};
  plate_contours_.repaired_loops = 0;
  for (const PlateModel& each : models_) {
    slice(*each.model, z_of(*each.model, height));
    link();
    append(contours_, plate_contours_);
  }
  return plate_contours_;
}

}  // namespace contourd
