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

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/copied_originals.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/incoming_watch.hpp"
#include "daemon/print_job.hpp"
#include "daemon/spool_folders.hpp"
#include "daemon/worker.hpp"

namespace contourd {

class Spool {
 public:
  using Folder = SpoolFolder;

  // Makes the folders, and takes the spool for this process alone. Throws std::runtime_error when that fails,
  // one of them is a symbolic link, or another contourd has it.
  Spool(std::filesystem::path root, EventLoop& loop, SpoolObserver& observer);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Watches incoming/, and reports what is in it already, oldest first. Throws std::runtime_error.
  void open();

  [[nodiscard]] std::filesystem::path folder(Folder folder) const { return folders_.path(folder); }

  // Whether at this moment somebody has incoming/`file`, its ticket or a plate's file open for writing, or a
  // plate lacks a file.
  [[nodiscard]] bool is_unfinished(const std::string& file) const;
  // False when incoming/`file` is not there; true also when nobody can tell.
  [[nodiscard]] bool is_waiting(const std::string& file) const;
  // Plates in incoming/ that wait for files, and for which, or the first of these.
  [[nodiscard]] const std::map<std::string, std::vector<std::string>>& incomplete() const {
    return watch_.incomplete();
  }
  // Models and plates in incoming/ that are not whole yet, or that many of them.
  [[nodiscard]] std::vector<std::string> arriving(std::size_t most) const { return watch_.arriving(most); }
  // What else lies in incoming/ and will not be printed as it is.
  [[nodiscard]] const std::map<std::string, Oddity>& passed_over() const { return watch_.passed_over(); }
  // Reports incoming/`file` again when it is whole.
  void wait_for(const std::string& file) { watch_.wait_for(file); }

  // The files of a model in incoming/ or printing/, its ticket with it if there is one; or a plate's folder.
  [[nodiscard]] JobFiles files_of(Folder folder, const std::string& file) const {
    return folders_.files_of(folder, file);
  }

  // incoming/ -> printing/, under a name that no job in printing/, done/ or failed/ has. A ticket that is
  // meant for another model too stays there, and is copied. Throws std::system_error; then the files are
  // where they were.
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
  [[nodiscard]] const std::set<std::string>& originals() const { return watch_.originals(); }

  // -> done/ or failed/. What goes beside them has been written before: see write_beside(). False when the
  // model is not there any more: then there is nothing to be moved, now or ever. Throws std::system_error.
  bool end(const JobFiles& files, Folder to) const;
  // printing/ -> incoming/, for a job that has not begun; under another name when incoming/ has one of its
  // own by now. Throws std::runtime_error; then the job is where it was.
  void give_back(const JobFiles& files);
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
  // failed/, or back to incoming/ or on to done/ if it is the ticket of a model there, as far as that is
  // possible.
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
  // Makes what is not there, and takes the spool for this process.
  void make_folders();
  void take_for_this_process();
  // What a daemon that was killed was writing.
  void remove_leftovers() const;
  [[nodiscard]] std::optional<std::string> first_line_of(const char* file) const;
  void keep_line(const char* file, const std::optional<std::string>& line) const;
  void forget_end_of_print() const;
  void bring_ticket_of(const std::string& file) const;
  [[nodiscard]] Folder folder_of_lost(const std::string& ticket) const;

  void move_job(const JobFiles& from, const JobFiles& to) const;
  void move_ticket(const JobFiles& from, const JobFiles& to, bool shared) const;
  // What it consists of, as far as that is possible.
  void remove_job(const JobFiles& job) const;
  [[nodiscard]] Copy copy_to_printing(const std::string& file);
  void take_back(const JobFiles& copy);
  [[nodiscard]] Rejection file_rejected(const std::string& file, const std::string& reason);

  SpoolFolders folders_;
  std::filesystem::path state_;
  FileDescriptor lock_;
  CopiedOriginals originals_;
  IncomingWatch watch_;
  std::atomic<bool> stop_copying_ = false;
  Worker disk_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd
