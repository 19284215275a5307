// Reads jobs on a thread of its own, one after the other: the job whose turn has come, to print it, and
// waiting jobs, to find their mistakes early. Leaves other work on waiting jobs to the spool. Event loop's
// thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/jobs/job_checks.hpp"
#include "daemon/jobs/prepared_job_cache.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/progress/progress_record.hpp"
#include "daemon/spool/reading_record.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

using ReadJob = std::variant<PreparedJob, JobRefusal, ReadingGivenUp>;

// Returns the marks of a job that is printed with the resin's profile of this name. Blocks. Any thread.
[[nodiscard]] JobMarks marks_of(const JobFiles& files, const std::string& resin, const PrinterConfig& config);

// The picture of a waiting job, as a PNG file; or none, and a clause with the reason.
struct DrawnJob {
  std::vector<std::uint8_t> png{};
  std::string trouble{};
};

class JobReader final : public JobChecks {
 public:
  // All arguments must outlive the reader. Finds out what the last process was reading when it ended.
  JobReader(const PrinterConfig& config, Spool& spool, EventLoop& loop);
  // Blocks for at most one layer's mask or one step of a search for supports, and for a file that is being
  // read.
  ~JobReader() override;

  // Prepares a job in printing/, or takes the preparation that its check has cached if nothing has changed
  // since; then calls `done` from the loop. Without settings, the ticket is read to find out what is wrong
  // with it.
  void read(const JobFiles& files, const std::optional<JobSettings>& settings,
            std::function<void(ReadJob)> done);
  // Ends the last read() soon, at the next point where it can be interrupted.
  void give_up_reading() { reading_.request_stop(); }
  void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done) override;
  void analyze(const std::string& file, Keep keep,
               std::function<void(const JobAnalysisOutcome&)> done) override;
  void forget(const std::string& file) override;
  // Prepares incoming/`file` with these settings in place of its own and discards the result: `done` gets the
  // reason why the job would be refused, also for now; or an empty text. Ends early as check() does.
  void try_settings(const std::string& file, const JobSettings& settings,
                    std::function<void(const std::string& refusal)> done);
  // Draws the models of incoming/`file` with their supports, which takes as long as its check, and some
  // seconds at most for the picture. Ends early as check() does, but not while the picture is drawn.
  void draw(const std::string& file, std::function<void(const DrawnJob&)> done);
  void reject(const std::string& file, const JobEnd& end, Spool::Rejected done) override {
    spool_.reject(file, end, std::move(done));
  }
  void save(Record record, const std::vector<std::string>& lines,
            std::function<void(const std::string& trouble)> done) override;
  // Has the contents of the job's files written to the disk, after the current reading.
  void sync(const JobFiles& files);

  // See ReadingRecord.
  [[nodiscard]] bool take_ended(const JobFiles& job) { return record_->take_ended(job); }
  // Ends all readings, because this process ends; the record then blames none of them for that.
  void stop();

 private:
  // A check or analysis of a waiting job, from its request to its end.
  struct Inspection {
    std::string file;
    std::stop_source stop{};
  };
  using Inspections = std::list<Inspection>;

  // Ends all readings early.
  void give_up();
  // Ends all checks and analyses early.
  void give_up_inspections();
  // Calls `inspect_now` on the worker's thread, then `done` with its result from the loop.
  template <typename InspectNow, typename Done>
  void inspect(const std::string& file, InspectNow inspect_now, Done done);

  // Functions that run on the worker's thread:
  [[nodiscard]] ReadJob read_now(const JobFiles& files, const std::optional<JobSettings>& settings,
                                 const std::stop_token& stop);
  [[nodiscard]] ReadJob prepare(const JobFiles& files, const std::optional<JobSettings>& settings,
                                const std::stop_token& stop);
  [[nodiscard]] CheckedJob check_now(const JobFiles& files, Keep keep, const std::stop_token& stop);
  [[nodiscard]] JobAnalysisOutcome analyze_now(const JobFiles& files, Keep keep, const std::stop_token& stop);
  [[nodiscard]] DrawnJob draw_now(const JobFiles& files, const std::stop_token& stop);
  [[nodiscard]] ReadJob take_or_read(const JobFiles& files, const std::stop_token& stop);

  const PrinterConfig& config_;
  Spool& spool_;
  std::shared_ptr<ReadingRecord> record_;  // the spool's thread changes it, too
  std::stop_source reading_;               // for the last read()
  Inspections inspections_;
  PreparedJobCache cache_;  // for the worker's thread only
  Worker worker_;           // last: its thread ends before what its tasks use
};

// Returns the reason for a refusal, shortened and printable, because it goes into the log, a file and each
// reply to a client.
[[nodiscard]] std::string refusal_text(std::string_view why);

}  // namespace contourd
