#include "daemon/system/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>

namespace contourd {
namespace {

// O_NONBLOCK: do not wait for a FIFO's writer, or for another process to release its lease on the file.
constexpr int kReading = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

std::string clause_for(int error) {
  switch (error) {
    case ENOENT:
      return "there is no such file";
    case ELOOP:
      return "it is a symbolic link, not a file";
    case ENXIO:  // a socket
      return "it is not a regular file";
    default:
      return "it cannot be read: " + std::generic_category().message(error);
  }
}

[[noreturn]] void fail(int error) {
  throw UnreadableFile(std::error_code(error, std::generic_category()), clause_for(error));
}

FileDescriptor regular(int opened) {
  if (opened < 0) fail(errno);
  FileDescriptor file(opened);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail(errno);
  if (S_ISDIR(status.st_mode))
    throw UnreadableFile(std::make_error_code(std::errc::is_a_directory), "it is a folder, not a file");
  if (!S_ISREG(status.st_mode))
    throw UnreadableFile(std::make_error_code(std::errc::invalid_argument), "it is not a regular file");
  return file;
}

}  // namespace

UnreadableFile::UnreadableFile(std::error_code code, const std::string& clause)
    : std::system_error(code), clause_(clause) {}

FileDescriptor open_regular_file(const std::filesystem::path& path, Links links) {
  if (links == Links::Follow) return regular(::open(path.c_str(), kReading));
  const std::filesystem::path parent = path.has_parent_path() ? path.parent_path() : ".";
  const FileDescriptor folder(::open(parent.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!folder.valid()) fail(errno);
  return regular(::openat(folder.get(), path.filename().c_str(), kReading | O_NOFOLLOW));
}

}  // namespace contourd
