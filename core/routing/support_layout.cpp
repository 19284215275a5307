#include "core/routing/support_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/clearance/clearance_field.hpp"
#include "core/clearance/support_path_field.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/routing/frail_contacts.hpp"
#include "core/routing/missed_islands.hpp"
#include "core/routing/sealed_hollows.hpp"
#include "core/routing/support_loads.hpp"
#include "core/routing/support_routing.hpp"
#include "core/routing/support_solids.hpp"
#include "core/routing/support_tips.hpp"
#include "core/routing/support_volume.hpp"
#include "core/support/plate_segment.hpp"

namespace contourd {
namespace {

// How high an island may be held: in its first layer only, or up to two layers of the sweep higher, which
// then hang free until the support reaches them.
enum class IslandHold { FromItsFirstLayer, Higher };

constexpr std::array<double, 3> kDistances_mm{0.3, 0.6, 0.9};
// How far the surface may lie above or below the contact.
constexpr double kAcross_mm = 0.6;

// True if the material at height z is continuous from one place to the other.
bool is_connected(const PlatePoint& from, const PlatePoint& to, double z, const LitLayers& layers) {
  const int steps = static_cast<int>(std::hypot(to.x - from.x, to.y - from.y) / layers.pitch_mm()) + 1;
  for (int i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    if (!layers.is_lit({from.x + (to.x - from.x) * part, from.y + (to.y - from.y) * part, z})) return false;
  }
  return true;
}

// Returns copies of the contact up to a millimetre beside it, from near to far: on the model's underside,
// where the material is connected to the contact's. An island's neighbours are connected to it in its first
// layer with IslandHold::FromItsFirstLayer.
std::vector<SupportContact> neighbours_of(const SupportContact& contact, const LitLayers& layers,
                                          IslandHold hold) {
  const bool is_island = contact.cause == ContactCause::Island;
  const bool in_first_layer = is_island && hold == IslandHold::FromItsFirstLayer;
  // A layer is lit from its middle up, so an underside within half a step of the contact is in the same
  // layer.
  const double layers_up = in_first_layer ? 0.5 : 2;
  const double up = is_island ? layers_up * layers.step_mm() : kAcross_mm;
  const double joined = (in_first_layer ? 0.5 : 1.5) * layers.step_mm();
  std::vector<SupportContact> neighbours;
  for (const double distance : kDistances_mm) {
    for (const Point& direction : kAround) {
      const PlatePoint low{contact.place.x + direction.x * distance, contact.place.y + direction.y * distance,
                           contact.place.z - kAcross_mm};
      const std::optional<double> underside = layers.underside_above(low, kAcross_mm + up);
      if (!underside) continue;
      const PlatePoint place{low.x, low.y, *underside};
      const double inside = std::max(place.z, contact.place.z) + joined;
      if (!is_connected(contact.place, place, inside, layers)) continue;
      SupportContact& neighbour = neighbours.emplace_back(contact);
      neighbour.place = place;
      neighbour.outward = {0, 0, -1};
    }
  }
  return neighbours;
}

// Paths lead at most this far around the places that are held.
constexpr double kAround_mm = 15;
// Width of a branch where there is little room, relative to the usual branch.
constexpr double kLeastWidth = 0.5;

ClearanceField::Region region_around(const std::vector<SupportContact>& contacts) {
  const PlatePoint& first = contacts.front().place;
  ClearanceField::Region region{first.x, first.x, first.y, first.y, 0};
  for (const SupportContact& contact : contacts) {
    const PlatePoint& at = contact.place;
    region = {std::min(region.left, at.x), std::max(region.right, at.x), std::min(region.front, at.y),
              std::max(region.back, at.y), std::max(region.top, at.z)};
  }
  return {region.left - kAround_mm, region.right + kAround_mm, region.front - kAround_mm,
          region.back + kAround_mm, region.top + ClearanceField::kGreatest_mm};
}

void from_the_plate_up(std::vector<SupportContact>& contacts) {
  std::ranges::stable_sort(contacts, [](const SupportContact& a, const SupportContact& b) {
    return std::tuple(a.place.z, a.place.y, a.place.x) < std::tuple(b.place.z, b.place.y, b.place.x);
  });
}

// Removes the contacts beyond the maximum and returns them as unheld.
std::vector<UnheldPlace> set_aside(std::vector<SupportContact>& contacts) {
  std::vector<UnheldPlace> beyond;
  for (std::size_t i = kMostContacts; i < contacts.size(); ++i)
    beyond.push_back(
        {contacts[i], "the limit of 4096 contacts is reached below it, and nothing above it is held either"});
  contacts.resize(std::min(contacts.size(), kMostContacts));
  return beyond;
}

void append(SupportTree more, SupportTree& tree) {
  const auto first = static_cast<std::uint32_t>(tree.nodes.size());
  for (SupportNode& node : more.nodes) {
    if (node.below != SupportNode::kNone) node.below += first;
    tree.nodes.push_back(node);
  }
  for (SupportTree::HeldTip& held : more.tips) {
    held.node += first;
    tree.tips.push_back(std::move(held));
  }
}

// Holds the contacts one after the other, at their place or else beside it: by paths to the plate, or to a
// model if no path reaches the plate.
class SupportLayout {
 public:
  SupportLayout(const ClearanceField& field, const SupportSettings& settings, const std::stop_token& stop)
      : field_(field), settings_(settings), stop_(stop) {}

