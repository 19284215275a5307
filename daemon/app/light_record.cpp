#include "daemon/app/light_record.hpp"

#include <cstdlib>
#include <string_view>

namespace contourd {

std::filesystem::path light_record_path(const std::filesystem::path& control_socket) {
  constexpr const char* kName = "light.json";
  const char* const folders = std::getenv("RUNTIME_DIRECTORY");
  if (folders == nullptr || *folders == '\0') return control_socket.parent_path() / kName;
  const std::string_view all(folders);  // folders, separated by colons
  return std::filesystem::path(all.substr(0, all.find(':'))) / kName;
}

}  // namespace contourd
