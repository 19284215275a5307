// Finds the files and folders named in a printer's file that the service's user (contourd.service) cannot
// access. For checks run by root, which can read everything and would miss them.
#pragma once

#include <sys/types.h>

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

// Returns one violation for each file or folder that the user cannot access. Empty if this process cannot
// take on the user's rights. Not thread-safe: this process has the user's rights during the call. REQUIRES:
// this process runs as root.
[[nodiscard]] std::vector<Violation> out_of_reach(const SystemUser& user, const PrinterConfig& printer);

}  // namespace contourd
