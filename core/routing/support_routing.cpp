#include "core/routing/support_routing.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/routing/support_loads.hpp"

namespace contourd {
namespace {

// Branches meet at least this high above the feet.
constexpr double kAboveFeet_mm = 0.2;
// Branches that cannot meet at 45 degrees because of an obstacle may meet this much further down.
constexpr std::array<double, 4> kDrops_mm{0, 1, 2.5, 5};
// The length of a branch down to its next junction is unknown in advance: estimates assume at most this.
constexpr double kUsualLength_mm = 10;

double frustum_mm3(double one, double other, double height) {
  return std::numbers::pi / 3 * height * (one * one + one * other + other * other);
}

PlatePoint between(const PlatePoint& a, const PlatePoint& b, double part, double z) {
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), z};
}

}  // namespace

bool SupportRouting::Pair::operator<(const Pair& pair) const {
  // Pairs that save equally much are ordered by their indices.
  return std::tuple(saved_mm3, pair.one, pair.other) < std::tuple(pair.saved_mm3, one, other);
}

SupportRouting::SupportRouting(const ClearanceField& field, const SupportPathField& paths,
                               const SupportSettings& settings)
    : field_(field),
      paths_(paths),
      settings_(settings),
      foot_mm3_(frustum_mm3(settings.foot_diameter.count() / 2, settings.pillar_diameter.count() / 2,
                            settings.foot_height.count())) {}

const SupportNode& SupportRouting::node_of(std::uint32_t end) const {
  return tree_.nodes[ends_[end].node];
}

void SupportRouting::add(SupportTip tip, std::uint32_t contact, double load_mm2) {
  const auto node = static_cast<std::uint32_t>(tree_.nodes.size());
  tree_.nodes.push_back({tip.joint, SupportNode::kNone, load_mm2, tip.radius_mm});
  if (tip.path.stretches.empty()) {
    tree_.nodes.back().foot = SupportFoot::OfTip;
  } else {
    open(node, tip.path);
  }
  tree_.tips.push_back({std::move(tip), contact, node});
}

void SupportRouting::open(std::uint32_t node, SupportPath path) {
  ends_.push_back({node, std::move(path)});
}

// Returns the resin of a branch.
double SupportRouting::resin_of(double load_mm2, double length_mm) const {
  const double radius = branch_radius(load_mm2, std::min(length_mm, kUsualLength_mm), settings_);
  return std::numbers::pi * radius * radius * length_mm;
}

// Returns the resin of a branch to the plate, including its foot.
double SupportRouting::resin_below(double load_mm2, double length_mm) const {
  return resin_of(load_mm2, length_mm) + foot_mm3_;
}

void SupportRouting::look_for_partners(std::uint32_t end) {
  const PlatePoint place = node_of(end).place;
  std::vector<std::pair<double, std::uint32_t>> near;
  for (std::uint32_t other = 0; other < ends_.size(); ++other) {
    if (other == end || !ends_[other].open) continue;
    const PlatePoint& there = node_of(other).place;
    const double apart = level_distance(place, there);
    if (apart < place.z + there.z - 2 * settings_.foot_height.count()) near.emplace_back(apart, other);
  }
  const std::size_t count = std::min(near.size(), kPartners);
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
  for (std::size_t i = 0; i < count; ++i)
    push_pair(std::min(end, near[i].second), std::max(end, near[i].second), 0);
}

void SupportRouting::push_pair(std::uint32_t one, std::uint32_t other, std::uint32_t rank) {
  const std::vector<Meeting> meetings = meetings_of(one, other);
  if (rank < meetings.size()) pairs_.push({meetings[rank].saved_mm3, one, other, rank});
}

// Returns the places where two ends can meet and save resin, the greatest saving first.
std::vector<SupportRouting::Meeting> SupportRouting::meetings_of(std::uint32_t one,
                                                                 std::uint32_t other) const {
  const SupportNode& a = node_of(one);
  const SupportNode& b = node_of(other);
  const bool first_higher = a.place.z >= b.place.z;
  const SupportNode& high = first_higher ? a : b;
  const SupportNode& low = first_higher ? b : a;
  const double apart = level_distance(high.place, low.place);
  const double least_z = settings_.foot_height.count() + kAboveFeet_mm;
  const double alone = resin_below(a.load_mm2, ends_[one].path.length_mm) +
                       resin_below(b.load_mm2, ends_[other].path.length_mm);
  std::vector<Meeting> meetings;
  const auto consider = [&](const PlatePoint& place, double path_mm) {
    const double together = resin_of(high.load_mm2, PlateSegment{high.place, place}.length()) +
                            resin_of(low.load_mm2, PlateSegment{low.place, place}.length()) +
                            resin_below(a.load_mm2 + b.load_mm2, path_mm);
    if (together < alone) meetings.push_back({alone - together, place});
  };
  if (high.place.z - low.place.z > std::max(apart, 1e-3)) {
    consider(low.place, ends_[first_higher ? other : one].path.length_mm);
  }
  const double meet_z = std::min((high.place.z + low.place.z - apart) / 2, low.place.z - 0.01);
  const double part = apart > 0 ? std::min((high.place.z - meet_z) / apart, 1.0) : 0;
  for (const double drop : kDrops_mm) {
    const std::array<PlatePoint, 4> places{
        between(high.place, low.place, part, meet_z - drop),
        between(high.place, low.place, 0.5, std::min(meet_z, low.place.z - apart / 2) - drop),
        between(high.place, low.place, 1, std::min(high.place.z - apart, low.place.z - 0.01) - drop),
        between(high.place, low.place, 0, std::min(low.place.z - apart, low.place.z - 0.01) - drop)};
    for (const PlatePoint& place : places) {
      if (place.z < least_z) continue;
      if (const std::optional<double> path = paths_.length_from(place)) consider(place, *path);
    }
  }
  std::stable_sort(meetings.begin(), meetings.end(),
                   [](const Meeting& m, const Meeting& n) { return m.saved_mm3 > n.saved_mm3; });
  return meetings;
}

