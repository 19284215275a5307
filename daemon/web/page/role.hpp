// The roles of people who have logged in: each role may do all that the ones before it may. Thread-safe (no
// state).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace contourd::web {

enum class Role {
  Watch,    // look at everything
  Print,    // also add jobs, print, pause, cancel and change them
  Service,  // also what a technician does at the machine
};

inline constexpr std::array kRoles{Role::Watch, Role::Print, Role::Service};

[[nodiscard]] constexpr std::string_view name_of(Role role) {
  constexpr std::array<std::string_view, kRoles.size()> kNames{"watch", "print", "service"};
  return kNames[static_cast<std::size_t>(role)];
}

// Returns the role of this name; nullopt if there is none.
[[nodiscard]] inline std::optional<Role> role_of(std::string_view name) {
  const auto* const found = std::ranges::find(kRoles, name, [](Role role) { return name_of(role); });
  return found == kRoles.end() ? std::nullopt : std::optional(*found);
}

}  // namespace contourd::web
