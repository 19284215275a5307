// Keeps an inotify(7) watch on the path incoming/. The folder may be removed, renamed, replaced or mounted
// over while it is watched; then the folder that is now at this path is watched. Event loop's thread only.
#pragma once

#include <sys/inotify.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// The inotify events that are watched in a folder.
inline constexpr std::uint32_t kFolderChanges =
    IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_TO | IN_DELETE | IN_MOVED_FROM | IN_ONLYDIR;

class IncomingFolder {
 public:
  struct Calls {
    // Makes the folder if it does not exist; called by any thread, one at a time; throws std::runtime_error.
    std::function<void()> make;
    std::function<void()> left;                             // the folder is no longer watched
    std::function<void()> replaced;                         // another folder is watched
    std::function<void(const std::string& why)> not_there;  // no folder can be watched; this is retried
  };
  // The loop, the disk and the inotify descriptor must outlive the object.
  IncomingFolder(std::filesystem::path path, EventLoop& loop, Worker& disk, Calls calls);

  // Watches the folder by this inotify descriptor. Throws std::runtime_error.
  void watch_by(int inotify);
  [[nodiscard]] bool is_watched_by(int watch) const { return watch == watch_; }
  // Stops the watch and watches the folder that is now at the path; retries until that succeeds.
  void watch_anew();

 private:
  // The identity of a folder, independent of its name.
  struct Identity {
    std::uint64_t device = 0, inode = 0;
    bool operator==(const Identity&) const = default;
  };
  struct Opened {
    FileDescriptor folder;
    Identity identity;
    std::string trouble;  // why the folder could not be opened, or empty
  };

  [[nodiscard]] Opened open() const noexcept;
  [[nodiscard]] Identity identity_now() const;
  void watch(const Opened& opened);
  void watch_or_retry(const Opened& opened);
  void look_later();
  void looked(const Identity& identity);

  std::filesystem::path path_;
  EventLoop& loop_;
  Worker& disk_;
  Calls calls_;
  int inotify_ = -1, watch_ = -1;
  Identity identity_;
  bool opening_ = false;
  bool missing_ = false;
  EventLoop::SourcePtr watch_again_timer_, look_timer_;
};

}  // namespace contourd
