// The spool folder: incoming/ printing/ done/ failed/. Jobs move through it by rename, so that after a power
// cut at any moment every file is in exactly one place and its folder says how it stands. Event loop's thread
// only, but for folder(), files_of(), is_unfinished(), write_beside() and end(), which any may call.
//
// A disk may take seconds. What comes at any time, also while the light is on (looks at incoming/, refusals),
// waits for it on a thread of its own; the rest is for when there is no light.
//
//   incoming/NAME.stl (+ NAME.json)     waits its turn, checked already
//   incoming/NAME/                      a plate: plate.json, and the STL files that it names
//   printing/NAME.stl (+ NAME.json)     under way; or printing/NAME/
//   done/NAME.stl ... NAME.report.json NAME.report.html; or done/NAME/ ...
//   failed/NAME.stl ... NAME.reason.txt; or failed/NAME/ ...
//
// In a folder that nobody else may write (state_folder.hpp):
//
//   plate-occupied                      the plate holds a part: the job's name is in it
//   queue-held                          no job begins until the owner has spoken: why is in it
//   ended-print                         how the print of the job in printing/ ended, until that is filed
//   copied-originals                    what lies in incoming/ and was taken by copy
#pragma once

#include <sys/inotify.h>

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "daemon/copied_originals.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/print_job.hpp"
#include "daemon/worker.hpp"

namespace contourd {

// Told of models and plates in incoming/.
class SpoolObserver {
 public:
  SpoolObserver() = default;
  SpoolObserver(const SpoolObserver&) = delete;
  SpoolObserver& operator=(const SpoolObserver&) = delete;
  virtual ~SpoolObserver() = default;

  // incoming/`file` is whole: closed by its writer, or moved in; a plate with all its files. May come again
  // for the same file when it was written again.
  virtual void model_arrived(const std::string& file) = 0;
  // The owner took incoming/`file` away, or a plate's file.
  virtual void model_withdrawn(const std::string& file) = 0;
  // The plate incoming/`file` cannot be taken as long as these files are missing, which its plate.json names.
  // Told when it changes.
  virtual void plate_waits(const std::string& file, const std::vector<std::string>& missing) = 0;
  // The folder incoming/ was removed and cannot be made again, `why` says why: nothing arrives until it can.
  virtual void incoming_lost(const std::string& why) = 0;
};

class Spool {
 public:
  enum class Folder { Incoming, Printing, Done, Failed };

  // Makes the folders, and takes the spool for this process alone. Throws std::runtime_error when that fails,
  // one of them is a symbolic link, or another contourd has it.
  Spool(std::filesystem::path root, EventLoop& loop, SpoolObserver& observer);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Watches incoming/, and reports what is in it already, oldest first. Throws std::system_error.
  void open();

  [[nodiscard]] std::filesystem::path folder(Folder folder) const;

  // Whether at this moment somebody has incoming/`file`, its ticket or a plate's file open for writing, or a
  // plate lacks a file.
  [[nodiscard]] bool is_unfinished(const std::string& file) const;
  // False when incoming/`file` is not there; true also when nobody can tell.
  [[nodiscard]] bool is_waiting(const std::string& file) const;
  // Plates in incoming/ that wait for files, and for which, or the first of these.
  [[nodiscard]] const std::map<std::string, std::vector<std::string>>& incomplete() const {
    return incomplete_;
  }
  // Reports incoming/`file` again when it is whole.
  void wait_for(const std::string& file);

  // The files of a model in incoming/ or printing/, its ticket with it if there is one; or a plate's folder.
  [[nodiscard]] JobFiles files_of(Folder folder, const std::string& file) const;

  // incoming/ -> printing/, under a name that no job in printing/, done/ or failed/ has. Throws
  // std::system_error; then the files are where they were.
  [[nodiscard]] JobFiles begin(const std::string& file);
  // The same for what may be read but not moved (see is_immovable()), such as a folder that another made for
  // himself alone: it is copied. The original stays, is never told of again as long as it is what it is, and
  // is in originals(). Returns at once; `done` is called from the loop.
  struct Copy {
    std::optional<JobFiles> job;  // in printing/
    std::string unreadable;       // else a sentence, when that is why: it can be refused
    std::string trouble;          // else why it is to be tried again
  };
  void begin_with_copy(const std::string& file, std::function<void(const Copy&)> done);
  // Whether what begin() threw is of this kind.
  [[nodiscard]] static bool is_immovable(const std::error_code& code);
  // What is being copied is given up soon.
  void stop_copying() { stop_copying_ = true; }
  // What lies in incoming/ and was taken by copy, or refused there: it may be deleted.
  [[nodiscard]] const std::set<std::string>& originals() const { return originals_here_; }

  // -> done/ or failed/. What goes beside them has been written before: see write_beside(). Throws
  // std::system_error.
  void end(const JobFiles& files, Folder to) const;
  // printing/ -> incoming/, for a job that has not begun. False when incoming/ has another of that name by
  // now. Throws std::system_error.
  bool give_back(const JobFiles& files);
  // incoming/ -> failed/, with a reason file. Returns at once; `done` is called from the loop.
  enum class Rejection {
    Filed,
    LeftThere,   // filed, but for its files: they cannot be moved, and may be deleted
    Unfinished,  // somebody writes it anew: it stays where it is
    Impossible,  // it stays where it is, `trouble` says why
  };
  using Rejected = std::function<void(Rejection, const std::string& trouble)>;
  void reject(const std::string& file, const std::string& reason, Rejected done);

