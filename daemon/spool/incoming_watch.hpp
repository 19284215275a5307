// Watches incoming/ and tells of models and plates when they are whole (inotify(7); what it cannot tell is
// looked at by a timer). Event loop's thread only. Files are looked at on the disk's thread, as a disk may
// take seconds while a light is on.
//
// It has more members than most: what is known of each file, kept apart by what is waited for.
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

// Told of models and plates in incoming/.
class SpoolObserver {
 public:
  SpoolObserver() = default;
  SpoolObserver(const SpoolObserver&) = delete;
  SpoolObserver& operator=(const SpoolObserver&) = delete;
  virtual ~SpoolObserver() = default;

  // incoming/`file` is whole: closed by its writer, or moved in; a plate with all its files. May come again
  // for the same file when it was written again, or its ticket was, or is gone.
  virtual void model_arrived(const std::string& file) = 0;
  // The owner took incoming/`file` away, or a plate's file.
  virtual void model_withdrawn(const std::string& file) = 0;
  // The plate incoming/`file` cannot be taken as long as these files are missing, which its plate.json names.
  // Told when it changes.
  virtual void plate_waits(const std::string& file, const std::vector<std::string>& missing) = 0;
  // incoming/`file` will not be printed as it is; or so many more than were named.
  virtual void ignored(const std::string& file, WhyIgnored why) = 0;
  virtual void more_ignored(std::size_t files) = 0;
  // There is no folder incoming/ that can be watched, `why` says why: nothing arrives until there is.
  virtual void incoming_lost(const std::string& why) = 0;
  // Another folder is there than before, and is watched.
  virtual void incoming_replaced() = 0;
};

class IncomingWatch {
 public:
  // `make_folders` makes incoming/ and what else the spool needs where it is not there; called by any thread,
  // one at a time; throws std::runtime_error.
  IncomingWatch(const SpoolFolders& folders, const CopiedOriginals& copied,
                std::function<void()> make_folders, EventLoop& loop, Worker& disk, SpoolObserver& observer);

  // Watches, and reports what is there already, oldest first. Throws std::runtime_error.
  void open();

  // The spool moved incoming/`file` away: looks at it that are under way tell nothing.
  void moved_away(const std::string& file) {
    looks_.erase(file);
    arrived_.erase(file);
  }
  // Reports `file` again when it is whole.
  void wait_for(const std::string& file) { consider(file, Look::Event); }

  // Plates that wait for files, and for which, or the first of these.
  [[nodiscard]] const std::map<std::string, std::vector<std::string>>& incomplete() const {
    return incomplete_;
  }
  // Models and plates that are not whole yet, or that many of them.
  [[nodiscard]] std::vector<std::string> arriving(std::size_t most) const;
  // What else is there and will not be printed as it is.
  [[nodiscard]] const std::map<std::string, WhyIgnored>& ignored() const { return ignored_.files(); }
  // What was taken by copy, or refused there: it may be deleted.
  [[nodiscard]] const std::set<std::string>& originals() const { return originals_; }
  void add_original(const std::string& file) { originals_.insert(file); }
  void remove_original(const std::string& file) { originals_.erase(file); }

 private:
  struct Candidate {
    std::uintmax_t bytes = 0;  // a plate's files together
    int unchanged_looks = 0;   // by the timer: events may come in bursts
    std::uint64_t number = 0;  // in the order in which they came
  };

  struct Seen {
    UploadState upload;
    bool taken = false;             // by copy: what lies there is not wanted any more
    std::optional<WhyIgnored> why;  // of what will not be printed as it is
  };

  enum class Look { Event, Timer };

  // False when there are no more watches.
  [[nodiscard]] bool watch_plate(const std::string& file);
  void stop_watching_plate(const std::string& file);
  void stop_watching_plates();
  void read_events();
  void take_event(const inotify_event& event);
  void consider_models_of(const std::string& ticket);

  // All that is there, or was when it was looked at last.
  void consider_all();
  [[nodiscard]] std::vector<std::string> names_in_folder() const;
  // Some a turn of the event loop, as a folder may hold any number of files.
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
  EventLoop& loop_;
  Worker& disk_;
  SpoolObserver& observer_;
  FileDescriptor inotify_;
  EventLoop::SourcePtr inotify_source_;
  EventLoop::SourcePtr look_again_timer_, consider_timer_;
  std::deque<std::pair<std::string, Look>> to_consider_;
  std::map<int, std::string> plate_watches_;  // inotify's number: the plate
  std::map<std::string, int> watch_of_plate_;
  std::map<std::string, Candidate> candidates_;  // not known to be whole yet
  std::map<std::string, std::vector<std::string>> incomplete_;
  IgnoredFiles ignored_;
  IncomingFolder folder_;
  std::set<std::string> arrived_;  // and told
  std::set<std::string> originals_;
  std::map<std::string, std::uint64_t> looks_;  // under way: the number of the latest at each file
  std::uint64_t looks_begun_ = 0, candidates_begun_ = 0;
};

}  // namespace contourd
