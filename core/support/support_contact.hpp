// A place at which a support has to hold a print, and the cause. Values; thread-safe as any value is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/model/placement.hpp"

namespace contourd {

// A point above the plate, in millimetres: x and y from the plate's centre as seen from above, z above the
// plate.
struct PlatePoint {
  double x = 0, y = 0, z = 0;
  bool operator==(const PlatePoint&) const = default;
};

// Maximum number of contacts that get a support; a mesh of noise would have a million.
inline constexpr std::size_t kMostContacts = 4096;

enum class ContactCause : std::uint8_t {
  Island,    // a part that begins with nothing under it
  Overhang,  // an edge too far from the material that carries it
  Peel,      // a body whose layers peel with more force than the contacts below hold
};
// Returns "island", "overhang" or "peel".
[[nodiscard]] std::string_view name_of(ContactCause cause);

struct SupportContact {
  PlatePoint place;     // on the model's surface
  Direction outward{};  // surface normal at the place, of length 1; points down or horizontally
  ContactCause cause = ContactCause::Island;
  double load_mm2 = 0;  // area of a layer that the contact holds when the layer is peeled off
  bool operator==(const SupportContact&) const = default;
};

}  // namespace contourd
