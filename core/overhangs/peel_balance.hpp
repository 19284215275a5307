// Balances peel against contacts. A body that hangs on contacts alone is peeled off the film with every
// layer, so this compares each body's area with the strength of the contacts that hold it. A body with too
// few contacts gets more, each where its underside is farthest from the existing ones. Not thread-safe.
//
// The film lets go from a layer's rim inwards, so at most half of a layer pulls at once; the body's contacts
// share that half evenly.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

class PeelBalance {
 public:
  // Each contact holds `holds_pixels` of a layer's area. REQUIRES: holds_pixels > 0.
  explicit PeelBalance(double holds_pixels);

  // Adds the next layer's areas and merges the bodies that became one in it.
  void add_layer(const LayerParts& parts);
  // Marks a body as standing on the plate, which holds it and all bodies that it meets.
  void stand(std::uint32_t body) { bodies_[body].stands = true; }
  [[nodiscard]] bool stands(std::uint32_t body) const { return bodies_[body].stands; }
  void add_contact(SweepPixel at, std::uint32_t body);

  // A place on a body's underside where a contact can be added.
  struct Place {
    SweepPixel at;
    std::int32_t layer = 0;  // layer in which the body begins there
    bool steep = false;      // taken only if no other places are left
  };
  void add_place(const Place& place, std::uint32_t body);

  // True if a body of the last layer has too few contacts. REQUIRES: `body` is the body of one of the layer's
  // parts.
  [[nodiscard]] bool overloaded(std::uint32_t body) const;
  // Returns the best place for another contact of the body; nullopt if no place is left.
  [[nodiscard]] std::optional<Place> take_place(std::uint32_t body);
  // Records the load that each contact bears in the last layer. Call it once the layer has all its contacts.
  void settle();

  // Returns the largest load that a contact of the body ever had to bear, in pixels of a layer.
  [[nodiscard]] double load_pixels(std::uint32_t body) const;

 private:
  struct Body {
    bool stands = false;
    std::uint32_t merged_into;  // the body's own number: not merged
    std::int64_t contacts = 0;
    std::int64_t pixels = 0;  // area in the last layer
    double load_pixels = 0;
    std::vector<std::uint32_t> places;
  };
  struct RankedPlace {
    Place place;
    std::uint32_t contacts_seen = 0;
    double squared_distance;  // to the nearest contact seen
  };
  [[nodiscard]] double pulled_pixels(const Body& body) const;
  void merge(std::uint32_t body, std::uint32_t into);
  void look_at_contacts(RankedPlace& place) const;

  double holds_pixels_;
  std::vector<Body> bodies_;
  std::vector<std::uint32_t> present_;  // bodies of the last layer, each once
  std::vector<SweepPixel> contacts_;
  std::vector<RankedPlace> places_;
};

}  // namespace contourd
