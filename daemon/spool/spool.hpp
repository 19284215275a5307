// The spool folder: incoming/ printing/ done/ failed/. Jobs move through it by rename, so that after a power
// cut at any moment every file is in exactly one place and its folder says how it stands. Event loop's thread
// only, but for folder(), files_of(), is_unfinished(), write_beside(), reports_of() and end(), which any may
// call.
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
// What is to be known again after a restart is in a folder that nobody else may write: see state_records.hpp
// and, for what lies in incoming/ and was taken by copy, copied_originals.hpp.
#pragma once

#include <functional>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/incoming_watch.hpp"
#include "daemon/spool/job_files.hpp"
#include "daemon/spool/printing_copies.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/spool/spool_lock.hpp"
#include "daemon/spool/state_records.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"

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
  // What is known of incoming/.
  [[nodiscard]] const IncomingWatch& incoming() const { return watch_; }
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
  // The same for what may be read but not moved (see is_immovable()). The original stays, is never told of
  // again as long as it is what it is, and is among the originals of incoming(). Returns at once; `done` is
  // called from the loop.
  using Copy = JobCopy;
  void begin_with_copy(const std::string& file, std::function<void(const Copy&)> done);
  // Whether what begin() threw is of this kind.
  [[nodiscard]] static bool is_immovable(const std::error_code& code);
  // What is being copied is given up soon.
  void stop_copying() { copies_.stop(); }

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

  // Those that are there. Any thread may call it; blocks.
  [[nodiscard]] ReportFiles reports_of(Folder folder, const std::string& name) const;

  // See jobs_left_in_printing().
  [[nodiscard]] std::vector<JobFiles> interrupted() const;
  // The end of a print is known to no job that is claimed or filed after it.
  [[nodiscard]] const StateRecords& records() const { return records_; }

  // The order of those that wait in incoming/, where their owner has changed it: see QueueOrder.
  [[nodiscard]] std::vector<std::string> order() const;
  // Changes the records on the spool's thread. Returns at once; `done` is called from the loop, with why the
  // disk did not take it.
  void keep(std::function<void(const StateRecords& records)> change,
            std::function<void(const std::string& trouble)> done);

  // Why nothing in the spool can be changed at this moment; empty when that is possible.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] std::uintmax_t free_bytes() const;

 private:
  // Makes what is not there, and takes the spool for this process.
  void make_folders();
  // What a daemon that was killed was writing.
  void remove_leftovers() const;
  [[nodiscard]] Rejection file_rejected(const std::string& file, const std::string& reason);

  SpoolFolders folders_;
  std::filesystem::path state_;
  SpoolLock lock_;
  StateRecords records_;
  CopiedOriginals originals_;
  PrintingCopies copies_;
  IncomingWatch watch_;
  Worker disk_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd
