#include "core/engine/contour_engine.hpp"

#include <stdexcept>
#include <utility>

namespace contourd {
namespace {

// The models stand on the plate: height 0 is each one's lowest point.
double z_of(const HeightIndex& model, Nanometers height) {
  return model.bounds().min_z + to_millimeters(height).count();
}

// Of a mask that may take as long as it likes.
const Mask& sound(const Mask* mask) {
  if (mask == nullptr) throw std::length_error("the section crosses itself in too many places");
  return *mask;
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

void ContourEngine::link(MaskBudget& budget) {
  linker_.link(section_.segments, join_tolerance_, contours_, budget);
  cracks_ += contours_.cracks;
}

bool ContourEngine::add_to_mask(const PlateModel& plate_model, double z, MaskBudget& budget) {
  const HeightIndex& model = *plate_model.model;
  slice(model, z);
  if (!budget.spend(section_.segments.size()) || !budget.can_hold(section_.segments.size())) return false;
  const auto height = to_nanometers(Millimeters{z - model.bounds().min_z});
  const Millimeters offset = height ? to_millimeters(compensation_.offset_at(*height)) : Millimeters{};
  if (offset != Millimeters{}) {
    link(budget);
    if (!budget.look_at_the_clock()) return false;
    if (!offset_.offset(contours_, offset, moved_, budget)) return false;
    for (const PixelMap& copy : plate_model.copies)
      rasterizer_.add_loops(moved_, copy);
    return true;
  }
  // Balanced segments close by themselves, in whatever order they come.
  const bool open = !section_.balanced;
  if (open) {
    linker_.close_open_chains(section_.segments, join_tolerance_, contours_, budget);
    if (!budget.look_at_the_clock()) return false;
    cracks_ += contours_.cracks;
  }
  for (const PixelMap& copy : plate_model.copies) {
    rasterizer_.add_segments(section_.segments, copy);
    if (open) rasterizer_.add_loops(contours_, copy);
  }
  return true;
}

const Mask* ContourEngine::paint(MaskBudget& budget) {
  if (!rasterizer_.paint(budget)) return nullptr;
  if (!corrected_) return &rasterizer_.mask();
  correction_.apply(rasterizer_.mask(), *corrected_);
  return &*corrected_;
}

const Mask* ContourEngine::mask_within(Nanometers height, MaskBudget& budget) {
  begin_section();
  for (const PlateModel& each : models_) {
    if (add_to_mask(each, z_of(*each.model, height), budget)) continue;
    rasterizer_.clear();
    return nullptr;
  }
  return paint(budget);
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  MaskBudget unlimited;
  return sound(mask_within(height, unlimited));
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  MaskBudget unlimited;
  begin_section();
  if (add_to_mask(models_.front(), z.count(), unlimited)) return sound(paint(unlimited));
  rasterizer_.clear();
  return sound(nullptr);
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section();
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.cracks = LayerCracks{};
  plate_contours_.repaired_loops = 0;
  MaskBudget unlimited;
  for (const PlateModel& each : models_) {
    slice(*each.model, z_of(*each.model, height));
    link(unlimited);
    append(contours_, plate_contours_);
  }
  return plate_contours_;
}

}  // namespace contourd