// Returns the radius of an end's branch down to a place.
double SupportRouting::width_of(std::uint32_t end, const PlatePoint& to) const {
  const SupportNode& node = node_of(end);
  const double length = PlateSegment{node.place, to}.length();
  return node.radius_mm < settings_.pillar_diameter.count() / 2
             ? node.radius_mm
             : branch_radius(node.load_mm2, length, settings_);
}

bool SupportRouting::meet(const Pair& pair, const PlatePoint& place) {
  for (const std::uint32_t end : {pair.one, pair.other}) {
    const PlateSegment branch{node_of(end).place, place};
    if (branch.length() == 0) continue;
    if (!branch.leads_down() || !field_.has_room(branch, width_of(end, place))) return false;
  }
  for (const auto& [from, into] : {std::pair(pair.one, pair.other), std::pair(pair.other, pair.one)}) {
    if (node_of(into).place == place) {
      join(from, into);
      return true;
    }
  }
  std::optional<SupportPath> path = paths_.path_from(place);
  if (!path) return false;
  const auto node = static_cast<std::uint32_t>(tree_.nodes.size());
  const double usual = settings_.pillar_diameter.count() / 2;
  tree_.nodes.push_back({place, SupportNode::kNone, 0, usual});
  open(node, std::move(*path));
  const auto into = static_cast<std::uint32_t>(ends_.size() - 1);
  join(pair.one, into);
  join(pair.other, into);
  look_for_partners(into);
  return true;
}

// Ends a branch at another open end, which continues for both.
void SupportRouting::join(std::uint32_t from, std::uint32_t into) {
  SupportNode& node = tree_.nodes[ends_[from].node];
  SupportNode& below = tree_.nodes[ends_[into].node];
  node.below = ends_[into].node;
  node.radius_mm = std::min(node.radius_mm, settings_.pillar_diameter.count() / 2);
  below.load_mm2 += node.load_mm2;
  ends_[from].open = false;
}

// Returns the highest end whose path is not straight; nullopt if there is none.
std::optional<std::uint32_t> SupportRouting::next_to_go_on() const {
  std::optional<std::uint32_t> highest;
  for (std::uint32_t end = 0; end < ends_.size(); ++end) {
    if (!ends_[end].open || ends_[end].path.stretches.size() < 2) continue;
    if (!highest || node_of(end).place.z > node_of(*highest).place.z) highest = end;
  }
  return highest;
}

void SupportRouting::go_on(std::uint32_t end) {
  SupportPath path = std::move(ends_[end].path);
  const SupportPath::Stretch first = path.stretches.front();
  path.length_mm -= PlateSegment{node_of(end).place, first.end}.length();
  path.stretches.erase(path.stretches.begin());
  add_below(ends_[end].node, first.end, first.radius_mm);
  tree_.nodes.back().radius_mm = path.stretches.front().radius_mm;
  ends_[end].open = false;
  open(static_cast<std::uint32_t>(tree_.nodes.size() - 1), std::move(path));
  look_for_partners(static_cast<std::uint32_t>(ends_.size() - 1));
}

void SupportRouting::end(OpenEnd& end) {
  const SupportPath::Stretch last = end.path.stretches.front();
  add_below(end.node, last.end, last.radius_mm);
  if (end.path.landing) {
    add_below(static_cast<std::uint32_t>(tree_.nodes.size() - 1), *end.path.landing, last.radius_mm);
  }
  tree_.nodes.back().foot = end.path.landing ? SupportFoot::OnModel : SupportFoot::OnPlate;
  end.open = false;
}

void SupportRouting::add_below(std::uint32_t node, const PlatePoint& place, double radius_mm) {
  SupportNode& above = tree_.nodes[node];
  above.below = static_cast<std::uint32_t>(tree_.nodes.size());
  above.radius_mm = radius_mm;
  tree_.nodes.push_back({place, SupportNode::kNone, above.load_mm2, radius_mm});
}

SupportTree SupportRouting::lead_down(const std::stop_token& stop) {
  for (std::uint32_t end = 0; end < ends_.size(); ++end)
    look_for_partners(end);
  while (!stop.stop_requested()) {
    if (pairs_.empty()) {
      const std::optional<std::uint32_t> end = next_to_go_on();
      if (!end) break;
      go_on(*end);
      continue;
    }
    const Pair pair = pairs_.top();
    pairs_.pop();
    if (!ends_[pair.one].open || !ends_[pair.other].open) continue;
    const std::vector<Meeting> meetings = meetings_of(pair.one, pair.other);
    if (pair.rank >= meetings.size()) continue;
    // Loads may have been added since the pair was pushed.
    if (meetings[pair.rank].saved_mm3 < pair.saved_mm3 || !meet(pair, meetings[pair.rank].place)) {
      const bool same = meetings[pair.rank].saved_mm3 < pair.saved_mm3;
      push_pair(pair.one, pair.other, same ? pair.rank : pair.rank + 1);
    }
  }
  for (OpenEnd& each : ends_) {
    if (each.open) end(each);
  }
  return std::move(tree_);
}

}  // namespace contourd
