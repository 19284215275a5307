#include "core/engine/contour_engine.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace contourd {
namespace {

constexpr Nanometers kNever{std::numeric_limits<std::int64_t>::max()};
constexpr Nanometers kBelowPlate{-1};

// Returns the mask of a call without a time limit; throws if it was abandoned.
const Mask& sound(const Mask* mask) {
  if (mask == nullptr) throw std::length_error("the section crosses itself in too many places");
  return *mask;
}

// Returns the mask, corrected into `to` if that is set.
const Mask& corrected(const Mask& mask, const ExposureCorrection& correction, std::optional<Mask>& to) {
  if (!to) return mask;
  correction.apply(mask, *to);
  return *to;
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
      cuts_(models_.size()),
      rasterizer_(settings.display.width, settings.display.height, settings.anti_aliasing) {
  expects(std::ranges::all_of(models_, [](const PlateModel& each) { return each.model != nullptr; }),
          "no model is null");
  const Mask& mask = rasterizer_.mask();
  if (settings.uniformity &&
      (settings.uniformity->width() != mask.width() || settings.uniformity->height() != mask.height())) {
    throw std::invalid_argument("the uniformity mask does not have the display's size");
  }
  if (!correction_.is_none()) masks_.corrected.emplace(mask.width(), mask.height());
  for (const PlateModel& each : models_) {
    if (!each.has_finished_layers()) continue;
    expects(models_.size() == 1 && each.copies.size() == 1 && !each.holes && !beside_.source &&
                !(each.pictures && each.outlines),
            "finished layers are of the whole plate");
    if (!each.pictures) continue;
    if (each.pictures->width() != mask.width() || each.pictures->height() != mask.height())
      throw std::invalid_argument("the pictures do not have the display's size");
    masks_.picture.emplace(mask.width(), mask.height());
  }
}

ContourEngine::ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies)
    : ContourEngine({PlateModel{{std::make_shared<const HeightIndex>(std::move(model))}, std::move(copies)}},
                    settings) {}

void ContourEngine::darken(std::size_t model, std::size_t copy, Nanometers from) {
  expects(model < models_.size() && copy < models_[model].copies.size(), "there is such a copy");
  std::vector<Nanometers>& dark_from = cuts_[model].dark_from;
  dark_from.resize(models_[model].copies.size(), kNever);
  dark_from[copy] = std::min(dark_from[copy], from);
}

void ContourEngine::replace_beside(std::shared_ptr<const SectionSource> beside, Nanometers from) {
  expects(beside != nullptr && (beside_.later.empty() || beside_.later.back().first <= from),
          "sections replace those beneath them");
  if (beside_.source) beside_.later.emplace_back(from, std::move(beside));
}

void ContourEngine::light_all() {
  for (Cut& cut : cuts_)
    cut.dark_from.clear();
  beside_.later.clear();
}

const SectionSource& ContourEngine::Beside::at(Nanometers height) const {
  const SectionSource* found = source.get();
  for (const auto& [from, each] : later)
    if (from <= height) found = each.get();
  return *found;
}

void ContourEngine::begin_section(std::optional<Nanometers> height) {
  section_height_ = height.value_or(Nanometers{std::numeric_limits<std::int64_t>::min()});
  figures_ = Figures{};
  beside_.conics.clear();
  beside_.contours.points.clear();
  beside_.contours.loops.clear();
}

bool ContourEngine::cut_holes(std::size_t model, Millimeters z, MaskBudget& budget) {
  const auto& source = models_[model].holes;
  if (!source) return true;
  Contours& holes = cuts_[model].holes;
  source->section_at(to_nanometers(z).value_or(Nanometers{}), holes);
  return budget.can_hold(holes.points.size()) && budget.spend(holes.points.size());
}

void ContourEngine::slice(std::size_t model, Millimeters z) {
  slice_at(*models_[model].model, z, cuts_[model].section);
  figures_.intersecting_facets += cuts_[model].section.intersecting_facets;
}

void ContourEngine::link(std::size_t model, MaskBudget& budget) {
  linker_.link(cuts_[model].section.segments, join_tolerance_, contours_, budget);
  cuts_[model].section.segments.clear();
  figures_.loops += static_cast<std::uint32_t>(contours_.loops.size());
  figures_.cracks += contours_.cracks;
}

bool ContourEngine::add_to_mask(std::size_t model, Millimeters z, Millimeters offset, MaskBudget& budget) {
  if (models_[model].outlines) {
    models_[model].outlines->section_at(section_height_, contours_);
    figures_.loops += static_cast<std::uint32_t>(contours_.loops.size());
    if (!budget.spend(contours_.points.size()) || !budget.can_hold(contours_.points.size())) return false;
    if (offset != Millimeters{}) return add_moved(model, offset, budget);
    for_copies(model, [&](const PixelMap& copy) { rasterizer_.add_loops(contours_, copy); });
    return true;
  }
  slice(model, z);
  if (!cut_holes(model, z, budget)) return false;
  Section& section = cuts_[model].section;
  if (!budget.spend(section.segments.size()) || !budget.can_hold(section.segments.size())) return false;
  if (offset != Millimeters{}) {
    link(model, budget);
    return add_moved(model, offset, budget);
  }
  // Balanced segments form closed polygons, in any order.
  const bool open = !section.balanced;
  if (open) {
    linker_.close_open_chains(section.segments, join_tolerance_, contours_, budget);
    if (!budget.look_at_the_clock()) return false;
    figures_.loops += static_cast<std::uint32_t>(contours_.loops.size());
    figures_.cracks += contours_.cracks;
  }
  for_copies(model, [&](const PixelMap& copy) {
    rasterizer_.add_segments(section.segments, copy);
    if (open) rasterizer_.add_loops(contours_, copy);
  });
  return true;
}

bool ContourEngine::add_moved(std::size_t model, Millimeters offset, MaskBudget& budget) {
  if (!budget.look_at_the_clock()) return false;
  if (!offset_.offset(contours_, offset, moved_, budget)) return false;
  for_copies(model, [&](const PixelMap& copy) { rasterizer_.add_loops(moved_, copy); });
  return true;
}

bool ContourEngine::cut_beside(Nanometers height, MaskBudget& budget) {
  if (!beside_.source) return true;
  const SectionSource& source = beside_.at(height);
  if (!source.conics_at(height, beside_.conics)) source.section_at(height, beside_.contours);
  const std::size_t sides = beside_.conics.size() + beside_.contours.points.size();
  return budget.can_hold(sides) && budget.spend(sides);
}

// Paints the section. A pixel of the plane beside the models is 255 or 0, so lighting it over the painted
// models gives the greater of both values. Correction keeps the order of values, so correcting afterwards
// still gives the greater one.
const Mask* ContourEngine::paint(MaskBudget& budget) {
  if (!rasterizer_.paint(budget)) return nullptr;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    for_copies(i, [&](const PixelMap& copy) { rasterizer_.darken(cuts_[i].holes, copy); });
  }
  rasterizer_.light(beside_.conics, beside_.map);
  rasterizer_.light(beside_.contours, beside_.map);
  return &corrected(rasterizer_.mask(), correction_, masks_.corrected);
}

