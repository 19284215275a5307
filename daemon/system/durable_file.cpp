#include "daemon/system/durable_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <system_error>

#include "daemon/system/new_file.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

namespace fs = std::filesystem;

void write_durably(const fs::path& path, std::string_view text) {
  try {
    NewFile file(path.parent_path());
    file.write(text);
    file.replace(path.filename().string());
  } catch (const std::system_error& error) {
    throw std::system_error(error.code(), "cannot write " + path.string());
  }
  sync_folder(path.parent_path());
}

void sync_folder(const fs::path& folder) {
  const FileDescriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.valid()) ::fsync(directory.get());
}

void sync_contents(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::is_directory(status)) {
    for (const auto& entry : fs::directory_iterator(path, error))
      if (fs::is_regular_file(entry.symlink_status(error))) sync_contents(entry.path());
    return;
  }
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK | O_NOFOLLOW));
  if (file.valid()) ::fsync(file.get());
}

}  // namespace contourd
