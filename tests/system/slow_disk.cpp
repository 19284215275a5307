// Preloaded into a daemon by a test: simulates a disk that hangs or refuses changes. Each file in the folder
// $SLOW_DISK is a gate that has an effect while the file exists:
//   reads               opening or looking up a file of the spool waits
//   writes              opening a file of the spool for writing waits, and so does its fsync()
//   plate               recording that the plate is not clear waits
//   pictures            opening a preview for writing waits
//   models              opening a model relative to a folder (openat) waits
//   full                writing into a file of the spool fails with ENOSPC, except with pwrite(): contourd
//   uses it
//                       only over blocks that a file has
//   read-only           changing the spool fails with EROFS
//   printing-read-only  changing the spool's folder printing/ fails with EROFS
//   history             opening or looking up the history's files waits
//   history-full        writing into the history's files fails with ENOSPC
//   history-read-only   changing the history's files fails with EROFS
// Every call that waits makes the file $SLOW_DISK/waiting.
//   loop                no call waits, but a call of the event loop's thread (the process's first one) on a
//                       file beside the folder $SLOW_DISK becomes a line of the file $SLOW_DISK/calls: CALL
//                       PATH
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

bool is_set(const char* gate) {
  const char* const folder = std::getenv("SLOW_DISK");
  if (folder == nullptr) return false;
  char path[256];
  std::snprintf(path, sizeof path, "%s/%s", folder, gate);
  // The plain system call, since access() is replaced below.
  return ::syscall(SYS_faccessat, AT_FDCWD, path, F_OK) == 0;
}

bool in_spool(const char* path) {
  return std::strstr(path, "/spool") != nullptr;
}

bool of_history(const char* path) {
  return std::strstr(path, "/history.sqlite") != nullptr;
}

// True if a change at this path is to fail; sets errno.
bool refused(const char* path) {
  if (of_history(path) && is_set("history-read-only")) {
    errno = EROFS;
    return true;
  }
  const bool in_printing = std::strstr(path, "/spool/printing") != nullptr;
  if (!in_spool(path) || !(is_set("read-only") || (in_printing && is_set("printing-read-only"))))
    return false;
  errno = EROFS;
  return true;
}

bool refused(const char* path, int flags) {
  return (flags & O_ACCMODE) != O_RDONLY && refused(path);
}

void wait_while(const char* gate) {
  const char* const folder = std::getenv("SLOW_DISK");
  if (folder == nullptr) return;
  char waiting[256];
  std::snprintf(waiting, sizeof waiting, "%s/waiting", folder);
  while (is_set(gate)) {
    // The plain system call, since the replaced open() would wait.
    const long made = ::syscall(SYS_openat, AT_FDCWD, waiting, O_CREAT | O_WRONLY | O_CLOEXEC, 0644);
    if (made >= 0) ::close(static_cast<int>(made));
    const timespec moment{0, 5'000'000};
    ::nanosleep(&moment, nullptr);
  }
}

void wait_for_file(const char* path, bool writes) {
  if (in_spool(path)) wait_while(writes ? "writes" : "reads");
  if (of_history(path)) wait_while("history");
  if (writes && std::strstr(path, "/plate-occupied") != nullptr) wait_while("plate");
  if (writes && std::strstr(path, "preview.png") != nullptr) wait_while("pictures");
}

// Notes a call of the event loop's thread. `path` may be relative to the open folder `folder`.
void note_call(const char* call, int folder, const char* path) {
  if (::syscall(SYS_gettid) != ::getpid() || !is_set("loop")) return;
  char whole[4096] = "", link[64];
  if (path[0] != '/') {
    std::snprintf(link, sizeof link, folder == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", folder);
    // The array keeps a zero byte at its end.
    if (::syscall(SYS_readlinkat, AT_FDCWD, link, whole, sizeof whole - 1) <= 0) return;
    if (path[0] != '\0') std::strncat(whole, "/", sizeof whole - std::strlen(whole) - 1);
  }
  std::strncat(whole, path, sizeof whole - std::strlen(whole) - 1);
  const char* const slow = std::getenv("SLOW_DISK");
  const auto length = static_cast<std::size_t>(std::strrchr(slow, '/') + 1 - slow);
  const bool beside =
      std::strncmp(whole, slow, length) == 0 && std::strncmp(whole, slow, std::strlen(slow)) != 0;
  // The log is a file only in tests.
  if (!beside || std::strstr(whole, "/contourd.log") != nullptr) return;
  char line[4200], calls[256];
  const int count = std::snprintf(line, sizeof line, "%s %s\n", call, whole);
  std::snprintf(calls, sizeof calls, "%s/calls", slow);
  const long file = ::syscall(SYS_openat, AT_FDCWD, calls, O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return;
  (void)::syscall(SYS_write, file, line, count);
  ::close(static_cast<int>(file));
}

void note_call(const char* call, int fd) {
  note_call(call, fd, "");
}

mode_t mode_of(int flags, va_list more) {
  const bool makes_file = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return makes_file ? va_arg(more, mode_t) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  note_call("open", AT_FDCWD, path);
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  wait_for_file(path, (flags & O_ACCMODE) != O_RDONLY);
  if (refused(path, flags)) return -1;
  return real<int(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  note_call("open", AT_FDCWD, path);
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  wait_for_file(path, (flags & O_ACCMODE) != O_RDONLY);
  if (refused(path, flags)) return -1;
  return real<int(const char*, int, ...)>("open64")(path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
  note_call("open", folder, path);
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  const char* const ending = std::strrchr(path, '.');
  if (ending != nullptr && std::strcmp(ending, ".stl") == 0) wait_while("models");
  return real<int(int, const char*, int, ...)>("openat")(folder, path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
  note_call("open", AT_FDCWD, path);
  wait_for_file(path, std::strchr(mode, 'r') == nullptr);
  return real<FILE*(const char*, const char*)>("fopen")(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  note_call("open", AT_FDCWD, path);
  wait_for_file(path, std::strchr(mode, 'r') == nullptr);
  return real<FILE*(const char*, const char*)>("fopen64")(path, mode);
}
DIR* opendir(const char* path) {
  note_call("open", AT_FDCWD, path);
  wait_for_file(path, false);
  return real<DIR*(const char*)>("opendir")(path);
}
int stat(const char* path, struct stat* status) noexcept {
  note_call("stat", AT_FDCWD, path);
  wait_for_file(path, false);
  return real<int(const char*, struct stat*)>("stat")(path, status);
}
int lstat(const char* path, struct stat* status) noexcept {
  note_call("stat", AT_FDCWD, path);
  wait_for_file(path, false);
  return real<int(const char*, struct stat*)>("lstat")(path, status);
}
int fsync(int fd) {
  note_call("fsync", fd);
  char link[32], path[4096] = "";
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  // The array keeps a zero byte at its end.
  if (::readlink(link, path, sizeof path - 1) > 0 && in_spool(path)) wait_while("writes");
  return real<int(int)>("fsync")(fd);
}
int rename(const char* from, const char* to) noexcept {
  note_call("rename", AT_FDCWD, to);
  wait_for_file(to, true);
  if (refused(to)) return -1;
  return real<int(const char*, const char*)>("rename")(from, to);
}
int remove(const char* path) noexcept {
  note_call("remove", AT_FDCWD, path);
  if (refused(path)) return -1;
  return real<int(const char*)>("remove")(path);
}
int mkdir(const char* path, mode_t mode) noexcept {
  note_call("mkdir", AT_FDCWD, path);
  if (refused(path)) return -1;
  return real<int(const char*, mode_t)>("mkdir")(path, mode);
}
int access(const char* path, int mode) noexcept {
  note_call("access", AT_FDCWD, path);
  if ((mode & W_OK) != 0 && refused(path)) return -1;
  return real<int(const char*, int)>("access")(path, mode);
}
ssize_t write(int fd, const void* bytes, size_t count) {
  note_call("write", fd);
  char link[64], path[256] = "";
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  if (is_set("full") && ::readlink(link, path, sizeof path - 1) > 0 && in_spool(path)) {
    errno = ENOSPC;
    return -1;
  }
  return real<ssize_t(int, const void*, size_t)>("write")(fd, bytes, count);
}
ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t place) {
  note_call("write", fd);
  char link[64], path[256] = "";
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  if (is_set("history-full") && ::readlink(link, path, sizeof path - 1) > 0 && of_history(path)) {
    errno = ENOSPC;
    return -1;
  }
  return real<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(fd, bytes, count, place);
}
ssize_t read(int fd, void* bytes, size_t count) {
  note_call("read", fd);
  return real<ssize_t(int, void*, size_t)>("read")(fd, bytes, count);
}
int fstat(int fd, struct stat* status) noexcept {
  note_call("stat", fd);
  return real<int(int, struct stat*)>("fstat")(fd, status);
}
int statvfs(const char* path, struct statvfs* status) noexcept {
  note_call("statvfs", AT_FDCWD, path);
  return real<int(const char*, struct statvfs*)>("statvfs")(path, status);
}
int faccessat(int folder, const char* path, int mode, int flags) noexcept {
  note_call("access", folder, path);
  return real<int(int, const char*, int, int)>("faccessat")(folder, path, mode, flags);
}
int unlink(const char* path) noexcept {
  note_call("remove", AT_FDCWD, path);
  return real<int(const char*)>("unlink")(path);
}
int unlinkat(int folder, const char* path, int flags) noexcept {
  note_call("remove", folder, path);
  return real<int(int, const char*, int)>("unlinkat")(folder, path, flags);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  note_call("rename", to_folder, to);
  return real<int(int, const char*, int, const char*, unsigned)>("renameat2")(from_folder, from, to_folder,
                                                                              to, flags);
}
int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) noexcept {
  note_call("link", to_folder, to);
  return real<int(int, const char*, int, const char*, int)>("linkat")(from_folder, from, to_folder, to,
                                                                      flags);
}
ssize_t readlink(const char* path, char* target, size_t size) noexcept {
  note_call("readlink", AT_FDCWD, path);
  return real<ssize_t(const char*, char*, size_t)>("readlink")(path, target, size);
}
int chmod(const char* path, mode_t mode) noexcept {
  note_call("chmod", AT_FDCWD, path);
  return real<int(const char*, mode_t)>("chmod")(path, mode);
}
int inotify_add_watch(int fd, const char* path, uint32_t mask) noexcept {
  note_call("inotify_add_watch", AT_FDCWD, path);
  return real<int(int, const char*, uint32_t)>("inotify_add_watch")(fd, path, mask);
}
}
