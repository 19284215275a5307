// What this process is reading at this moment, for the next one: a model that ended a process (it ran out of
// memory, crashed or was killed) is not read again by itself. Thread-safe.
//
// Not synchronized with the disk: what ends a process leaves the kernel alone, and what the computer was
// doing when its power was cut says nothing about a file. So a record of an earlier boot does not count.
#pragma once

#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "daemon/spool/job_files.hpp"

namespace contourd {

// What is told of such a model.
inline constexpr std::string_view kEndedAProcess =
    "contourd ended while it read this: it was killed, crashed or ran out of memory. It is not read again by "
    "itself, as that may end contourd again, and a print with it. To have it read all the same, put it into "
    "incoming once more.";

class ReadingRecord {
 public:
  // Takes over what the last process left in `file`.
  explicit ReadingRecord(std::filesystem::path file);

  // Whether a process ended while it read this job, and the job was not put in again since. True once only.
  [[nodiscard]] bool take_ended(const JobFiles& job);
  // As long as there is one, the job is being read; one at a time. What the disk does not take is not
  // recorded.
  class Reading {
   public:
    Reading(ReadingRecord& record, const JobFiles& job) : record_(record) { record_.begin(job); }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() { record_.end(); }

   private:
    ReadingRecord& record_;
  };
  // This process is to end: whatever it is reading.
  void stop();

 private:
  void begin(const JobFiles& job);
  void end();
  void write() const noexcept;

  std::filesystem::path file_;
  std::mutex mutex_;
  std::set<std::string> ended_;  // as mark_of() has them
  std::string under_way_;
  bool stopped_ = false;
};

}  // namespace contourd