  // Returns the contacts that it cannot hold. With IslandHold::Higher it only tries places beside islands:
  // everything else was tried before.
  [[nodiscard]] std::vector<SupportContact> hold(const std::vector<SupportContact>& contacts,
                                                 SupportPathField::End end, IslandHold islands) {
    const SupportPathField& paths = paths_to(end, contacts);
    const SupportTips tips(field_, paths, settings_);
    SupportRouting routing(field_, paths, settings_);
    std::vector<SupportContact> unheld;
    const auto is_held = [&](const SupportContact& contact) {
      std::optional<SupportTip> tip = tips.tip_at(contact);
      if (!tip) return false;
      if (fills_gap(*tip)) {
        // The support would join two parts that may have to move, such as those of a hinge. An island, and a
        // layer whose peel nothing else bears, would be lost without it.
        if (contact.cause == ContactCause::Overhang) return false;
        in_gaps_.push_back(contact);
      }
      routing.add(std::move(*tip), static_cast<std::uint32_t>(held_.size()), contact.load_mm2);
      held_.push_back(contact);
      return true;
    };
    const auto is_held_beside = [&](const SupportContact& contact) {
      return std::ranges::any_of(neighbours_of(contact, field_.layers(), islands), is_held);
    };
    for (const SupportContact& contact : contacts) {
      if (stop_.stop_requested()) return unheld;
      const bool held = islands == IslandHold::FromItsFirstLayer
                            ? is_held(contact) || is_held_beside(contact)
                            : contact.cause == ContactCause::Island && is_held_beside(contact);
      if (!held) unheld.push_back(contact);
    }
    append(routing.lead_down(stop_), tree_);
    return unheld;
  }

  [[nodiscard]] Supports supports() {
    Supports supports;
    thicken_branches(tree_, field_, settings_);
    std::vector<SupportPrimitive> solids = solids_of(tree_, field_, settings_);
    for (const SupportNode& node : tree_.nodes) {
      if (node.below != SupportNode::kNone) ++supports.branches;
      if (node.below == SupportNode::kNone) ++(node.place.z == 0 ? supports.feet : supports.feet_on_models);
    }
    from_the_plate_up(held_);
    supports.contacts = std::move(held_);
    from_the_plate_up(in_gaps_);
    supports.in_gaps = std::move(in_gaps_);
    if (!solids.empty()) supports.structure = std::make_shared<const SupportStructure>(std::move(solids));
    return supports;
  }

 private:
  // True if the tip crosses a gap between models that is narrower than a pillar.
  [[nodiscard]] bool fills_gap(const SupportTip& tip) const {
    return tip.path.stretches.empty() && tip.joint.z > 0 &&
           tip.at.z - tip.joint.z < settings_.pillar_diameter.count();
  }

  // Creates the path field on first use, for the contacts of that call: later contacts are a subset of them.
  const SupportPathField& paths_to(SupportPathField::End end, const std::vector<SupportContact>& contacts) {
    std::optional<SupportPathField>& paths = end == SupportPathField::End::Plate ? to_plate_ : to_models_;
    if (!paths) {
      const double usual = settings_.pillar_diameter.count() / 2;
      const PathWidths widths{usual, usual * kLeastWidth, settings_.tip_diameter.count() / 2};
      paths.emplace(field_, SupportPathField::Settings{widths, end, contacts}, stop_);
    }
    return *paths;
  }

