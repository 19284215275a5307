// Keeps the progress record of the print under way on a thread of its own, so that neither the event loop nor
// the print waits for the disk. While a write is under way, only the latest progress waits; a disk that is
// slower than the print is reported once. No write begins while the light may be on. Event loop's thread
// only.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/progress/progress_record.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class ProgressKeeper {
 public:
  // The log must outlive the keeper. `lit` returns true while the light may be on.
  ProgressKeeper(EventLoop& loop, const Log& log, std::filesystem::path file, std::function<bool()> lit);

  // Begins the record of a print. `marks` is called on the keeper's thread, and returns the job's marks.
  void begin(JobProgress progress, std::function<JobMarks()> marks);
  // Goes on with the record of a print that an earlier process began.
  void go_on(JobProgress progress);
  // Records this progress, once the one before is on the disk. Does nothing while no print is recorded.
  void keep(const PrintProgress& print);
  // Records what was changed in the print. Does nothing while no print is recorded.
  void change(JobProgress::Changes changes);
  // Receives true once the call is due, or false if the disk has not answered for some seconds.
  using Left = std::function<void(bool recorded)>;
  // Records that the plate leaves the height of a pause, and calls `left` when the disk has that or has
  // refused it: otherwise, after a power cut, the height of the pause would be trusted while the plate is far
  // below. Calls it at once if no pause is recorded.
  void leave_pause(Left left);
  // Removes the record: the print is over.
  void end();

 private:
  void begin_writing();
  void write();
  void written(const std::string& trouble);
  void answer_left(bool recorded);

  EventLoop& loop_;
  const Log& log_;
  std::function<bool()> lit_;
  // Used by the worker's thread only, once it was given to it.
  std::shared_ptr<ProgressRecord> record_;
  std::optional<JobProgress> progress_;  // nullopt: no print is recorded
  bool writing_ = false, waiting_ = false;
  std::chrono::steady_clock::time_point write_began_{};
  bool reported_ = false;  // a disk that is slow or refuses the record, for this print
  Left left_;              // while the disk is waited for
  EventLoop::SourcePtr left_deadline_;
  Worker worker_;  // last: its thread ends before what its tasks use
};

}  // namespace contourd
