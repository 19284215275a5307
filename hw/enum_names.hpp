// Names of enumerations' values, for messages and drawings. Pure values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace contourd {

// Returns the names of an enumeration's values, in their order from 0 to `Last`, from a list with commas. A
// wrong number does not compile.
template <auto Last>
[[nodiscard]] consteval auto names_to(std::string_view list) {
  std::array<std::string_view, static_cast<std::size_t>(Last) + 1> names;
  for (std::string_view& name : names) {
    if (list.empty()) throw "a name is missing";
    name = list.substr(0, list.find(", "));
    list.remove_prefix(std::min(list.size(), name.size() + 2));
  }
  if (!list.empty()) throw "there are more names than enumerators";
  return names;
}

// The names of an enumeration's values, in their order: a specialization for each enumeration that has names.
template <typename Enum>
inline constexpr std::array<std::string_view, 0> kNames{};

// Returns the value's name; "?" if there is none.
template <typename Enum>
requires(!kNames<Enum>.empty()) [[nodiscard]] constexpr std::string_view name_of(Enum value) {
  const auto index = static_cast<std::size_t>(value);
  return index < kNames<Enum>.size() ? kNames<Enum>[index] : "?";
}

}  // namespace contourd