const Mask& ContourEngine::draw_picture(Nanometers height) {
  const std::vector<Nanometers>& dark_from = cuts_.front().dark_from;
  const bool is_dark = !dark_from.empty() && section_height_ >= dark_from.front();
  models_.front().pictures->draw(is_dark ? kBelowPlate : height, *masks_.picture);
  return corrected(*masks_.picture, correction_, masks_.corrected);
}

const Mask* ContourEngine::mask_within(Nanometers height, MaskBudget& budget) {
  begin_section(height);
  if (masks_.picture) return &draw_picture(height);
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
  const PlateModel& model = models_.front();
  const std::optional<Nanometers> height = model.elevation.height_at(z, model.model->bounds());
  begin_section(height);
  if (masks_.picture) return draw_picture(height.value_or(kBelowPlate));
  const Millimeters offset = height ? to_millimeters(compensation_.offset_at(*height)) : Millimeters{};
  const bool added = add_to_mask(0, z, offset, unlimited) && (!height || cut_beside(*height, unlimited));
  return sound(added ? paint(unlimited) : abandon());
}

const Contours& ContourEngine::contours_at(Nanometers height) {
  begin_section(height);
  plate_contours_.points.clear();
  plate_contours_.loops.clear();
  plate_contours_.cracks = LayerCracks{};
  plate_contours_.repaired_loops = 0;
  MaskBudget unlimited;
  if (masks_.picture) return plate_contours_;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    if (models_[i].outlines) {
      models_[i].outlines->section_at(height, contours_);
    } else {
      slice(i, models_[i].z_at(height));
      link(i, unlimited);
    }
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
