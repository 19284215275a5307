// The record of the model that this process is reading, for the next process: a model during whose reading a
// process ended (it ran out of memory, crashed or was killed) is not read again automatically. Thread-safe.
//
// The record is not synced to the disk: the kernel's cache survives the end of a process. A power cut during
// a reading does not count against the model, so a record of an earlier boot is ignored.
#pragma once

#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "daemon/spool/job_files.hpp"

namespace contourd {

// The message for a user about such a model.
inline constexpr std::string_view kEndedAProcess =
    "contourd ended while it read this: it was killed, crashed or ran out of memory. The model is not read "
    "again "
    "automatically, since that may end contourd again, and a print with it. To try again, put it into "
    "incoming "
    "once more.";

class ReadingRecord {
 public:
  // Reads the record that the previous process left in `file`.
  explicit ReadingRecord(std::filesystem::path file);

  // True if a process ended while it read this job, and the job was not submitted again since. Removes the
  // job from the record, so that the next call returns false.
  [[nodiscard]] bool take_ended(const JobFiles& job);
  // Records that the job is being read, from construction to destruction; at most one exists at a time.
  // Errors of the disk are ignored.
  class Reading {
   public:
    Reading(ReadingRecord& record, const JobFiles& job) : record_(record) { record_.begin(job); }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() { record_.end(); }

   private:
    ReadingRecord& record_;
  };
  // Notes that this process is about to end as requested, so that its current reading is not recorded.
  void stop();

 private:
  void begin(const JobFiles& job);
  void end();
  void write() const noexcept;

  std::filesystem::path file_;
  std::mutex mutex_;
  std::set<std::string> ended_;  // marks, see mark_of()
  std::string under_way_;
  bool stopped_ = false;
};

}  // namespace contourd
