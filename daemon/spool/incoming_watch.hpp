// Watches incoming/ and reports models and plates when they are complete (by inotify(7), and by a timer for
// changes that inotify does not report). Event loop's thread only. Files are examined on the disk's thread,
// since a disk may take seconds while the light is on.
#pragma once

#include <sys/inotify.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/ignored_files.hpp"
#include "daemon/spool/incoming_folder.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/spool/upload_state.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

// Receives reports of the models and plates in incoming/.
class SpoolObserver : public IgnoredFilesObserver {
 public:
  SpoolObserver() = default;
  SpoolObserver(const SpoolObserver&) = delete;
  SpoolObserver& operator=(const SpoolObserver&) = delete;
  ~SpoolObserver() override = default;

  // Called when incoming/`file` is complete: closed by its writer, or moved in; a plate with all its files.
  // Called again when the file or its ticket was written again, or its ticket was removed.
  virtual void model_arrived(const std::string& file) = 0;
  // Called when a user has removed incoming/`file`, or one of a plate's files.
  virtual void model_withdrawn(const std::string& file) = 0;
  // Called when the set of files that the plate incoming/`file` lacks has changed. Its plate.json names them,
  // and the plate cannot be printed without them.
  virtual void plate_waits(const std::string& file, const std::vector<std::string>& missing) = 0;
  // Called when incoming/ cannot be watched, with the reason: no job arrives until it can.
  virtual void incoming_lost(const std::string& why) = 0;
  // Called when another folder has become incoming/ and is now watched.
  virtual void incoming_replaced() = 0;
};

class IncomingWatch final : private IncomingFolderObserver {
 public:
  // `make_folders` makes incoming/ and the spool's other folders if they do not exist; it is called by any
  // thread, one at a time, and throws std::runtime_error.
  IncomingWatch(const SpoolFolders& folders, const CopiedOriginals& copied,
                std::function<void()> make_folders, EventLoop& loop, Worker& disk, SpoolObserver& observer);

  // Starts the watch, and reports the jobs that are already there, oldest first. Throws std::runtime_error.
  void open();

  // Notes that the spool moved incoming/`file` away: examinations in progress report nothing.
  void moved_away(const std::string& file) {
    looks_.erase(file);
    arrived_.erase(file);
  }
  // Reports `file` again when it is complete.
  void wait_for(const std::string& file) { consider(file, Look::Event); }

  // The plates that lack files, with the names of these files, or the first of them.
  [[nodiscard]] const std::map<std::string, std::vector<std::string>>& incomplete() const {
    return incomplete_;
  }
  // Returns the names of at most `most` models and plates that are not complete yet.
  [[nodiscard]] std::vector<std::string> arriving(std::size_t most) const;
  // The files that will not be printed as they are.
  [[nodiscard]] const std::map<std::string, WhyIgnored>& ignored() const { return ignored_.files(); }
  // The files that were copied to printing/, or refused but not moved: a user may delete them.
  [[nodiscard]] const std::set<std::string>& originals() const { return originals_; }
  void add_original(const std::string& file) { originals_.insert(file); }
  void remove_original(const std::string& file) { originals_.erase(file); }

 private:
  void make_folder() override { make_folders_(); }
  void folder_left() override;
  void folder_replaced() override;
  void folder_lost(const std::string& why) override { observer_.incoming_lost(why); }

  struct Candidate {
    std::uintmax_t bytes = 0;  // a plate's files together
    int unchanged_looks = 0;   // counts the timer's looks only, since events may come in bursts
    std::uint64_t number = 0;  // increases in the order of arrival
  };

  struct Seen {
    UploadState upload;
    bool taken = false;             // true if the job was copied, so that this original is no longer needed
    std::optional<WhyIgnored> why;  // why the file will not be printed as it is
    int watch = -1;                 // of a plate, see watch_plate()
  };

  enum class Look { Event, Timer };

  // Watches a plate's folder, and returns its watch; -1 if it is no plate, or the kernel has no watches left.
  // The disk's thread calls it, since it looks up the path.
  [[nodiscard]] int watch_plate(const std::string& file) const;
  void stop_watching_plate(const std::string& file);
  void read_events();
  void take_event(const inotify_event& event);
  void consider_models_of(const std::string& ticket);

  // Examines every file that is in the folder, or was there at the last look.
  void consider_all();
  [[nodiscard]] std::vector<std::string> names_in_folder() const;
  // Examines the files, a few in each turn of the event loop, since a folder may hold any number.
  void consider_soon(std::deque<std::string> files, Look look);
  void consider_some();
  void consider(const std::string& file, Look look);
  [[nodiscard]] Seen look_at(const std::string& file) const noexcept;
  void seen(const std::string& file, Look look, const Seen& seen);
  void note_ignored(const std::string& file, const std::optional<WhyIgnored>& why);
  void seen_to_be_gone(const std::string& file);
  void look_later(const std::string& file);
  Candidate& candidate(const std::string& file);
  void look_again();
  void note_missing(const std::string& file, const std::vector<std::string>& missing);

  const SpoolFolders& folders_;
  const CopiedOriginals& copied_;
  std::function<void()> make_folders_;
  EventLoop& loop_;
  Worker& disk_;
  SpoolObserver& observer_;
  FileDescriptor inotify_;
  EventLoop::SourcePtr inotify_source_;
  EventLoop::SourcePtr look_again_timer_, consider_timer_;
  std::deque<std::pair<std::string, Look>> to_consider_;
  std::map<int, std::string> plate_watches_;  // the plate of each inotify watch
  std::map<std::string, int> watch_of_plate_;
  std::map<std::string, Candidate> candidates_;  // not known to be complete yet
  std::map<std::string, std::vector<std::string>> incomplete_;
  IgnoredFiles ignored_;
  IncomingFolder folder_;
  std::set<std::string> arrived_;  // reported by model_arrived()
  std::set<std::string> originals_;
  std::map<std::string, std::uint64_t> looks_;  // the number of the latest look in progress at each file
  std::uint64_t looks_begun_ = 0, candidates_begun_ = 0;
};

}  // namespace contourd