  // Writes NAME.`suffix`, all of it or nothing, and has it on the disk before it returns. Throws
  // std::system_error.
  void write_beside(Folder folder, const std::string& name, const std::string& suffix,
                    const std::string& text) const;

  // Models and plates left in printing/ by a daemon that did not end its print. What else lies there goes to
  // failed/, or back to incoming/ if it is the ticket of a model there, as far as that is possible.
  [[nodiscard]] std::vector<JobFiles> interrupted();

  // The job whose part is on the plate, or nothing when the plate is clear. Survives restarts.
  [[nodiscard]] std::optional<std::string> plate_occupant() const;
  void set_plate_occupant(const std::optional<std::string>& job) const;

  // Why no job is to begin until the owner has spoken, or nothing. Survives restarts.
  [[nodiscard]] std::optional<std::string> hold() const;
  void set_hold(const std::optional<std::string>& why) const;

  // How the print of the job in printing/ ended, as the archivist has it; empty when nobody has told. Ended
  // prints and claimed jobs have none any more. Any thread may call these; the second throws
  // std::system_error.
  [[nodiscard]] std::string end_of_print() const;
  void keep_end_of_print(const std::string& text) const;

  // Why nothing in the spool can be changed at this moment; empty when that is possible.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] std::uintmax_t free_bytes() const;

 private:
  struct Candidate {
    std::uintmax_t bytes = 0;  // a plate's files together
    int unchanged_looks = 0;   // by the timer: events may come in bursts
  };

  // How a job in incoming/ looks.
  struct Sight {
    std::uintmax_t bytes = 0;
    bool being_written = false;
    bool known_to_be_whole = false;    // else it counts as whole when it stays as it is
    std::vector<std::string> missing;  // of a plate: what it lacks, its plate.json alone if it lacks that
    bool is_there = false;             // else there is nothing to be taken, and the rest says nothing
    bool is_plate = false;
    bool taken = false;  // by copy: what lies there is not wanted any more
  };

  void watch_incoming();
  // Again and again, until it can be watched.
  void watch_incoming_anew();
  // False when there are no more watches.
  [[nodiscard]] bool watch_plate(const std::string& file);
  void stop_watching_plate(const std::string& file);
  void read_events();
  void take_event(const inotify_event& event);
  enum class Look { Event, Timer };
  void consider_all();
  // Some a turn of the event loop, as a folder may hold any number of files.
  void consider_soon(std::deque<std::string> files, Look look);
  void consider_some();
  void consider(const std::string& file, Look look);
  void seen(const std::string& file, Look look, const Sight& sight);
  [[nodiscard]] std::vector<std::string> names_in_incoming() const;
  [[nodiscard]] Sight look_at(const std::string& file) const noexcept;
  void look_later(const std::string& file);
  void note_missing(const std::string& file, const std::vector<std::string>& missing);
  [[nodiscard]] Sight look_at_model(const std::filesystem::path& path) const;
  [[nodiscard]] Sight look_at_plate(const std::filesystem::path& path) const;
  void look_again();
  [[nodiscard]] bool is_plate(Folder where, const std::string& file) const;
  [[nodiscard]] std::optional<std::string> first_line_of(const char* file) const;
  void keep_line(const char* file, const std::optional<std::string>& line) const;
  [[nodiscard]] std::string unused_name(const std::string& full_stem) const;
  void move_job(const JobFiles& from, const JobFiles& to) const;
  [[nodiscard]] JobFiles named(Folder folder, const std::string& name, const JobFiles& like) const;
  [[nodiscard]] Copy copy_to_printing(const std::string& file);
  void take_back(const JobFiles& copy);
  [[nodiscard]] Rejection file_rejected(const std::string& file, const std::string& reason);

  void take_for_this_process();
  // What a daemon that was killed was writing.
  void remove_leftovers() const;
  void forget_end_of_print() const;

  std::filesystem::path root_;
  std::filesystem::path state_;
  EventLoop& loop_;
  SpoolObserver& observer_;
  FileDescriptor lock_;
  FileDescriptor inotify_;
  EventLoop::SourcePtr inotify_source_;
  EventLoop::SourcePtr look_again_timer_, watch_again_timer_, consider_timer_;
  int incoming_watch_ = -1;
  bool incoming_lost_ = false;
  std::deque<std::pair<std::string, Look>> to_consider_;
  std::map<int, std::string> plate_watches_;  // inotify's number: the plate in incoming/
  std::map<std::string, int> watch_of_plate_;
  std::map<std::string, Candidate> candidates_;  // not known to be whole yet
  std::map<std::string, std::vector<std::string>> incomplete_;
  CopiedOriginals originals_;
  std::set<std::string> originals_here_;
  std::atomic<bool> stop_copying_ = false;
  std::map<std::string, std::uint64_t> looks_;  // under way: the number of the latest at each file
  std::uint64_t looks_begun_ = 0;
  Worker disk_;  // last: its thread ends before what its tasks use
};

// Whether a file in incoming/ is a model, by its name.
[[nodiscard]] bool is_model_name(const std::string& file);

// The name of the job that a model or a plate's folder in incoming/ becomes, but for a number behind it.
[[nodiscard]] std::string job_name_of(const std::string& file);

}  // namespace contourd
