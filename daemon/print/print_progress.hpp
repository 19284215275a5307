// The progress of a print: its layer, its phase, the light that the layer has had, and the plate's height. A
// print mode reports it at each phase, always in the dark, and a print that a power cut ended goes on from
// it. Value types; thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/enum_names.hpp"

namespace contourd {

enum class PrintPhase : std::uint8_t {
  Starting,     // before the first layer
  Lowering,     // the plate moves to the layer's height
  BeforeLight,  // the plate is at the layer's height; the phase lasts until the light is confirmed off
  Lit,          // the layer has had its light; the plate is at rest
  Lifting,
  Raising,  // the plate moves up so that the user can look at the part
  Paused,
  Parking,  // the print is over; the plate moves up
  Rising,   // a continuous print, from the move down before the rise to the pause or parking after it
  Moved,    // a power cut ended the print, and the plate was moved by hand since
};
template <>
inline constexpr auto kNames<PrintPhase> = names_to<PrintPhase::Moved>(
    "starting, lowering, before the light, lit, lifting, raising, paused, parking, rising, "
    "moved by hand");

struct PrintProgress {
  PrintPhase phase = PrintPhase::Starting;
  std::int32_t layer = 0;            // from 0
  Nanometers bottom{}, thickness{};  // the layer's, as planned
  Duration exposure{};               // the layer's whole exposure
  Duration light{};                  // upper bound of the light that the layer has had
  bool exposed = false;              // the layer has had all its light
  // Bounds of the plate's height in this phase, above the film; equal while the plate rests. Nullopt while
  // the height is unknown.
  struct Heights {
    Nanometers least, most;
    bool operator==(const Heights&) const = default;
  };
  std::optional<Heights> plate;

  bool operator==(const PrintProgress&) const = default;
};

// True if something may stick to the plate: the record of a first layer's light may not have reached the disk
// before the light.
[[nodiscard]] inline bool has_part(const PrintProgress& progress) {
  return progress.layer > 0 || progress.phase != PrintPhase::Starting;
}
// True if the plate rests in this phase.
[[nodiscard]] inline bool is_at_rest(const PrintProgress& progress) {
  return progress.plate && progress.plate->least == progress.plate->most;
}

}  // namespace contourd
