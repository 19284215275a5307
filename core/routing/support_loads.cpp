#include "core/routing/support_loads.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Height to which a pillar of the usual diameter can stand alone with one tip's load.
constexpr double kAlone_mm = 15;
// Greatest diameter of a branch.
constexpr double kThickest_mm = 2;
// Bisection steps between a radius that is too thick and one that has room.
constexpr int kHalvings = 4;

PlateSegment branch_from(const SupportNode& node, const SupportTree& tree) {
  return {node.place, tree.nodes[node.below].place};
}

// Returns, by node, the length of its branch between the junctions above and below it.
std::vector<double> free_lengths(const SupportTree& tree) {
  const std::vector<SupportNode>& nodes = tree.nodes;
  std::vector<std::uint32_t> above(nodes.size(), 0);
  for (const SupportNode& node : nodes) {
    if (node.below != SupportNode::kNone) ++above[node.below];
  }
  for (const SupportTree::HeldTip& tip : tree.tips)
    above[tip.node] += 2;  // a chain begins there
  std::vector<double> lengths(nodes.size(), 0);
  std::vector<std::uint32_t> chain;
  for (std::uint32_t head = 0; head < nodes.size(); ++head) {
    if (above[head] == 1) continue;
    chain.clear();
    double length = 0;
    for (std::uint32_t at = head; nodes[at].below != SupportNode::kNone && (at == head || above[at] == 1);
         at = nodes[at].below) {
      length += branch_from(nodes[at], tree).length();
      chain.push_back(at);
    }
    for (const std::uint32_t node : chain)
      lengths[node] = length;
  }
  return lengths;
}

// Returns the largest radius up to `wanted` that has room; `least` is known to fit.
double fitting_radius(const PlateSegment& branch, double least, double wanted, const ClearanceField& field) {
  if (wanted <= least || field.has_room(branch, wanted)) return std::max(wanted, least);
  double too_thick = wanted;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (least + too_thick) / 2;
    (field.has_room(branch, middle) ? least : too_thick) = middle;
  }
  return least;
}

}  // namespace

double branch_radius(double load_mm2, double length_mm, const SupportSettings& settings) {
  const double tips = load_mm2 / settings.tip_holds_mm2;
  const double pillar = settings.pillar_diameter.count();
  const double buckling = pillar * std::sqrt(length_mm / kAlone_mm) * std::sqrt(std::sqrt(tips));
  const double tearing = settings.tip_diameter.count() * std::sqrt(tips);
  return std::min(std::max({pillar, buckling, tearing}) / 2, std::max(kThickest_mm, pillar / 2));
}

double landing_radius(double load_mm2, const SupportSettings& settings) {
  const double tip = settings.tip_diameter.count() / 2, pillar = settings.pillar_diameter.count() / 2;
  return std::clamp(tip * std::sqrt(load_mm2 / settings.tip_holds_mm2), tip, std::max(tip, pillar));
}

void thicken_branches(SupportTree& tree, const ClearanceField& field, const SupportSettings& settings) {
  expects(std::ranges::all_of(tree.nodes,
                              [&tree](const SupportNode& node) {
                                return node.below == SupportNode::kNone ||
                                       (node.below < tree.nodes.size() &&
                                        tree.nodes[node.below].place.z < node.place.z);
                              }),
          "every node leads down");
  const std::vector<double> lengths = free_lengths(tree);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    SupportNode& node = tree.nodes[i];
    if (node.below == SupportNode::kNone) continue;
    const double wanted = branch_radius(node.load_mm2, lengths[i], settings);
    node.radius_mm = fitting_radius(branch_from(node, tree), node.radius_mm, wanted, field);
  }
}

}  // namespace contourd
