#include "core/repair/patch_balance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>

namespace contourd {
namespace {

// Limit on passes over all unbalanced junctions; each pass leaves fewer of them.
constexpr int kMaxPasses = 50;

// Among n facets turned at random, a majority larger than three times the root of n is not chance.
constexpr double kNotChance = 3;

bool is_clear(const Patch& patch) {
  return std::fabs(static_cast<double>(patch.net)) > kNotChance * std::sqrt(static_cast<double>(patch.faces));
}

class PatchBalance {
 public:
  explicit PatchBalance(const FacetPatches& mesh)
      : mesh_(mesh), residuals_(mesh.junctions, 0), settled_(mesh.patches.size(), false) {
    result_.windings.resize(mesh.patches.size());
    sort_parts_by_patch();
    find_groups();
  }

  PatchGroups balance() {
    for (PatchGroups::Group& group : result_.groups) {
      begin(group);
      if (!group.inconsistent) continue;
      settle_signs(group);
      improve(group);
    }
    return std::move(result_);
  }

 private:
  using Group = PatchGroups::Group;

  void sort_parts_by_patch() {
    first_part_.assign(mesh_.patches.size() + 1, 0);
    for (const JunctionPart& part : mesh_.junction_parts)
      ++first_part_[part.patch + 1];
    std::partial_sum(first_part_.begin(), first_part_.end(), first_part_.begin());
    parts_of_.resize(mesh_.junction_parts.size());
    std::vector<std::uint32_t> next(first_part_.begin(), first_part_.end() - 1);
    for (const JunctionPart& part : mesh_.junction_parts)
      parts_of_[next[part.patch]++] = part;
    first_at_.assign(mesh_.junctions + std::size_t{1}, 0);
    for (const JunctionPart& part : mesh_.junction_parts)
      ++first_at_[part.junction + 1];
    std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
  }

  [[nodiscard]] std::span<const JunctionPart> parts_of(std::uint32_t patch) const {
    return std::span(parts_of_).subspan(first_part_[patch], first_part_[patch + 1] - first_part_[patch]);
  }
  [[nodiscard]] std::span<const JunctionPart> parts_at(std::uint32_t junction) const {
    return std::span(mesh_.junction_parts)
        .subspan(first_at_[junction], first_at_[junction + 1] - first_at_[junction]);
  }

  void find_groups() {
    std::vector<bool> seen(mesh_.patches.size(), false);
    for (std::uint32_t first = 0; first < mesh_.patches.size(); ++first) {
      if (seen[first]) continue;
      const auto begin = static_cast<std::uint32_t>(result_.members.size());
      seen[first] = true;
      result_.members.push_back(first);
      for (std::size_t at = begin; at < result_.members.size(); ++at) {
        for (const JunctionPart& part : parts_of(result_.members[at])) {
          for (const JunctionPart& other : parts_at(part.junction)) {
            if (seen[other.patch]) continue;
            seen[other.patch] = true;
            result_.members.push_back(other.patch);
          }
        }
      }
      result_.groups.push_back({begin, static_cast<std::uint32_t>(result_.members.size()) - begin});
    }
  }

  [[nodiscard]] std::span<const std::uint32_t> members(const Group& group) const {
    return std::span(result_.members).subspan(group.first_patch, group.patches);
  }

  // Returns the winding that most of a patch's facets have: first how many copies there are, then how they
  // are turned.
  [[nodiscard]] static std::int32_t usual_winding(const Patch& patch, bool meets_others) {
    if (patch.is_even()) return patch.least_net;
    const std::int32_t sign = patch.net < 0 ? -1 : 1;
    if (patch.odd * std::uint64_t{2} >= patch.faces) return sign;
    return !meets_others || std::abs(patch.net) > std::int64_t{patch.faces} ? 2 * sign : 0;
  }

  // Returns the winding to start with if all facets of the group are there in both directions.
  [[nodiscard]] static std::int32_t winding_of_one_side(const Patch& patch, bool meets_others) {
    return !meets_others || patch.odd_half * std::uint64_t{2} >= patch.faces ? 1 : 0;
  }

  // Returns how many of a patch's facets would have to be turned or dropped.
  [[nodiscard]] static std::int64_t changes_for(const Patch& patch, std::int32_t winding) {
    std::int64_t changes = 0;
    for (std::int32_t net = -Patch::kMaxNet; net <= Patch::kMaxNet; ++net) {
      changes += std::int64_t{patch.with_net[Patch::place_of(net)]} * ((std::abs(net - winding) + 1) / 2);
    }
    return changes;
  }

  void begin(Group& group) {
    bool empty = true, even = true;
    for (const std::uint32_t p : members(group)) {
      const Patch& patch = mesh_.patches[p];
      result_.windings[p] = patch.orientable ? usual_winding(patch, !parts_of(p).empty()) : 1;
      even = even && (patch.is_even() || !patch.orientable);
      empty = empty && patch.is_even() && patch.least_net == 0;
    }
    group.double_sided = empty;
    if (empty) take_one_side(group);
    group.inconsistent = empty || !even || !is_balanced(group);
  }

  void take_one_side(const Group& group) {
    bool any = false;
    for (const std::uint32_t p : members(group)) {
      result_.windings[p] = winding_of_one_side(mesh_.patches[p], !parts_of(p).empty());
      any = any || result_.windings[p] != 0;
    }
    if (any) return;
    // Every patch is there twice in both directions.
    for (const std::uint32_t p : members(group))
      result_.windings[p] = 1;
  }

