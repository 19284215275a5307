// Makes the report of a print that is over and files its job, on a thread of its own: the picture and the
// disk may take seconds, and the event loop has a light to see to. Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/contour_engine.hpp"
#include "daemon/print_report.hpp"
#include "daemon/spool.hpp"
#include "daemon/worker.hpp"

namespace contourd {

struct EndedPrint {
  JobFiles files;      // in printing/
  PrintReport report;  // all but its picture
  std::unique_ptr<ContourEngine> engine;
};

struct FiledPrint {
  std::string job;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
  std::vector<std::string> troubles;  // a sentence each: what is not there, or not as it should be, and why
};

// How a print ended, as far as its report tells.
struct PrintEnd {
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;
};

class PrintArchivist {
 public:
  // The spool must outlive the archivist.
  PrintArchivist(EventLoop& loop, const Spool& spool);

  // Writes what belongs beside the job's files and moves them to done/ or failed/; then calls `done`, from
  // the loop. The outcome is on the disk before what takes long is made. REQUIRES: not busy.
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

// For a job found in printing/: how its print ended, if the archivist was only kept from filing it. Blocks.
[[nodiscard]] std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job);

}  // namespace contourd
