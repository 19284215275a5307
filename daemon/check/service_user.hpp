// As whom the service runs (contourd.service), and what that user cannot reach of what a printer's file
// names. For root, who can read everything and would find it good.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "daemon/config/printer_config.hpp"

namespace contourd {

struct SystemUser {
  std::string name;
  uid_t user = 0;
  gid_t group = 0;
};

// Nothing when this process is not root's, or there is no such user.
[[nodiscard]] std::optional<SystemUser> service_user();

// One for each file or folder. Not thread-safe: this process is that user meanwhile. Empty when it cannot be.
// REQUIRES: this process is root's.
[[nodiscard]] std::vector<Violation> out_of_reach(const SystemUser& user, const PrinterConfig& printer);

}  // namespace contourd
