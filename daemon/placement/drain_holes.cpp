#include "daemon/placement/drain_holes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/support_structure.hpp"
#include "daemon/placement/model_turn.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns the axis as two corners of a facet, so that it is turned and scaled exactly as facets are.
Facet axis_of(const DrainHole& hole) {
  // Divide by the largest component first: the squares of a tiny vector would underflow, of a huge one
  // overflow.
  const double longest =
      std::max({std::fabs(hole.inwards.x), std::fabs(hole.inwards.y), std::fabs(hole.inwards.z)});
  const Direction d{hole.inwards.x / longest, hole.inwards.y / longest, hole.inwards.z / longest};
  const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  const auto at = [&](double distance_mm) {
    const auto along = [&](double from_mm, double part) {
      return static_cast<float>(from_mm + part / length * distance_mm);
    };
    return Vertex{along(hole.x_mm, d.x), along(hole.y_mm, d.y), along(hole.z_mm, d.z)};
  };
  const Vertex outer = at(-hole.diameter_mm / 2), inner = at(hole.depth_mm);
  return {{outer, inner, inner}};
}

Frustum cylinder_of(const Facet& axis, double radius_mm) {
  const auto place = [](const Vertex& v) { return PlatePoint{v.x, v.y, v.z}; };
  PlatePoint lower = place(axis.vertices[0]), upper = place(axis.vertices[1]);
  if (lower.z > upper.z) std::swap(lower, upper);
  return {lower, upper, radius_mm, radius_mm};
}

struct HeightRange {
  Nanometers low, high;
};

// Returns the heights above the plate between which the cylinder may cut the model.
HeightRange reach_of(const Frustum& cylinder, const StandingModel& model) {
  const Bounds& bounds = model.model->bounds();
  const auto height = [&](double z_mm) {
    // Clamped to the model, outside of which there is nothing to cut.
    const double within = std::clamp(z_mm, double{bounds.min_z} - 1, double{bounds.max_z} + 1);
    return model.elevation.height_at(Millimeters{within}, bounds).value_or(Nanometers{});
  };
  return {height(cylinder.lower.z - cylinder.lower_radius_mm),
          height(cylinder.upper.z + cylinder.upper_radius_mm)};
}

// Refuses a hole that the structure of holes does not accept.
[[noreturn]] void refuse_size_of(const Frustum& cylinder, const DrainHole& hole, std::size_t number) {
  const std::string which =
      fmt::format("drain hole {} at {:g}, {:g}, {:g} mm", number, hole.x_mm, hole.y_mm, hole.z_mm);
  if (cylinder.lower == cylinder.upper || cylinder.lower_radius_mm <= 0)
    throw JobRefused(fmt::format("{} is too small: it is {:g} mm wide and {:g} mm deep", which,
                                 hole.diameter_mm, hole.depth_mm));
  throw JobRefused(fmt::format(
      "{} is too far away or too large: as printed, it is {:g} mm wide and reaches from {:g}, {:g}, {:g} to "
      "{:g}, "
      "{:g}, {:g} mm, and no part of it may be farther from 0 than {:g} mm; check its position and the scale",
      which, 2 * cylinder.lower_radius_mm, cylinder.lower.x, cylinder.lower.y, cylinder.lower.z,
      cylinder.upper.x, cylinder.upper.y, cylinder.upper.z, SupportStructure::kFarthestMm));
}

// True if the cylinder changes a mask of the model, or if the deadline passes first.
bool cuts(const Frustum& cylinder, const PlateModel& model, const HoleSearch& search) {
  PlateModel whole{model, {model.copies.front()}, nullptr};
  PlateModel drilled = whole;
  drilled.holes = holes_of(std::span(&cylinder, 1));
  ContourEngine with({std::move(drilled)}, search.settings), without({std::move(whole)}, search.settings);
  const HeightRange reach = reach_of(cylinder, model);
  return std::ranges::any_of(search.heights, [&](Nanometers height) {
    if (height < reach.low || height > reach.high) return false;
    MaskBudget first(search.deadline), second(search.deadline);
    if (with.mask_within(height, first) == nullptr || without.mask_within(height, second) == nullptr)
      return true;
    return with.coverage() != without.coverage();
  });
}

}  // namespace

std::vector<Frustum> drain_cylinders(const ModelTicket& ticket, const Scale& scale, const Scale& shrinkage) {
  const Scale all = scale * shrinkage;
  std::vector<Frustum> cylinders;
  for (const DrainHole& hole : ticket.drain) {
    Facet axis = axis_of(hole);
    turn_and_scale(std::span(&axis, 1), ticket, shrinkage);
    if (ticket.fit) enlarge(std::span(&axis, 1), scale);
    const Frustum cylinder = cylinder_of(axis, hole.diameter_mm / 2 * (all.x + all.y + all.z) / 3);
    if (!SupportStructure::accepts(cylinder)) refuse_size_of(cylinder, hole, cylinders.size() + 1);
    cylinders.push_back(cylinder);
  }
  return cylinders;
}

std::shared_ptr<const SectionSource> holes_of(std::span<const Frustum> cylinders) {
  if (cylinders.empty()) return nullptr;
  return std::make_shared<const SupportStructure>(
      std::vector<SupportPrimitive>(cylinders.begin(), cylinders.end()));
}

void refuse_holes_beside(const DrilledModel& drilled, const std::string& name, const HoleSearch& search) {
  for (std::size_t i = 0; i < drilled.cylinders.size(); ++i) {
    if (cuts(drilled.cylinders[i], drilled.model, search)) continue;
    const DrainHole& hole = drilled.ticket.drain[i];
    const Bounds& bounds = drilled.model.model->bounds();
    const Frustum& made = drilled.cylinders[i];
    throw JobRefused(
        fmt::format("drain hole {} of {} misses it: the hole starts at {:g}, {:g}, {:g} mm, is {:g} mm wide "
                    "and {:g} mm deep, and removes nothing; as printed, it reaches from {} to {} mm, and the "
                    "model from {} to {} mm",
                    i + 1, name, hole.x_mm, hole.y_mm, hole.z_mm, hole.diameter_mm, hole.depth_mm,
                    coordinates({made.lower.x, made.lower.y, made.lower.z}),
                    coordinates({made.upper.x, made.upper.y, made.upper.z}),
                    coordinates({bounds.min_x, bounds.min_y, bounds.min_z}),
                    coordinates({bounds.max_x, bounds.max_y, bounds.max_z})));
  }
}

}  // namespace contourd
