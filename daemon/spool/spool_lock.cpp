#include "daemon/spool/spool_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "daemon/spool/spool_folders.hpp"

namespace contourd {
namespace {

constexpr const char* kLock = ".lock";

bool is_same_file(const FileDescriptor& a, const FileDescriptor& b) {
  struct stat one {
  }, other{};
  return ::fstat(a.get(), &one) == 0 && ::fstat(b.get(), &other) == 0 && one.st_dev == other.st_dev &&
         one.st_ino == other.st_ino;
}

}  // namespace

// Other users get no read permission for the lock file: a process that can open it could lock it.
void SpoolLock::take(const std::filesystem::path& spool) {
  constexpr int kFlags = O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  FileDescriptor lock(::open((spool / kLock).c_str(), O_RDWR | kFlags, 0600));
  // A memory card that has become read-only may become writable again later.
  if (!lock.valid() && errno == EROFS)
    lock = FileDescriptor(::open((spool / kLock).c_str(), (O_RDONLY | kFlags) & ~O_CREAT));
  if (!lock.valid()) {
    const std::error_code code(errno, std::generic_category());
    throw std::runtime_error(
        fmt::format("cannot write to the spool {}: {}", spool.string(), why_not_written(code)));
  }
  if (is_same_file(lock, lock_)) return;
  (void)::fchmod(lock.get(), 0600);  // a failure is ignored: the file keeps the mode that it was created with
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error(fmt::format("another contourd uses the spool {}", spool.string()));
  lock_ = std::move(lock);
}

}  // namespace contourd