  [[nodiscard]] bool is_balanced(const Group& group) {
    for (const std::uint32_t p : members(group)) {
      for (const JunctionPart& part : parts_of(p))
        residuals_[part.junction] += part.sides * result_.windings[p];
    }
    bool balanced = true;
    for (const std::uint32_t p : members(group)) {
      for (const JunctionPart& part : parts_of(p)) {
        balanced = balanced && residuals_[part.junction] == 0;
      }
    }
    for (const std::uint32_t p : members(group)) {
      for (const JunctionPart& part : parts_of(p))
        residuals_[part.junction] = 0;
    }
    return balanced;
  }

  // Turns patches without a clear majority of facets to match the patches that they meet, the surest first.
  void settle_signs(const Group& group) {
    std::uint32_t surest = members(group).front();
    for (const std::uint32_t p : members(group)) {
      const Patch& patch = mesh_.patches[p];
      if (patch.area > mesh_.patches[surest].area) surest = p;
      if (!group.double_sided && (patch.is_even() || !patch.orientable || is_clear(patch))) settle(p);
    }
    if (!settled_[surest] && open_.empty()) settle(surest);
    while (!open_.empty()) {
      const Candidate candidate = open_.top();
      open_.pop();
      if (settled_[candidate.patch]) continue;
      const int margin = margin_of(candidate.patch);
      if (std::abs(margin) < candidate.margin) {
        open_.push({std::abs(margin), mesh_.patches[candidate.patch].area, candidate.patch});
        continue;
      }
      if (margin < 0) result_.windings[candidate.patch] = -result_.windings[candidate.patch];
      settle(candidate.patch);
    }
    for (const std::uint32_t p : members(group)) {
      if (!settled_[p]) settle(p);
    }
  }

  void settle(std::uint32_t patch) {
    settled_[patch] = true;
    for (const JunctionPart& part : parts_of(patch))
      residuals_[part.junction] += part.sides * result_.windings[patch];
    for (const JunctionPart& part : parts_of(patch)) {
      for (const JunctionPart& other : parts_at(part.junction)) {
        if (!settled_[other.patch])
          open_.push({std::abs(margin_of(other.patch)), mesh_.patches[other.patch].area, other.patch});
      }
    }
  }

  // Returns by how many sides the junctions would be farther from balance with the patch turned the other
  // way.
  [[nodiscard]] int margin_of(std::uint32_t patch) const {
    int margin = 0;
    for (const JunctionPart& part : parts_of(patch)) {
      const int change = part.sides * result_.windings[patch], before = residuals_[part.junction];
      margin += std::abs(before - change) - std::abs(before + change);
    }
    return margin;
  }

  // Returns how much farther from balance (nearer: below 0) the junctions are with another winding of a
  // settled patch.
  [[nodiscard]] int cost_of(std::uint32_t patch, std::int32_t winding) const {
    int cost = 0;
    for (const JunctionPart& part : parts_of(patch)) {
      const int change = part.sides * (winding - result_.windings[patch]), now = residuals_[part.junction];
      cost += std::abs(now + change) - std::abs(now);
    }
    return cost;
  }

  struct Change {
    int cost;
    std::int64_t changes;  // additional facets to be changed
    double area;
    std::uint32_t patch;
    std::int32_t winding;
  };

  // True if `a` is better. Of two that are equal, neither is, so that the first one found stays.
  [[nodiscard]] static bool better(const Change& a, const Change& b) {
    return std::tie(a.cost, a.changes, a.area, a.patch) < std::tie(b.cost, b.changes, b.area, b.patch);
  }

  // Returns the best winding for a patch, which may be its present one. The winding can be 0 only if the
  // patch has no boundary edges and at most half of the group's area.
  [[nodiscard]] Change best_change(std::uint32_t p, double group_area) const {
    const Patch& patch = mesh_.patches[p];
    Change best{0, 0, patch.area, p, result_.windings[p]};
    if (!patch.orientable || parts_of(p).empty()) return best;
    const std::int64_t before = changes_for(patch, result_.windings[p]);
    const std::int32_t most = std::clamp<std::int32_t>(patch.most_copies, 1, 2);
    for (std::int32_t winding = -most; winding <= most; ++winding) {
      if (winding == 0 && (patch.boundary_edges > 0 || patch.area > group_area / 2)) continue;
      const Change change{cost_of(p, winding), changes_for(patch, winding) - before, patch.area, p, winding};
      if (better(change, best)) best = change;
    }
    return best;
  }

  void improve(const Group& group) {
    double area = 0;
    for (const std::uint32_t p : members(group))
      area += mesh_.patches[p].area;
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      std::vector<Change> changes;
      for (const std::uint32_t p : members(group)) {
        const Change change = best_change(p, area);
        if (change.winding != result_.windings[p]) changes.push_back(change);
      }
      if (changes.empty()) return;
      std::sort(changes.begin(), changes.end(), better);
      for (const Change& change : changes)
        apply(best_change(change.patch, area));
    }
  }

  void apply(const Change& change) {
    for (const JunctionPart& part : parts_of(change.patch))
      residuals_[part.junction] += part.sides * (change.winding - result_.windings[change.patch]);
    result_.windings[change.patch] = change.winding;
  }

  struct Candidate {
    int margin;
    double area;
    std::uint32_t patch;
    bool operator<(const Candidate& other) const {
      return std::tie(margin, area, other.patch) < std::tie(other.margin, other.area, patch);
    }
  };

  const FacetPatches& mesh_;
  PatchGroups result_;
  // offsets: by patch in parts_of_, by junction in junction_parts
  std::vector<std::uint32_t> first_part_, first_at_;
  std::vector<JunctionPart> parts_of_;   // by patch
  std::vector<std::int32_t> residuals_;  // by junction: surplus of sides of the settled patches
  std::vector<bool> settled_;
  std::priority_queue<Candidate> open_;
};

}  // namespace

PatchGroups balance_patches(const FacetPatches& mesh) {
  return PatchBalance(mesh).balance();
}

}  // namespace contourd
