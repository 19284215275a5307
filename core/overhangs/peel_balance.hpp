// What hangs on contacts alone is peeled off the film with every layer: the area of each body against the
// strength of the contacts that hold it. Where they are too few, more belong where its underside is farthest
// from all of them. Not thread-safe.
//
// The film lets go from a layer's rim inwards, so that never more than half of a layer pulls at once; that
// half is shared evenly by the contacts of its body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

class PeelBalance {
 public:
  // REQUIRES: holds_pixels > 0: of a layer's area, by each contact.
  explicit PeelBalance(double holds_pixels);

  // The next layer's areas, and what bodies have become one in it.
  void add_layer(const LayerParts& parts);
  // A body that stands on the plate is held by that, and all that it meets.
  void stand(std::uint32_t body) { bodies_[body].stands = true; }
  [[nodiscard]] bool stands(std::uint32_t body) const { return bodies_[body].stands; }
  void add_contact(SweepPixel at, std::uint32_t body);

  // A place of a body's underside that a contact can take.
  struct Place {
    SweepPixel at;
    std::int32_t layer = 0;  // at which the body begins there
    bool steep = false;      // taken only where no others are left
  };
  void add_place(const Place& place, std::uint32_t body);

  // Whether a body of the last layer has too few contacts. REQUIRES: it is a part's.
  [[nodiscard]] bool overloaded(std::uint32_t body) const;
  // Where the body is to get one. Nothing where no place is left.
  [[nodiscard]] std::optional<Place> take_place(std::uint32_t body);
  // Once the last layer has its contacts: what each has to hold in it counts.
  void settle();

  // The most that a contact of the body ever had to hold, in pixels of a layer.
  [[nodiscard]] double load_pixels(std::uint32_t body) const;

 private:
  struct Body {
    bool stands = false;
    std::uint32_t merged_into;  // itself: none
    std::int64_t contacts = 0;
    std::int64_t pixels = 0;  // of the last layer
    double load_pixels = 0;
    std::vector<std::uint32_t> places;
  };
  struct RankedPlace {
    Place place;
    std::uint32_t contacts_seen = 0;
    double squared_distance;  // to the nearest of those
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
