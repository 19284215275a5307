// Makes the report of a print that is over and files its job, on a thread of its own: the picture and the
// disk may take seconds, and the event loop has a light to see to. Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

struct EndedPrint {
  JobFiles files;      // in printing/
  PrintReport report;  // all but its picture
  std::unique_ptr<ContourEngine> engine;
  std::shared_future<void> noted{};  // in the history: the files stay until then, or for a while
};

struct FiledPrint {
  JobFiles files;  // where they were
  bool moved = false;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
  ReportFiles reports;
  std::vector<std::string> troubles;  // a sentence each: what is not there, or not as it should be, and why
};

// How a print ended, as far as its report tells.
struct PrintEnd {
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
  std::int64_t key = 0;  // in the history (EndedJob); 0 where it is not known
};

class PrintArchivist {
 public:
  // The spool must outlive the archivist.
  PrintArchivist(EventLoop& loop, const Spool& spool);

  // Has it on the disk how the job's print ended, before anything else is made of that: from then on it ended
  // so, whatever happens to this process or to done/ and failed/. What goes wrong is told with the filing.
  void record(const std::string& job, const PrintEnd& end);

  // Writes what belongs beside the job's files and moves them to done/ or failed/; then calls `done`, from
  // the loop. REQUIRES: not busy.
  void file(EndedPrint print, std::function<void(const FiledPrint&)> done);
  // A print was given and its `done` is still to come.
  [[nodiscard]] bool busy() const { return busy_; }

 private:
  const Spool& spool_;
  bool busy_ = false;
  Worker worker_;  // last: its thread ends before what its tasks use
};

// Where a job with this outcome belongs, and what its reason file says; empty when it has none.
[[nodiscard]] Spool::Folder folder_for(PrintOutcome outcome);
[[nodiscard]] std::string reason_text(const PrintEnd& end);

// Whose print's end is recorded last, as it is recorded, and how it ended; nothing when there is no record.
// Blocks.
struct RecordedEnd {
  std::string job;  // printable
  PrintEnd end;
};
[[nodiscard]] std::optional<RecordedEnd> last_recorded_end(const Spool& spool);

// How the print of a job in printing/ ended, if the archivist was only kept from filing it. Blocks.
[[nodiscard]] std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job);

}  // namespace contourd
