#include "core/routing/support_loads.hpp"

#include "core/clearance/support_path_field.hpp"
#include "core/routing/support_routing.hpp"
#include "tests/catch.hpp"
#include "tests/core/routing/supports_fixture.hpp"
#include "tests/random_shapes.hpp"

namespace {

const SupportSettings kSettings;

// Supports under a plate of 24 by 18 mm that hangs 14 mm above the build plate.
class Hanging {
 public:
  Hanging() { testing::stack({models::box({-12, -9, 14}, {12, 9, 15})}, kBuildArea, layers_); }

  [[nodiscard]] SupportTree tree_for(const std::vector<SupportContact>& contacts) const {
    const ClearanceField field(layers_, {-20, 20, -15, 15, 17}, {kBuildArea, 0.5}, {});
    const SupportPathField paths(field, {{0.5, 0.25, 0.2}, SupportPathField::End::Plate, {}}, {});
    const SupportTips tips(field, paths, kSettings);
    SupportRouting routing(field, paths, kSettings);
    for (std::uint32_t i = 0; i < contacts.size(); ++i)
      routing.add(tips.tip_at(contacts[i]).value(), i, contacts[i].load_mm2);
    SupportTree tree = routing.lead_down({});
    thicken_branches(tree, field, kSettings);
    return tree;
  }

 private:
  LitLayers layers_;
};

std::uint32_t foot_of(std::uint32_t node, const SupportTree& tree) {
  while (tree.nodes[node].below != SupportNode::kNone)
    node = tree.nodes[node].below;
  return node;
}

}  // namespace

TEST_CASE("A branch is as thick as a pillar until its load or its length requires more") {
  const double tip = kSettings.tip_holds_mm2;
  CHECK(branch_radius(0, 0, kSettings) == 0.5);
  CHECK(branch_radius(tip, 15, kSettings) == 0.5);
  // Four times the length, or sixteen times the load, makes it twice as thick.
  CHECK(std::fabs(branch_radius(tip, 60, kSettings) - 1) < 1e-12);
  CHECK(std::fabs(branch_radius(16 * tip, 15, kSettings) - 1) < 1e-12);
  // Short branches tear before they buckle.
  CHECK(std::fabs(branch_radius(16 * tip, 0.1, kSettings) - 0.8) < 1e-12);
  CHECK(branch_radius(1e6, 100, kSettings) == 2);
}

TEST_CASE("A foot on a model is pressed no harder than a tip is pulled, and no thicker than a branch") {
  CHECK(landing_radius(1, kSettings) == 0.2);
  CHECK(std::fabs(landing_radius(4 * kSettings.tip_holds_mm2, kSettings) - 0.4) < 1e-12);
  CHECK(landing_radius(1e6, kSettings) == 0.5);
}

TEST_CASE(
    "Every contact's load arrives at a foot, and no branch is thinner than its load and length require") {
  const Hanging hanging;
  CHECK(rc::check([&hanging] {
    std::vector<SupportContact> contacts;
    for (std::int64_t i = testing::draw(1, 12); i > 0; --i) {
      const PlatePoint place{draw_real(-11, 11), draw_real(-8, 8), 14};
      contacts.push_back({place, {0, 0, -1}, ContactCause::Overhang, draw_real(0.5, 11)});
    }
    const SupportTree tree = hanging.tree_for(contacts);
    std::vector<double> arrived(tree.nodes.size(), 0);
    for (const SupportTree::HeldTip& held : tree.tips) {
      const std::uint32_t foot = foot_of(held.node, tree);
      RC_ASSERT(tree.nodes[foot].place.z == 0);
      RC_ASSERT(tree.nodes[foot].foot == SupportFoot::OnPlate);
      arrived[foot] += contacts[held.contact].load_mm2;
    }
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      const SupportNode& node = tree.nodes[i];
      // Sums in a different order differ by their last bits.
      if (node.foot == SupportFoot::OnPlate) RC_ASSERT(std::fabs(node.load_mm2 - arrived[i]) < 1e-9);
      if (node.below == SupportNode::kNone) continue;
      const double length = PlateSegment{node.place, tree.nodes[node.below].place}.length();
      RC_ASSERT(node.radius_mm >= branch_radius(node.load_mm2, length, kSettings));
    }
  }));
}
