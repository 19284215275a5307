// Checks a printer's configuration before contourd uses it. Thread-safe (no shared state).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/printer_config.hpp"

namespace contourd {

// A user of the system, with the primary group.
struct SystemUser {
  std::string name;
  uid_t user = 0;
  gid_t group = 0;
};

// Returns the service's user; nullopt if this process does not run as root or the user does not exist.
[[nodiscard]] std::optional<SystemUser> service_user();

// Returns one violation for each file or folder named in the printer's file that the user cannot access,
// which a check by root, who can read everything, would miss. Empty if this process cannot take on the user's
// rights. Not thread-safe: this process has the user's rights during the call. REQUIRES: this process runs as
// root.
[[nodiscard]] std::vector<Violation> out_of_reach(const SystemUser& user, const PrinterConfig& printer);

// Checks the printer's file: prints a line for each value that is allowed but implausible, then a line that
// the file is good. Throws ConfigError if the file is wrong.
void check_config(const std::filesystem::path& file);

}  // namespace contourd
