// Keeps an inotify(7) watch on the path incoming/. The folder may be removed, renamed, replaced or mounted
// over while it is watched; then the folder that is now at this path is watched. Event loop's thread only.
#pragma once

#include <sys/inotify.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// The inotify events that are watched in a folder.
inline constexpr std::uint32_t kFolderChanges =
    IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_TO | IN_DELETE | IN_MOVED_FROM | IN_ONLYDIR;

// Makes the folder, and receives reports of the watch.
class IncomingFolderObserver {
 public:
  virtual ~IncomingFolderObserver() = default;

  // Makes the folder if it does not exist. Called by any thread, one at a time. Throws std::runtime_error.
  virtual void make_folder() = 0;
  // Called when the folder is no longer watched.
  virtual void folder_left() = 0;
  // Called when another folder is watched.
  virtual void folder_replaced() = 0;
  // Called when no folder can be watched, which is retried.
  virtual void folder_lost(const std::string& why) = 0;
};

class IncomingFolder {
 public:
  // All arguments and the inotify descriptor must outlive the object.
  IncomingFolder(std::filesystem::path path, EventLoop& loop, Worker& disk, IncomingFolderObserver& observer)
      : path_(std::move(path)), loop_(loop), disk_(disk), observer_(observer) {}

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
  IncomingFolderObserver& observer_;
  int inotify_ = -1, watch_ = -1;
  Identity identity_;
  bool opening_ = false;
  bool missing_ = false;
  EventLoop::SourcePtr watch_again_timer_, look_timer_;
};

}  // namespace contourd
