// Balances peel against what holds a body. A body is peeled off the film with every layer: its bearings must
// bear the pull of the body's whole layer, and of each part of it, since parts let go one after the other,
// and the pull's moment about them. An overloaded body gets more contacts: where its underside is farthest
// from the existing ones if the area pulls too hard, and far out along the pull's lever if that is too long.
// Not thread-safe.
//
// The film lets go from a layer's rim inwards, so at most half of a layer pulls at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/overhangs/bearing_group.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

class PeelBalance {
 public:
  // Contacts farther apart than `spacing_pixels` are as good as any. REQUIRES: a tip's strength and diameter
  // are positive.
  PeelBalance(const TipStrength& tip, double spacing_pixels);

  // Adds the next layer's areas and merges the bodies that became one in it.
  void add_layer(const LayerParts& parts);
  // Marks all bodies of the last layer as standing on the plate with their pixels in it.
  void stand(const LayerParts& parts, const MaskRuns& lit);
  // Adds the next contact: they are numbered from 0.
  void add_contact(SweepPixel at, std::uint32_t body);

  // A place on a body's underside where a contact can be added.
  struct Place {
    SweepPixel at;
    std::int32_t layer = 0;  // layer in which the body begins there
    bool steep = false;      // against a pull without lever taken only if no other places are left
  };
  void add_place(const Place& place, std::uint32_t body);

  // A pull of the last layer on a body.
  struct Pull {
    std::uint32_t body;
    PeelPull force;
  };
  // Returns the pulls of the last layer: one for each body, and one for each part of a body
  // with several parts.
  [[nodiscard]] std::span<const Pull> pulls() const { return pulls_; }

  // True if the body's bearings cannot bear the pull.
  [[nodiscard]] bool overloaded(const Pull& pull) const;
  // Returns the best place for another contact against the pull; nullopt if none would help.
  [[nodiscard]] std::optional<Place> place_against(const Pull& pull);
  // Records the load that each contact bears in the last layer. Call it once the layer has all its contacts.
  void settle();

  // Returns the largest load that a contact ever had to bear, in pixels of a layer.
  [[nodiscard]] double load_pixels(std::size_t contact) const { return contacts_[contact].load_pixels; }

 private:
  // A part of the last layer, or all parts of a body: pixels, and the sums of their columns and rows.
  struct PulledArea {
    std::uint32_t body;
    std::int64_t pixels = 0, columns = 0, rows = 0;
    PulledArea& operator+=(const PulledArea& other);
    [[nodiscard]] Pull pull() const;
  };
  struct Body {
    BearingGroup bearings;
    std::vector<std::uint32_t> places;
  };
  struct Contact {
    SweepPixel at;
    double load_pixels = 0;
  };
  struct RankedPlace {
    Place place;
    std::uint32_t contacts_seen = 0;
    double squared_distance;  // to the nearest contact seen
  };
  void merge(std::uint32_t body, std::uint32_t into);
  void look_at_contacts(RankedPlace& place) const;
  [[nodiscard]] bool is_taken(RankedPlace& place) const;
  [[nodiscard]] std::optional<Place> farthest_place(const Body& body);
  struct StrainAt {
    Place place;
    double strain;
  };
  // Returns the place at which one more tip leaves the least strain.
  [[nodiscard]] std::optional<StrainAt> least_strain(const Body& body, const BearingGroup& bearings,
                                                     const PeelPull& pull);
  [[nodiscard]] std::optional<Place> place_on_lever(const Body& body, const PeelPull& pull);
  [[nodiscard]] std::optional<Place> strongest_place(const Body& body, const PeelPull& pull);

  TipStrength tip_;
  double spacing_pixels_;
  std::vector<Body> bodies_;
  std::vector<PulledArea> parts_;  // of the last layer, body by body
  std::vector<Pull> pulls_;        // of the last layer's bodies, then of their parts
  std::size_t totals_ = 0;         // pulls of bodies
  std::vector<Contact> contacts_;
  std::vector<RankedPlace> places_;
};

}  // namespace contourd
