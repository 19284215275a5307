#include "daemon/config/printer_places.hpp"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "daemon/json/profile_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

void check_socket(JsonDocument& document, const fs::path& socket) {
  std::error_code code;
  const fs::path folder = socket.parent_path();
  // Folders directly in /run are created when the service starts.
  if (!fs::is_directory(folder, code) && folder.parent_path() != "/run")
    return document.add_violation("/control_socket", "there is no folder " + folder.string());
  const fs::file_status there = fs::symlink_status(socket, code);
  if (fs::exists(there) && !fs::is_socket(there))
    document.add_violation("/control_socket", socket.string() + " exists and is not a socket");
}

}  // namespace

fs::path nearest_existing(fs::path folder) {
  std::error_code code;
  while (!fs::exists(folder, code) && folder.has_relative_path())
    folder = folder.parent_path();
  return folder;
}

void check_places(JsonDocument& document, const fs::path& folder) {
  std::error_code code;
  if (const auto socket = document.valid_text("/control_socket"))
    check_socket(document, resolved(folder, *socket));
  if (const auto spool = document.valid_text("/spool_folder")) {
    const fs::path place = resolved(folder, *spool), base = nearest_existing(place);
    const auto refuse = [&](const std::string& why) {
      document.add_violation("/spool_folder", place.string() + " cannot be created: " + base.string() + why);
    };
    if (!fs::is_directory(base, code)) {
      refuse(" is not a folder");
    } else if (base != place && ::access(base.c_str(), W_OK) != 0 && errno == EROFS) {
      refuse(std::string(" is read-only") + kReadOnlyHint);
    }
  }
}

}  // namespace contourd
