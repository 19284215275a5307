// Where a print has to be held, and why. Values; thread-safe as any value is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/model/placement.hpp"

namespace contourd {

// In millimetres: x and y from the plate's centre, seen from above, z above the plate.
struct PlatePoint {
  double x = 0, y = 0, z = 0;
  bool operator==(const PlatePoint&) const = default;
};

// So many places are held at most: a mesh of noise has a million.
inline constexpr std::size_t kMostContacts = 4096;

enum class ContactCause : std::uint8_t {
  Island,    // begins with nothing under it
  Overhang,  // is too far from what carries it
  Peel,      // its layers' area pulls at the contacts beneath with more than those hold
};
// "island", "overhang", "peel".
[[nodiscard]] std::string_view name_of(ContactCause cause);

struct SupportContact {
  PlatePoint place;     // on the model's surface
  Direction outward{};  // the surface's normal there, of length 1; points down or level
  ContactCause cause = ContactCause::Island;
  double load_mm2 = 0;  // of a layer's area that it holds when it is peeled off
  bool operator==(const SupportContact&) const = default;
};

}  // namespace contourd
