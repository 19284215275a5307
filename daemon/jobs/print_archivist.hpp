// Writes the report of a print that is over and files its job, on a thread of its own: the picture and the
// disk may take seconds, and the event loop controls a light. Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

struct EndedPrint {
  JobFiles files;      // in printing/
  PrintReport report;  // complete except for its pictures
  std::unique_ptr<ContourEngine> engine;
  std::shared_future<void> noted{};  // ready when the print is in the history; filing waits for it
  std::shared_future<void> held{};   // ready when the hold of the queue is on the disk; filing waits for it
};

struct FiledPrint {
  JobFiles files;  // in printing/, where they were
  bool moved = false;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
  ReportFiles reports;
  std::vector<std::string> troubles;  // a sentence for each thing that is missing or wrong, and why
};

// The end of a print, as its report has it.
struct PrintEnd {
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
  std::int64_t key = 0;  // in the history (EndedJob); 0 if unknown
  std::string job{};     // its name; printable if it was read from a record
};
// Returns the end of a job for the history, with the present time.
[[nodiscard]] EndedJob ended_job(const PrintEnd& end);

class PrintArchivist {
 public:
  // The spool must outlive the archivist.
  PrintArchivist(EventLoop& loop, const Spool& spool);

  // Saves on the disk how the job's print ended, before anything else is done about it: from then on that is
  // its end, whatever happens to this process or to done/ and failed/. Errors are reported with the filing.
  // Returns a future that is ready when it is saved, or when the disk has refused it.
  std::shared_future<void> record(const std::string& job, const PrintEnd& end);

  // Writes the report's files and moves the job's files to done/ or failed/; then calls `done` from the loop.
  // REQUIRES: not busy.
  void file(EndedPrint print, std::function<void(const FiledPrint&)> done);
  // True if a print is being filed and its `done` is still to be called.
  [[nodiscard]] bool busy() const { return busy_; }

 private:
  const Spool& spool_;
  bool busy_ = false;
  Worker worker_;  // last: its thread ends before what its tasks use
};

// Returns the folder for a job with this outcome.
[[nodiscard]] Spool::Folder folder_for(PrintOutcome outcome);
// Returns the text of the reason file; empty if there is none.
[[nodiscard]] std::string reason_text(const PrintEnd& end);

// Records how the print of a job in printing/ ended, unless that is recorded already. Any thread; blocks.
// Throws std::system_error.
void record_end(const Spool& spool, const std::string& job, const PrintEnd& end);
// Returns the end of a print that was recorded last; nullopt if there is no record. Blocks.
[[nodiscard]] std::optional<PrintEnd> last_recorded_end(const Spool& spool);

// Returns how the print of a job in printing/ ended, if only its filing is missing; nullopt otherwise.
// Blocks.
[[nodiscard]] std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job);

}  // namespace contourd
