// Users and groups by the system's own lists alone: a directory service could keep the event loop waiting.
// Thread-safe (no state).
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// "alice (1000)"; the number alone of whom the list does not know.
[[nodiscard]] std::string user_name(uid_t user);

[[nodiscard]] std::optional<gid_t> find_group(std::string_view name);

}  // namespace contourd
