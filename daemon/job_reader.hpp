// Reads jobs, one after the other, on a thread of its own: the one whose turn it is, to be printed, and those
// that wait, to hear what is wrong with them. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/config/printer_config.hpp"
#include "daemon/job_outlook.hpp"
#include "daemon/job_screening.hpp"
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

// A job that was looked through, as it was then.
struct ScreenedJob {
  JobScreening screening;
  std::string content;  // as content_mark() has it
  JobSettings settings;
};
// It was given up for a job whose turn has come.
struct ScreeningGivenUp {};
using JobScreened = std::variant<ScreenedJob, JobRefusal, ScreeningGivenUp>;

class JobReader {
 public:
  // All must outlive the reader. Takes over what the last process was reading when it ended.
  JobReader(const PrinterConfig& config, const Spool& spool, EventLoop& loop);
  // Waits for at most one layer's mask, and for what is being read.
  ~JobReader();
  JobReader(const JobReader&) = delete;
  JobReader& operator=(const JobReader&) = delete;

  // Prepares a job in printing/, or takes what its check has kept of it when nothing has changed since; then
  // calls `done`, from the loop. Without settings, its ticket is read to hear what is wrong with it.
  void read(const JobFiles& files, const std::optional<JobSettings>& settings,
            std::function<void(ReadJob)> done);
  // Prepares incoming/`file`: `done` gets why it would be refused, or what it will be. At most one job is
  // kept, until another is read, or until its memory is needed for a check.
  enum class Keep { Nothing, Prepared };
  void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done);
  // Looks through all layers of incoming/`file`, which takes as long as their masks; keeps the job as check()
  // does. read(), and forget() of that file, end it soon. One at a time.
  void screen(const std::string& file, Keep keep, std::function<void(const JobScreened&)> done);
  // Keeps nothing of incoming/`file` any more.
  void forget(const std::string& file);
  // Has the job's contents written to the disk, behind what is being read.
  void sync(const JobFiles& files);

  // See ReadingRecord.
  [[nodiscard]] bool take_ended(const JobFiles& job) { return record_.take_ended(job); }
  // This process is to end: whatever is being read has not ended it.
  void stop() {
    record_.stop();
    screening_.request_stop();
  }

 private:
  // These on the worker's thread.
  [[nodiscard]] ReadJob read_now(const JobFiles& files, const std::optional<JobSettings>& settings);
  [[nodiscard]] ReadJob prepare(const JobFiles& files, const std::optional<JobSettings>& settings);
  [[nodiscard]] CheckedJob check_now(const JobFiles& files, Keep keep);
  [[nodiscard]] JobScreened screen_now(const JobFiles& files, Keep keep, const std::stop_token& stop);
  [[nodiscard]] ReadJob take_or_read(const JobFiles& files);

  const PrinterConfig& config_;
  const Spool& spool_;
  ReadingRecord record_;
  std::stop_source screening_;  // of the last one
  std::string screened_;        // its file
  KeptJob kept_;                // of the worker's thread
  Worker worker_;               // last: its thread ends before what its tasks use
};

// What is told of why a job is refused, in some lines: it goes into the log, a file and each answer to a
// client.
[[nodiscard]] std::string refusal_text(std::string_view why);

}  // namespace contourd
