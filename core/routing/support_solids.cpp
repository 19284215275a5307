#include "core/routing/support_solids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/contract/expects.hpp"
#include "core/routing/support_loads.hpp"
#include "core/support/plate_segment.hpp"

namespace contourd {
namespace {

// Ends closer than this are the same place: a frustum between them has neither a direction nor a volume.
constexpr double kShortestMm = 1e-6;

void add_frustum(const Frustum& frustum, std::vector<SupportPrimitive>& solids) {
  const double length = std::hypot(frustum.upper.x - frustum.lower.x, frustum.upper.y - frustum.lower.y,
                                   frustum.upper.z - frustum.lower.z);
  if (length >= kShortestMm) solids.push_back(frustum);
}

// Returns a point inside the model, as deep as the settings ask or as the model is thick there, but at least
// one step of the sweep.
PlatePoint inside_from(const PlatePoint& surface, const Direction& inward, const LitLayers& layers,
                       const SupportSettings& settings) {
  double depth = settings.tip_depth.count();
  const double least = std::min(depth, layers.step_mm());
  while (depth > least && !layers.is_lit(moved(surface, inward, depth)))
    depth = std::max(least, depth - layers.step_mm() / 2);
  return moved(surface, inward, depth);
}

// Extends a support that stands on a model into the model.
void sink(const PlatePoint& on_model, double radius, const LitLayers& layers, const SupportSettings& settings,
          std::vector<SupportPrimitive>& solids) {
  add_frustum({inside_from(on_model, {0, 0, -1}, layers, settings), on_model, radius, radius}, solids);
}

void add_tip(const SupportTree::HeldTip& held, const ClearanceField& field, const SupportSettings& settings,
             std::vector<SupportPrimitive>& solids) {
  const SupportTip& tip = held.tip;
  const double radius = settings.tip_diameter.count() / 2;
  add_frustum({tip.joint, tip.at, tip.radius_mm, radius}, solids);
  const Direction inward{-tip.outward.x, -tip.outward.y, -tip.outward.z};
  const PlatePoint inside = inside_from(tip.at, inward, field.layers(), settings);
  add_frustum({tip.at, field.moved_inside(inside, radius), radius, radius}, solids);
  if (tip.path.stretches.empty() && tip.joint.z > 0)
    sink(tip.joint, tip.radius_mm, field.layers(), settings, solids);
}

// Adds a foot on a model: a tip upside down.
void add_landing(const SupportNode& node, const PlatePoint& on_model, const LitLayers& layers,
                 const SupportSettings& settings, std::vector<SupportPrimitive>& solids) {
  const double radius = landing_radius(node.load_mm2, settings);
  add_frustum({on_model, node.place, radius, node.radius_mm}, solids);
  sink(on_model, radius, layers, settings, solids);
}

// Returns, by node, the radius of the thickest branch that ends or begins there.
std::vector<double> ball_radii(const SupportTree& tree) {
  std::vector<double> radii(tree.nodes.size());
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const SupportNode& node = tree.nodes[i];
    radii[i] = std::max(radii[i], node.radius_mm);
    if (node.below != SupportNode::kNone) radii[node.below] = std::max(radii[node.below], node.radius_mm);
  }
  return radii;
}

// Feet are halved in height down to half of this, unless the settings ask for less.
constexpr double kLowest_mm = 0.1;

}  // namespace

std::vector<SupportPrimitive> solids_of(const SupportTree& tree, const ClearanceField& field,
                                        const SupportSettings& settings) {
  std::vector<SupportPrimitive> solids;
  for (const SupportTree::HeldTip& tip : tree.tips)
    add_tip(tip, field, settings, solids);
  const std::vector<double> radii = ball_radii(tree);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const SupportNode& node = tree.nodes[i];
    if (node.foot == SupportFoot::OnPlate) solids.push_back(foot_at(node.place, radii[i], field, settings));
    if (node.below == SupportNode::kNone) continue;
    const SupportNode& below = tree.nodes[node.below];
    if (below.foot == SupportFoot::OnModel) {
      add_landing(node, below.place, field.layers(), settings, solids);
    } else {
      add_frustum({below.place, node.place, node.radius_mm, node.radius_mm}, solids);
    }
    solids.push_back(Ball{node.place, radii[i]});
  }
  return solids;
}

Frustum foot_at(const PlatePoint& place, double radius_mm, const ClearanceField& field,
                const SupportSettings& settings) {
  expects(place.z == 0, "a foot stands on the plate");
  // Shares of the difference between the branch's radius and the foot's, in the order in which they are
  // tried.
  constexpr std::array<double, 6> kWidenings{1, 0.8, 0.6, 0.4, 0.2, 0};
  const double wide = std::max(settings.foot_diameter.count() / 2, radius_mm);
  double base = radius_mm;
  for (const double widening : kWidenings) {
    base = radius_mm + (wide - radius_mm) * widening;
    if (field.has_room(place, base)) break;
  }
  // A branch that arrives aslant may have no room straight above.
  PlatePoint top{place.x, place.y, settings.foot_height.count()};
  while (top.z > kLowest_mm && !field.has_room(PlateSegment{place, top}, radius_mm))
    top.z /= 2;
  return {place, top, base, radius_mm};
}

}  // namespace contourd
