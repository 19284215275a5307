// Units of length that a model's coordinates may be in. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <string_view>

namespace contourd {

enum class LengthUnit { Millimeter, Centimeter, Meter, Micrometer, Inch, Foot };

// Returns the length of one unit.
[[nodiscard]] double millimeters_in(LengthUnit unit);
// Returns the unit's name in tickets: "mm", "cm", "m", "um", "inch" or "foot".
[[nodiscard]] std::string_view name_of(LengthUnit unit);
// Returns the unit's plural in sentences: "inches".
[[nodiscard]] std::string_view plural_of(LengthUnit unit);
// Returns the unit of this name, in either case: the name in tickets, the plural, or an abbreviation that
// programs write into files. nullopt for any other word.
[[nodiscard]] std::optional<LengthUnit> length_unit(std::string_view name);

}  // namespace contourd
