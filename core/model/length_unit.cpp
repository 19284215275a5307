#include "core/model/length_unit.hpp"

#include <algorithm>
#include <array>

namespace contourd {
namespace {

struct UnitNames {
  double millimeters;
  std::string_view name, plural;
  std::array<std::string_view, 3> other_names;
};

// In the order of LengthUnit.
constexpr std::array<UnitNames, 6> kUnits{
    {{1, "mm", "millimetres", {"millimetre", "millimeter", "millimeters"}},
     {10, "cm", "centimetres", {"centimetre", "centimeter", "centimeters"}},
     {1000, "m", "metres", {"metre", "meter", "meters"}},
     {0.001, "um", "micrometres", {"micrometer", "micron", "microns"}},
     {25.4, "inch", "inches", {"in", "in.", "\""}},
     {304.8, "foot", "feet", {"ft", "ft.", "'"}}}};

const UnitNames& names_of(LengthUnit unit) {
  return kUnits[static_cast<std::size_t>(unit)];
}

bool same_word(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

}  // namespace

double millimeters_in(LengthUnit unit) {
  return names_of(unit).millimeters;
}

std::string_view name_of(LengthUnit unit) {
  return names_of(unit).name;
}

std::string_view plural_of(LengthUnit unit) {
  return names_of(unit).plural;
}

std::optional<LengthUnit> length_unit(std::string_view name) {
  const auto* const found = std::ranges::find_if(kUnits, [name](const UnitNames& unit) {
    const auto is = [name](std::string_view each) { return same_word(each, name); };
    return is(unit.name) || is(unit.plural) || std::ranges::any_of(unit.other_names, is);
  });
  if (found == kUnits.end()) return std::nullopt;
  return static_cast<LengthUnit>(found - kUnits.begin());
}

}  // namespace contourd
