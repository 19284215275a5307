#include "core/routing/support_tips.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/support/plate_segment.hpp"

namespace contourd {
namespace {

// Factors of tip_length that are tried in this order.
constexpr std::array<double, 4> kLengths{1.2, 1.6, 2.2, 3.2};
// The first kAlongNormal directions follow the normal, the others point around it.
constexpr std::size_t kAlongNormal = 3;
constexpr std::array<double, 2> kWidths{1, 0.5};
// Solid this close below a surface belongs to the surface itself.
constexpr double kBelowSurface_mm = 0.2;
// Length of the shortest pin between two parts of a model.
constexpr double kShortestPin_mm = 0.3;

// An island this near to other material is joined to it if nothing else holds it.
constexpr double kNear_mm = 0.3;

Direction unit(double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// Returns the direction turned downwards until it is no flatter than 45 degrees.
Direction turned_down(const Direction& outward) {
  const double across = std::sqrt(outward.x * outward.x + outward.y * outward.y);
  if (across <= -outward.z) return unit(outward.x, outward.y, outward.z);
  if (across == 0) return {0, 0, -1};
  return {outward.x / across * kSin45, outward.y / across * kSin45, -kSin45};
}

// Returns the directions to try: along the normal, closer to straight down, then all around.
std::vector<Direction> directions_for(const Direction& outward) {
  const Direction first = turned_down(outward);
  std::vector<Direction> all{first, unit(first.x, first.y, first.z - 1), {0, 0, -1}};
  for (const auto& [x, y] : kAround) {
    all.push_back({x * kSin45, y * kSin45, -kSin45});
    all.push_back(unit(x, y, -2.4));
  }
  const auto nearest_first = [&first](const Direction& a, const Direction& b) {
    const auto along = [&first](const Direction& d) { return d.x * first.x + d.y * first.y + d.z * first.z; };
    return along(a) > along(b);
  };
  std::stable_sort(all.begin() + kAlongNormal, all.end(), nearest_first);
  return all;
}

}  // namespace

SupportTips::SupportTips(const ClearanceField& field, const SupportPathField& paths,
                         const SupportSettings& settings)
    : field_(field), paths_(paths), settings_(settings) {}

std::optional<SupportTip> SupportTips::tip_at(const SupportContact& contact) const {
  // At the build area's edge the tip moves in by at most its own radius; its depth makes up for that.
  const PlatePoint at = field_.moved_inside(contact.place, settings_.tip_diameter.count() / 2);
  const std::vector<Direction> directions = directions_for(contact.outward);
  const double radius = settings_.pillar_diameter.count() / 2;
  const std::span<const Direction> along_normal = std::span(directions).first(kAlongNormal);
  for (const double width : kWidths) {
    for (const std::span<const Direction> some :
         {along_normal, std::span(directions).subspan(kAlongNormal)}) {
      for (const double length : kLengths) {
        for (const Direction& direction : some) {
          const Cone cone{direction, length * settings_.tip_length.count(), width * radius};
          if (std::optional<SupportTip> tip = tip_with(at, cone)) return tip;
        }
      }
    }
  }
  std::optional<SupportTip> pin = pin_at(at, directions);
  if (!pin && contact.cause == ContactCause::Island && paths_.end() == SupportPathField::End::Model)
    pin = strut_near(at);
  return pin;
}

std::optional<SupportTip> SupportTips::tip_with(const PlatePoint& at, const Cone& cone) const {
  const PlatePoint joint = moved(at, cone.outward, cone.length_mm);
  // Cheap checks come first.
  if (joint.z < settings_.foot_height.count() || !paths_.length_from(joint)) return std::nullopt;
  if (!field_.has_room(joint, cone.radius_mm) || !is_free(at, cone)) return std::nullopt;
  std::optional<SupportPath> path = paths_.path_from(joint);
  if (!path) return std::nullopt;
  return SupportTip{at, joint, cone.outward, cone.radius_mm, std::move(*path)};
}

// Returns a cone down to material so close below that a branch has no room.
std::optional<SupportTip> SupportTips::pin_at(const PlatePoint& at,
                                              std::span<const Direction> directions) const {
  const double tip = settings_.tip_diameter.count() / 2, usual = settings_.pillar_diameter.count() / 2;
  for (const double widest : {usual, (usual + tip) / 2, tip}) {
    for (const Direction& direction : directions) {
      const std::optional<PlatePoint> foot = foot_of_pin(at, direction);
      if (!foot) continue;
      const double length = PlateSegment{at, *foot}.length();
      const Cone cone{direction, length, foot->z > 0 ? tip : std::clamp(length, tip, widest)};
      if (field_.is_inside(*foot, cone.radius_mm) && is_free(at, cone))
        return SupportTip{at, *foot, direction, cone.radius_mm, {}};
    }
  }
  return std::nullopt;
}

// Returns a strut as thick as a tip, down to the material beneath the island's first layer, or at 45 degrees
// into the material beside it.
std::optional<SupportTip> SupportTips::strut_near(const PlatePoint& at) const {
  const LitLayers& layers = field_.layers();
  const double tip = settings_.tip_diameter.count() / 2;
  if (const std::optional<double> top = layers.top_below({at.x, at.y, at.z - layers.step_mm()}, kNear_mm))
    return SupportTip{at, {at.x, at.y, *top}, {0, 0, -1}, tip, {}};
  for (double gap = layers.pitch_mm(); gap <= kNear_mm; gap += layers.pitch_mm()) {
    for (const auto& [x, y] : kAround) {
      if (!layers.is_lit({at.x + x * gap, at.y + y * gap, at.z - layers.step_mm()})) continue;
      const Direction outward{x * kSin45, y * kSin45, -kSin45};
      const PlatePoint foot = moved(at, outward, (gap + tip) / kSin45);
      // The strut's whole depth must be inside the material.
      if (layers.is_lit(foot) && layers.is_lit({foot.x, foot.y, foot.z - settings_.tip_depth.count()}))
        return SupportTip{at, foot, outward, tip, {}};
    }
  }
  return std::nullopt;
}

// Returns where a pin in this direction ends: on the plate, or straight below on a model.
std::optional<PlatePoint> SupportTips::foot_of_pin(const PlatePoint& at, const Direction& direction) const {
  const double longest = 2 * settings_.tip_length.count() + settings_.foot_height.count();
  if (paths_.end() == SupportPathField::End::Plate) {
    const double length = at.z / -direction.z;
    if (!(at.z > 0) || length > longest) return std::nullopt;
    const PlatePoint foot = moved(at, direction, length);
    return PlatePoint{foot.x, foot.y, 0};
  }
  const PlatePoint below{at.x, at.y, at.z - kBelowSurface_mm};
  const std::optional<double> top = field_.layers().top_below(below, longest);
  if (direction.z != -1 || !top || at.z - *top < kShortestPin_mm) return std::nullopt;
  return PlatePoint{at.x, at.y, *top};
}

// True if the cone touches the models only at its point.
bool SupportTips::is_free(const PlatePoint& at, const Cone& cone) const {
  const double tip = settings_.tip_diameter.count() / 2;
  const PlatePoint joint = moved(at, cone.outward, cone.length_mm);
  const PlatePoint above{joint.x, joint.y, joint.z + kBelowSurface_mm};
  const bool on_model = field_.layers().top_below(above, 2 * kBelowSurface_mm).has_value();
  const double end = on_model ? cone.length_mm - ClearanceField::kAtSurface_mm : cone.length_mm;
  for (double along = ClearanceField::kAtSurface_mm; along < end; along += ClearanceField::kLook_mm) {
    const double radius = tip + (cone.radius_mm - tip) * (along / cone.length_mm);
    // The surface that it holds may rise beside it at 45 degrees.
    if (!field_.is_free(moved(at, cone.outward, along), std::min(radius, along * kSin45 - 0.15)))
      return false;
  }
  return true;
}

}  // namespace contourd
