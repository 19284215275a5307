// Reads jobs, one after the other, on a thread of its own: the one whose turn it is, to be printed, and those
// that wait, to hear what is wrong with them. Event loop's thread only.
#pragma once

#include <functional>
#include <list>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/config/printer_config.hpp"
#include "daemon/jobs/prepared_job_cache.hpp"
#include "daemon/prepare/job_outlook.hpp"
#include "daemon/prepare/job_settings.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/spool/reading_record.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

struct JobRefusal {
  std::string reason;
  bool for_now = false;   // there may be room in memory for it later
  std::string profile{};  // what is the matter with its resin's, which is no reason to refuse it
};
// It was given up: for a job whose turn has come, or because nobody wants it any more.
struct ReadingGivenUp {};
using ReadJob = std::variant<PreparedJob, JobRefusal, ReadingGivenUp>;
// What is known of a job that waits.
using CheckedJob = std::variant<JobOutlook, JobRefusal, ReadingGivenUp>;
using JobAnalysisOutcome = std::variant<AnalyzedJob, JobRefusal, ReadingGivenUp>;

class JobReader {
 public:
  // All must outlive the reader. Takes over what the last process was reading when it ended.
  JobReader(const PrinterConfig& config, const Spool& spool, EventLoop& loop);
  // Waits for at most one layer's mask or a step of a search for supports, and for a file that is being read.
  ~JobReader();
  JobReader(const JobReader&) = delete;
  JobReader& operator=(const JobReader&) = delete;

  // Prepares a job in printing/, or takes what its check has kept of it when nothing has changed since; then
  // calls `done`, from the loop. Without settings, its ticket is read to hear what is wrong with it.
  void read(const JobFiles& files, const std::optional<JobSettings>& settings,
            std::function<void(ReadJob)> done);
  // Ends the last read() soon, wherever it can be ended.
  void give_up_reading() { reading_.request_stop(); }
  // Prepares incoming/`file`: `done` gets why it would be refused, or what it will be. At most one job is
  // kept, until another is read, or until its memory is needed for a check. read(), forget() of that
  // file, and a check of another one that is to be kept, end it soon.
  enum class Keep { Nothing, Prepared };
  void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done);
  // Looks through all layers of incoming/`file`, which takes as long as their masks; keeps the job as check()
  // does, and ends as that. One at a time.
  void analyze(const std::string& file, Keep keep, std::function<void(const JobAnalysisOutcome&)> done);
  // Keeps nothing of incoming/`file` any more.
  void forget(const std::string& file);
  // Has the job's contents written to the disk, behind what is being read.
  void sync(const JobFiles& files);

  // See ReadingRecord.
  [[nodiscard]] bool take_ended(const JobFiles& job) { return record_.take_ended(job); }
  // This process is to end: whatever is being read has not ended it.
  void stop() {
    record_.stop();
    give_up();
  }

 private:
  // A look at a job that waits, from its order to its end.
  struct Look {
    std::string file;
    std::stop_source stop{};
  };
  using Looks = std::list<Look>;

  // Of all that is under way.
  void give_up();
  void give_up_looks();
  // Has `look_now` called on the worker's thread, and `done` with its result.
  template <typename LookNow, typename Done>
  void look_at(const std::string& file, LookNow look_now, Done done);

  // These on the worker's thread.
  [[nodiscard]] ReadJob read_now(const JobFiles& files, const std::optional<JobSettings>& settings,
                                 const std::stop_token& stop);
  [[nodiscard]] ReadJob prepare(const JobFiles& files, const std::optional<JobSettings>& settings,
                                const std::stop_token& stop);
  [[nodiscard]] CheckedJob check_now(const JobFiles& files, Keep keep, const std::stop_token& stop);
  [[nodiscard]] JobAnalysisOutcome analyze_now(const JobFiles& files, Keep keep, const std::stop_token& stop);
  [[nodiscard]] ReadJob take_or_read(const JobFiles& files, const std::stop_token& stop);

  const PrinterConfig& config_;
  const Spool& spool_;
  ReadingRecord record_;
  std::stop_source reading_;  // of the last one
  Looks looks_;
  PreparedJobCache kept_;  // of the worker's thread
  Worker worker_;          // last: its thread ends before what its tasks use
};

// What is told of why a job is refused, in some lines: it goes into the log, a file and each answer to a
// client.
[[nodiscard]] std::string refusal_text(std::string_view why);

}  // namespace contourd
