#include "core/engine/contour_engine.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace contourd {
namespace {

// Returns the mask of a call without a time limit; throws if it was abandoned.
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

ContourEngine::ContourEngine(std::vector<PlateModel> models, const EngineSettings& settings,
                             std::shared_ptr<const SectionSource> beside)
    : models_(std::move(models)),
      beside_{std::move(beside), PixelMap::true_scale(settings.display, {0, 0})},
      join_tolerance_(to_millimeters(settings.display.pixel_pitch)),
      compensation_(settings.compensation),
      correction_(settings.tone, settings.uniformity),
      sections_(models_.size()),
      holes_(models_.size()),
      rasterizer_(settings.display.width, settings.display.height, settings.anti_aliasing) {
  expects(std::ranges::all_of(models_, [](const PlateModel& each) { return each.model != nullptr; }),
          "no model is null");
  const Mask& mask = rasterizer_.mask();
  if (settings.uniformity &&
      (settings.uniformity->width() != mask.width() || settings.uniformity->height() != mask.height())) {
    throw std::invalid_argument("the uniformity mask does not have the display's size");
  }
  if (!correction_.is_none()) corrected_.emplace(mask.width(), mask.height());
}

ContourEngine::ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies)
    : ContourEngine({PlateModel{{std::make_shared<const HeightIndex>(std::move(model))}, std::move(copies)}},
                    settings) {}

void ContourEngine::begin_section() {
  figures_ = Figures{};
  beside_.conics.clear();
  beside_.contours.points.clear();
  beside_.contours.loops.clear();
}

bool ContourEngine::cut_holes(std::size_t model, Millimeters z, MaskBudget& budget) {
  const auto& source = models_[model].holes;
  if (!source) return true;
  Contours& holes = holes_[model];
  source->section_at(to_nanometers(z).value_or(Nanometers{}), holes);
  return budget.can_hold(holes.points.size()) && budget.spend(holes.points.size());
}

void ContourEngine::slice(std::size_t model, Millimeters z) {
  slice_at(*models_[model].model, z, sections_[model]);
  figures_.intersecting_facets += sections_[model].intersecting_facets;
}

void ContourEngine::link(std::size_t model, MaskBudget& budget) {
  linker_.link(sections_[model].segments, join_tolerance_, contours_, budget);
  sections_[model].segments.clear();
  figures_.loops += static_cast<std::uint32_t>(contours_.loops.size());
  figures_.cracks += contours_.cracks;
}

bool ContourEngine::add_to_mask(std::size_t model, Millimeters z, Millimeters offset, MaskBudget& budget) {
  slice(model, z);
  if (!cut_holes(model, z, budget)) return false;
  Section& section = sections_[model];
  if (!budget.spend(section.segments.size()) || !budget.can_hold(section.segments.size())) return false;
  if (offset != Millimeters{}) {
    link(model, budget);
    return add_moved(models_[model], offset, budget);
  }
  // Balanced segments form closed polygons, in any order.
  const bool open = !section.balanced;
  if (open) {
    linker_.close_open_chains(section.segments, join_tolerance_, contours_, budget);
    if (!budget.look_at_the_clock()) return false;
    figures_.loops += static_cast<std::uint32_t>(contours_.loops.size());
    figures_.cracks += contours_.cracks;
  }
  for (const PixelMap& copy : models_[model].copies) {
    rasterizer_.add_segments(section.segments, copy);
    if (open) rasterizer_.add_loops(contours_, copy);
  }
  return true;
}

bool ContourEngine::add_moved(const PlateModel& model, Millimeters offset, MaskBudget& budget) {
  if (!budget.look_at_the_clock()) return false;
  if (!offset_.offset(contours_, offset, moved_, budget)) return false;
  for (const PixelMap& copy : model.copies)
    rasterizer_.add_loops(moved_, copy);
  return true;
}

bool ContourEngine::cut_beside(Nanometers height, MaskBudget& budget) {
  if (!beside_.source) return true;
  if (!beside_.source->conics_at(height, beside_.conics))
    beside_.source->section_at(height, beside_.contours);
  const std::size_t sides = beside_.conics.size() + beside_.contours.points.size();
  return budget.can_hold(sides) && budget.spend(sides);
}

// Paints the section. A pixel of the plane beside the models is 255 or 0, so lighting it over the painted
// models gives the greater of both values. Correction keeps the order of values, so correcting afterwards
// still gives the greater one.
const Mask* ContourEngine::paint(MaskBudget& budget) {
  if (!rasterizer_.paint(budget)) return nullptr;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    for (const PixelMap& copy : models_[i].copies)
      rasterizer_.darken(holes_[i], copy);
  }
  rasterizer_.light(beside_.conics, beside_.map);
  rasterizer_.light(beside_.contours, beside_.map);
  if (!corrected_) return &rasterizer_.mask();
  correction_.apply(rasterizer_.mask(), *corrected_);
  return &*corrected_;
}

const Mask* ContourEngine::mask_within(Nanometers height, MaskBudget& budget) {
  begin_section();
  const Millimeters offset = to_millimeters(compensation_.offset_at(height));
  for (std::size_t i = 0; i < models_.size(); ++i) {
    if (!add_to_mask(i, models_[i].z_at(height), offset, budget)) return abandon();
  }
  return cut_beside(height, budget) ? paint(budget) : abandon();
}

const Mask* ContourEngine::abandon() {
  rasterizer_.clear();
  return nullptr;
}

const Mask& ContourEngine::mask_at(Nanometers height) {
  MaskBudget unlimited;
  return sound(mask_within(height, unlimited));
}

const Mask& ContourEngine::mask_at_z(Millimeters z) {
  expects(models_.size() == 1, "there is one model");
  MaskBudget unlimited;
  begin_section();
  const PlateModel& model = models_.front();
  const std::optional<Nanometers> height = model.elevation.height_at(z, model.model->bounds());
  const Millimeters offset = height ? to_millimeters(compensation_.offset_at(*height)) : Millimeters{};
  const bool added = add_to_mask(0, z, offset, unlimited) && (!height || cut_beside(*height, unlimited));
  return sound(added ? paint(unlimited) : abandon());
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section();
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.cracks = LayerCracks{};
  plate_contours_.repaired_loops = 0;
  MaskBudget unlimited;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    slice(i, models_[i].z_at(height));
    link(i, unlimited);
    append(contours_, plate_contours_);
  }
  return plate_contours_;
}

std::uint32_t ContourEngine::count_loops() {
  MaskBudget unlimited;
  // The rest of a section closes without repair, so it adds no cracks.
  for (std::size_t i = 0; i < models_.size(); ++i)
    link(i, unlimited);
  return figures_.loops;
}

}  // namespace contourd