  const ClearanceField& field_;
  SupportSettings settings_;
  std::stop_token stop_;
  std::optional<SupportPathField> to_plate_, to_models_;
  SupportTree tree_;
  std::vector<SupportContact> held_, in_gaps_;
};

// Returns the sealed hollows if a contact may lie in one, with material straight below it.
std::optional<SealedHollows> hollows_around(const std::vector<SupportContact>& contacts,
                                            const LitLayers& layers) {
  const bool may_be = std::ranges::any_of(contacts, [&](const SupportContact& contact) {
    const PlatePoint& at = contact.place;
    return layers.top_below({at.x, at.y, at.z - 2 * layers.step_mm()}, at.z).has_value();
  });
  if (!may_be) return std::nullopt;
  return SealedHollows(layers);
}

// True if the contact holds an overhang over a gap that is narrower than a pillar.
bool is_over_narrow_gap(const SupportContact& contact, const LitLayers& layers,
                        const SupportSettings& settings) {
  const PlatePoint beneath{contact.place.x, contact.place.y, contact.place.z - 1.5 * layers.step_mm()};
  return contact.cause == ContactCause::Overhang && !layers.is_lit(beneath) &&
         layers.top_below(beneath, settings.pillar_diameter.count()).has_value();
}

}  // namespace

std::optional<Supports> lay_out_supports(std::vector<SupportContact> contacts, const LitLayers& layers,
                                         const DisplayGeometry& build_area, const SupportSettings& settings,
                                         const std::stop_token& stop) {
  if (contacts.empty()) return Supports{};
  const std::optional<SealedHollows> hollows = hollows_around(contacts, layers);
  if (hollows)
    std::erase_if(contacts, [&](const SupportContact& contact) {
      return hollows->is_bridged(contact, settings.bridge);
    });
  if (contacts.empty()) return Supports{};
  from_the_plate_up(contacts);
  const std::vector<UnheldPlace> beyond = set_aside(contacts);
  const ClearanceField field(layers, region_around(contacts), {build_area, settings.clearance.count()}, stop);
  SupportLayout layout(field, settings, stop);
  std::vector<SupportContact> unheld = std::move(contacts);
  for (const IslandHold islands : {IslandHold::FromItsFirstLayer, IslandHold::Higher}) {
    for (const SupportPathField::End end : {SupportPathField::End::Plate, SupportPathField::End::Model}) {
      if (!unheld.empty()) unheld = layout.hold(unheld, end, islands);
    }
  }
  Supports supports = layout.supports();
  if (supports.structure) supports.volume_mm3 = volume_beside_models_mm3(supports.structure, layers, stop);
  if (stop.stop_requested()) return std::nullopt;
  supports.on_hairs = frail_contacts(supports.contacts, layers, settings);
  if (hollows)
    std::ranges::copy_if(supports.contacts, std::back_inserter(supports.in_hollows),
                         [&](const SupportContact& contact) { return hollows->holds(contact.place); });
  for (const SupportContact& contact : unheld) {
    if (is_over_narrow_gap(contact, layers, settings)) {
      supports.over_gaps.push_back(contact);
    } else {
      supports.unheld.push_back({contact, "no path leads to the plate or to a place on the model"});
    }
  }
  supports.unheld.insert(supports.unheld.end(), beyond.begin(), beyond.end());
  return supports;
}

std::optional<Supports> make_supports(const SupportRequest& request, const std::stop_token& stop) {
  if (request.models.empty())
    return Supports{.carriers = static_cast<std::uint32_t>(request.carriers.size())};
  LitLayers layers, all_layers;
  std::optional<HeldPlaces> places = find_overhangs(request, layers, stop);
  if (!places) return std::nullopt;
  if (!request.carriers.empty()) {
    SupportRequest everything = request;
    everything.models.insert(everything.models.end(), request.carriers.begin(), request.carriers.end());
    if (!find_overhangs(everything, all_layers, stop)) return std::nullopt;
  }
  const auto lay_out = [&] {
    return lay_out_supports(places->contacts, request.carriers.empty() ? layers : all_layers, request.display,
                            request.settings, stop);
  };
  std::optional<Supports> supports = lay_out();
  if (!supports) return std::nullopt;
  PrintedIslands islands = missed_islands(request, *supports, stop);
  if (!islands.missed.empty()) {
    places->contacts.insert(places->contacts.end(), islands.missed.begin(), islands.missed.end());
    supports = lay_out();
    if (!supports) return std::nullopt;
    for (const SupportContact& contact : missed_islands(request, *supports, stop).missed)
      supports->unheld.push_back({contact, "no support reaches its first layer"});
  }
  if (stop.stop_requested()) return std::nullopt;
  supports->resting = std::move(islands.resting);
  supports->carriers = static_cast<std::uint32_t>(request.carriers.size());
  return supports;
}

}  // namespace contourd
