#include "daemon/spool/state_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& folder, const std::string& why) {
  throw std::runtime_error(fmt::format("cannot use the state folder {}: {}", folder.string(), why));
}

std::string message(int error) {
  return std::generic_category().message(error);
}

}  // namespace

std::filesystem::path state_folder_path(const std::filesystem::path& spool) {
  const char* const folders = std::getenv("STATE_DIRECTORY");
  if (folders != nullptr && *folders != '\0') {
    const std::string_view all(folders);  // separated by colons
    return std::filesystem::path(all.substr(0, all.find(':')));
  }
  // A path may end with a slash.
  const std::filesystem::path folder = spool.has_filename() ? spool : spool.parent_path();
  return folder.string() + ".state";
}

void make_state_folder(const std::filesystem::path& folder) {
  // mkdir may fail although the folder exists already, as on a read-only disk.
  const int not_made = ::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST ? 0 : errno;
  const FileDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat status {};
  if (!opened.valid()) refuse(folder, message(not_made != 0 ? not_made : errno));
  if (::fstat(opened.get(), &status) != 0) refuse(folder, message(errno));
  if (status.st_uid != ::geteuid())
    refuse(folder,
           fmt::format("it belongs to user {}, contourd runs as user {}", status.st_uid, ::geteuid()));
  if ((status.st_mode & 077) != 0 && ::fchmod(opened.get(), 0700) != 0) refuse(folder, message(errno));
}

}  // namespace contourd
