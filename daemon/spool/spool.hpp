// The spool folder with incoming/, printing/, done/ and failed/. Jobs move through it by rename, so that
// after a power cut at any moment every file is in exactly one folder, and the folder shows the job's state.
// Event loop's thread only, except for the functions that any thread may call.
//
// A disk may take seconds. Everything that waits for it (examining incoming/, refusals, claims, records) runs
// on a thread of its own. The functions that block may be called by any thread but the event loop's once the
// loop runs: folder(), files_of(), is_waiting(), begin(), end(), write_beside(), reports_of(), trouble() and
// free_bytes().
//
//   incoming/NAME.stl (+ NAME.json)     a job that waits for its turn
//   incoming/NAME/                      a plate: plate.json, and the STL files that it names
//   printing/NAME.stl (+ NAME.json)     the job that is being printed; or printing/NAME/
//   done/NAME.stl ... NAME.report.json NAME.report.html; or done/NAME/ ...
//   failed/NAME.stl ... NAME.reason.txt; or failed/NAME/ ...
//   pictures/NAME/                      pictures of the camera (daemon/camera/picture_folders.hpp)
//
// State that survives a restart is in a folder that no other user may write: see state_records.hpp and, for
// jobs in incoming/ that were copied, copied_originals.hpp.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/file_rejections.hpp"
#include "daemon/spool/incoming_watch.hpp"
#include "daemon/spool/job_ends.hpp"
#include "daemon/spool/job_files.hpp"
#include "daemon/spool/printing_copies.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/spool/state_records.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/worker.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// A lock file (flock(2)) in the spool's folder, so that only one process uses the spool. The kernel releases
// the lock when the process ends.
class SpoolLock {
 public:
  // Takes the lock, or takes it again if another folder has been put in the spool's place. Throws
  // std::runtime_error if the folder cannot be written or another contourd has the lock.
  void take(const std::filesystem::path& spool);

 private:
  FileDescriptor lock_;
};

class Spool {
 public:
  using Folder = SpoolFolder;

  // Makes the folders and locks the spool for this process. Throws std::runtime_error if that fails, one of
  // the folders is a symbolic link, or another contourd uses the spool.
  Spool(std::filesystem::path root, EventLoop& loop, SpoolObserver& observer);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Watches incoming/, and reports the jobs that are already there, oldest first. Throws std::runtime_error.
  void open();

  [[nodiscard]] std::filesystem::path folder(Folder folder) const { return folders_.path(folder); }

  // False if incoming/`file` does not exist; true if it exists or its state cannot be read.
  [[nodiscard]] bool is_waiting(const std::string& file) const;
  // The watcher for incoming/; it lists the files that it has seen there.
  [[nodiscard]] const IncomingWatch& incoming() const { return watch_; }
  // Reports incoming/`file` again when it is complete.
  void wait_for(const std::string& file) { watch_.wait_for(file); }

  // Returns the files of a model in incoming/ or printing/, with its ticket if that exists, or a plate's
  // folder.
  [[nodiscard]] JobFiles files_of(Folder folder, const std::string& file) const {
    return folders_.files_of(folder, file);
  }

  // Moves a job from incoming/ to printing/, under a name that no job in printing/, done/ or failed/ has. A
  // ticket that belongs to another model too is copied instead. Any thread may call it; blocks. Throws
  // std::system_error; then the files are where they were. To be called after moves_away().
  [[nodiscard]] JobFiles begin(const std::string& file);
  // Notes that begin() is about to move incoming/`file` away: an examination in progress does not report it
  // as gone.
  void moves_away(const std::string& file) { watch_.moved_away(file); }
  // Copies a job from incoming/ to printing/ that can be read but not moved (see is_immovable()). The
  // original stays, is among the originals of incoming(), and is not reported again until it changes. Returns
  // at once; `done` is called from the loop.
  using Copy = JobCopy;
  void begin_with_copy(const std::string& file, std::function<void(const Copy&)> done);
  // Makes the current copy fail soon.
  void stop_copying() { copies_.stop(); }

  // Moves a job to done/ or failed/. write_beside() writes its report and reason before. Returns false if the
  // model no longer exists, so that a retry is useless. Throws std::system_error.
  bool end(const JobFiles& files, Folder to);
  // Moves a job that has not begun from printing/ back to incoming/, under another name if incoming/ has a
  // job of its name by now. Returns at once; `done` is called from the loop, with an empty text, or with an
  // error after which the job is where it was.
  void give_back(const JobFiles& files, std::function<void(const std::string& trouble)> done);
  using Rejection = contourd::Rejection;
  using Rejected = std::function<void(const FileRejections::Result& result)>;
  // Moves a job from incoming/ to failed/, writes a reason file there, and records this end with the files'
  // names. Returns at once; `done` is called from the loop.
  void reject(const std::string& file, const JobEnd& end, Rejected done);

  // Writes NAME.`suffix` atomically and syncs it to the disk. Throws std::system_error.
  void write_beside(Folder folder, const std::string& name, const std::string& suffix,
                    const std::string& text) const;

  // Returns the paths of the report files that exist. Any thread may call it; blocks.
  [[nodiscard]] ReportFiles reports_of(Folder folder, const std::string& name) const;

  // Returns the jobs that a daemon left in printing/, see jobs_left_in_printing().
  [[nodiscard]] std::vector<JobFiles> interrupted() const;
  // The state records.
  [[nodiscard]] const StateRecords& records() const { return records_; }
  // The record of the jobs that have ended. end() and reject() note that the files of a job were moved.
  [[nodiscard]] JobEndRecord& ends() { return ends_; }

  // Returns the order that a user has set for the jobs in incoming/, without those that no longer exist: see
  // QueueOrder.
  [[nodiscard]] std::vector<std::string> order() const;
  // Calls `task`, which must not throw, on the spool's thread, then `done` with its result from the loop.
  template <typename Task, typename Done>
  void run(Task task, Done done) {
    disk_.run(std::move(task), std::move(done));
  }
  // Changes the records on the spool's thread. Returns at once; `done` is called from the loop, with the
  // error of the disk or an empty text.
  void keep(std::function<void(const StateRecords& records)> change,
            std::function<void(const std::string& trouble)> done);

  // Returns why the spool cannot be written now; empty if it can.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] std::uintmax_t free_bytes() const;

 private:
  // Makes the folders that do not exist, and locks the spool for this process.
  void make_folders();
  // Removes unfinished files of a daemon that was killed.
  void remove_leftovers() const;
  // Completes the last begin() of a process that was killed meanwhile.
  void bring_ticket_of_last_claim() const;

  SpoolFolders folders_;
  std::filesystem::path state_;
  SpoolLock lock_;
  StateRecords records_;
  JobEndRecord ends_;
  CopiedOriginals originals_;
  PrintingCopies copies_;
  FileRejections rejections_;
  IncomingWatch watch_;
  Worker disk_;  // the last member, so that its thread ends before the members that its tasks use
};

}  // namespace contourd
