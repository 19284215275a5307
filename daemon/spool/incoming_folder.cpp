#include "daemon/spool/incoming_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace contourd {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFolderRetryInterval = 1s;
// Interval of the check that the path still leads to the watched folder. There is no event when a file system
// is mounted over it, or a folder above it is renamed.
constexpr Duration kMissingFolderInterval = 3s;

}  // namespace

void IncomingFolder::watch_by(int inotify) {
  inotify_ = inotify;
  const Opened opened = open();
  if (!opened.trouble.empty()) throw std::runtime_error(opened.trouble);
  watch(opened);
  look_later();
}

IncomingFolder::Opened IncomingFolder::open() const noexcept {
  Opened opened;
  try {
    observer_.make_folder();
    opened.folder = FileDescriptor(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    struct stat status {};
    if (!opened.folder.valid() || ::fstat(opened.folder.get(), &status) != 0)
      throw std::system_error(errno, std::generic_category(), "cannot open " + path_.string());
    opened.identity = {status.st_dev, status.st_ino};
  } catch (const std::exception& error) {
    opened.trouble = error.what();
  }
  return opened;
}

// Throws std::system_error. The descriptor is closed afterwards: an open one would prevent an unmount.
void IncomingFolder::watch(const Opened& opened) {
  const std::string path = fmt::format("/proc/self/fd/{}", opened.folder.get());
  watch_ = ::inotify_add_watch(inotify_, path.c_str(), kFolderChanges | IN_MOVE_SELF);
  if (watch_ < 0) throw std::system_error(errno, std::generic_category(), "cannot watch " + path_.string());
  identity_ = opened.identity;
}

void IncomingFolder::watch_anew() {
  watch_again_timer_.reset();
  look_timer_.reset();
  if (watch_ >= 0) (void)::inotify_rm_watch(inotify_, std::exchange(watch_, -1));
  observer_.folder_left();
  if (std::exchange(opening_, true)) return;
  disk_.run([this] { return open(); }, [this](const Opened& opened) { watch_or_retry(opened); });
}

void IncomingFolder::watch_or_retry(const Opened& opened) {
  opening_ = false;
  try {
    if (!opened.trouble.empty()) throw std::runtime_error(opened.trouble);
    watch(opened);
  } catch (const std::runtime_error& error) {
    if (!std::exchange(missing_, true)) observer_.folder_lost(error.what());
    watch_again_timer_ = loop_.at(std::chrono::steady_clock::now() + kFolderRetryInterval,
                                  "the spool's timer", [this] { watch_anew(); });
    return;
  }
  missing_ = false;
  observer_.folder_replaced();
  look_later();
}

IncomingFolder::Identity IncomingFolder::identity_now() const {
  struct stat status {};
  if (::lstat(path_.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

void IncomingFolder::look_later() {
  look_timer_ =
      loop_.at(std::chrono::steady_clock::now() + kMissingFolderInterval, "the spool's folder timer", [this] {
        look_timer_.reset();
        disk_.run([this] { return identity_now(); }, [this](const Identity& identity) { looked(identity); });
      });
}

void IncomingFolder::looked(const Identity& identity) {
  if (watch_ < 0) return;  // watch_anew() is already at work
  if (identity != identity_) return watch_anew();
  look_later();
}

}  // namespace contourd
