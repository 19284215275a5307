// Preloaded into a daemon by a test: a disk that does not answer. What reads (or looks for) a file of the
// spool waits while $SLOW_DISK/reads exists, what writes one while $SLOW_DISK/writes does; $SLOW_DISK/waiting
// is made by whatever waits.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

void wait_while(const char* gate) {
  const char* const folder = std::getenv("SLOW_DISK");
  if (folder == nullptr) return;
  char path[256], waiting[256];
  std::snprintf(path, sizeof path, "%s/%s", folder, gate);
  std::snprintf(waiting, sizeof waiting, "%s/waiting", folder);
  while (::access(path, F_OK) == 0) {
    // The system call itself: open() is one of those that wait.
    const long made = ::syscall(SYS_openat, AT_FDCWD, waiting, O_CREAT | O_WRONLY | O_CLOEXEC, 0644);
    if (made >= 0) ::close(static_cast<int>(made));
    const timespec moment{0, 5'000'000};
    ::nanosleep(&moment, nullptr);
  }
}

void wait_for_file(const char* path, bool writes) {
  if (std::strstr(path, "/spool/") != nullptr) wait_while(writes ? "writes" : "reads");
}

mode_t mode_of(int flags, va_list more) {
  return (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  wait_for_file(path, (flags & O_ACCMODE) != O_RDONLY);
  return real<int(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  wait_for_file(path, (flags & O_ACCMODE) != O_RDONLY);
  return real<int(const char*, int, ...)>("open64")(path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
  wait_for_file(path, std::strchr(mode, 'r') == nullptr);
  return real<FILE*(const char*, const char*)>("fopen")(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  wait_for_file(path, std::strchr(mode, 'r') == nullptr);
  return real<FILE*(const char*, const char*)>("fopen64")(path, mode);
}
DIR* opendir(const char* path) {
  wait_for_file(path, false);
  return real<DIR*(const char*)>("opendir")(path);
}
int stat(const char* path, struct stat* status) noexcept {
  wait_for_file(path, false);
  return real<int(const char*, struct stat*)>("stat")(path, status);
}
int lstat(const char* path, struct stat* status) noexcept {
  wait_for_file(path, false);
  return real<int(const char*, struct stat*)>("lstat")(path, status);
}
int fsync(int fd) {
  wait_while("writes");
  return real<int(int)>("fsync")(fd);
}
int rename(const char* from, const char* to) noexcept {
  wait_for_file(to, true);
  return real<int(const char*, const char*)>("rename")(from, to);
}
}
