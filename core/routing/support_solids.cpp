#include "core/routing/support_solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/routing/support_feet.hpp"
#include "core/routing/support_loads.hpp"

namespace contourd {
namespace {

// Ends as near as that are one place: what is between them has neither a direction nor a volume.
constexpr double kShortestMm = 1e-6;

void add_frustum(const Frustum& frustum, std::vector<SupportPrimitive>& solids) {
  const double length = std::hypot(frustum.upper.x - frustum.lower.x, frustum.upper.y - frustum.lower.y,
                                   frustum.upper.z - frustum.lower.z);
  if (length >= kShortestMm) solids.push_back(frustum);
}

// What stands on a model reaches into it.
void sink(const PlatePoint& on_model, double radius, double depth, std::vector<SupportPrimitive>& solids) {
  add_frustum({{on_model.x, on_model.y, on_model.z - depth}, on_model, radius, radius}, solids);
}

void add_tip(const SupportTree::HeldTip& held, const ClearanceField& field, const SupportSettings& settings,
             std::vector<SupportPrimitive>& solids) {
  const SupportTip& tip = held.tip;
  const double radius = settings.tip_diameter.count() / 2, depth = settings.tip_depth.count();
  add_frustum({tip.joint, tip.at, tip.radius_mm, radius}, solids);
  const PlatePoint inside{tip.at.x - tip.outward.x * depth, tip.at.y - tip.outward.y * depth,
                          tip.at.z - tip.outward.z * depth};
  add_frustum({tip.at, field.moved_inside(inside, radius), radius, radius}, solids);
  if (tip.way.stretches.empty() && tip.joint.z > 0) sink(tip.joint, tip.radius_mm, depth, solids);
}

// A foot on a model is a tip upside down.
void add_landing(const SupportNode& node, const PlatePoint& on_model, const SupportSettings& settings,
                 std::vector<SupportPrimitive>& solids) {
  const double radius = landing_radius(node.load_mm2, settings);
  add_frustum({on_model, node.place, radius, node.radius_mm}, solids);
  sink(on_model, radius, settings.tip_depth.count(), solids);
}

// By node: of the thickest branch that ends or begins there.
std::vector<double> ball_radii(const SupportTree& tree) {
  std::vector<double> radii(tree.nodes.size());
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const SupportNode& node = tree.nodes[i];
    radii[i] = std::max(radii[i], node.radius_mm);
    if (node.below != SupportNode::kNone) radii[node.below] = std::max(radii[node.below], node.radius_mm);
  }
  return radii;
}

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
      add_landing(node, below.place, settings, solids);
    } else {
      add_frustum({below.place, node.place, node.radius_mm, node.radius_mm}, solids);
    }
    solids.push_back(Ball{node.place, radii[i]});
  }
  return solids;
}

}  // namespace contourd
