// Looks up users and groups in the system's own files only, because a directory service could block the event
// loop. Thread-safe (no state).
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// Returns "alice (1000)", or only the number if the user is not in /etc/passwd.
[[nodiscard]] std::string user_name(uid_t user);

[[nodiscard]] std::optional<gid_t> find_group(std::string_view name);

}  // namespace contourd
