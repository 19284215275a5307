// Reads jobs, one after the other, on a thread of its own: the one whose turn it is, to be printed, and those
// that wait, to hear what is wrong with them. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/config/printer_config.hpp"
#include "daemon/job_outlook.hpp"
#include "daemon/job_settings.hpp"
#include "daemon/kept_job.hpp"
#include "daemon/print_job.hpp"
#include "daemon/reading_record.hpp"
#include "daemon/spool.hpp"
#include "daemon/worker.hpp"

namespace contourd {

struct JobRefusal {
  std::string reason;
  bool for_now = false;   // there may be room in memory for it later
  std::string profile{};  // what is the matter with its resin's, which is no reason to refuse it
};
using ReadJob = std::variant<PreparedJob, JobRefusal>;
// What is known of a job that waits.
using CheckedJob = std::variant<JobOutlook, JobRefusal>;

class JobReader {
 public:
  // All must outlive the reader. Takes over what the last process was reading when it ended.
  JobReader(const PrinterConfig& config, const Spool& spool, EventLoop& loop);

  // Prepares a job in printing/, or takes what its check has kept of it when nothing has changed since; then
  // calls `done`, from the loop. Without settings, its ticket is read to hear what is wrong with it.
  void read(const JobFiles& files, const std::optional<JobSettings>& settings,
            std::function<void(ReadJob)> done);
  // Prepares incoming/`file`: `done` gets why it would be refused, or what it will be. At most one job is
  // kept, until another is read, or until its memory is needed for a check.
  enum class Keep { Nothing, Prepared };
  void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done);
  // Keeps nothing of incoming/`file` any more.
  void forget(const std::string& file);
  // Has the job's contents written to the disk, behind what is being read.
  void sync(const JobFiles& files);

  // See ReadingRecord.
  [[nodiscard]] bool take_ended(const JobFiles& job) { return record_.take_ended(job); }
  // This process is to end: whatever is being read has not ended it.
  void stop() { record_.stop(); }

 private:
  // These on the worker's thread.
  [[nodiscard]] ReadJob read_now(const JobFiles& files, const std::optional<JobSettings>& settings);
  [[nodiscard]] ReadJob prepare(const JobFiles& files, const std::optional<JobSettings>& settings);
  [[nodiscard]] CheckedJob check_now(const JobFiles& files, Keep keep);

  const PrinterConfig& config_;
  const Spool& spool_;
  ReadingRecord record_;
  KeptJob kept_;   // of the worker's thread
  Worker worker_;  // last: its thread ends before what its tasks use
};

// What is told of why a job is refused, in some lines: it goes into the log, a file and each answer to a
// client.
[[nodiscard]] std::string refusal_text(std::string_view why);

}  // namespace contourd
