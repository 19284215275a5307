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
#include "daemon/frames/frame_log.hpp"
#include "daemon/jobs/cured_part_writer.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

struct EndedPrint {
  JobFiles files;      // in printing/
  PrintReport report;  // complete except for its pictures
  std::unique_ptr<ContourEngine> engine;
  std::unique_ptr<DimmedMasks> undersides;  // as in the print's plan
  JobEnd end;
  std::unique_ptr<GivenLight> given{};  // null: exposures were not split
  std::shared_future<void> held{};  // ready when the hold of the queue is on the disk; filing waits for it
  std::shared_future<EndedFrameLog> frames{};  // the print's rises; filing waits for them
};

struct FiledPrint {
  JobFiles files;  // in printing/, where they were
  bool moved = false;
  JobEnd end;
  ReportFiles reports;
  std::vector<std::string> troubles;  // a sentence for each thing that is missing or wrong, and why
};

class PrintArchivist {
 public:
  // The spool must outlive the archivist.
  PrintArchivist(EventLoop& loop, Spool& spool, std::optional<std::uint64_t> memory_limit = std::nullopt);

  // Records the end of a print before anything else is done about it: from then on that is its end, whatever
  // happens to this process or to done/ and failed/. Errors are reported with the filing. Returns at once.
  void record(const JobEnd& end);

  // Writes the report's files and moves the job's files to done/ or failed/; then calls `done` from the loop,
  // and begins to compute the cured part for the report.
  // REQUIRES: not busy.
  void file(EndedPrint print, std::function<void(const FiledPrint&)> done);
  // True if a print is being filed and its `done` is still to be called.
  [[nodiscard]] bool busy() const { return busy_; }

 private:
  Spool& spool_;
  bool busy_ = false;
  CuredPartWriter cured_;
  Worker worker_;  // last: its thread ends before what its tasks use
};

// Returns the folder for a job with this end.
[[nodiscard]] Spool::Folder folder_for(const JobEnd& end);
// Returns the text of the reason file; empty if there is none.
[[nodiscard]] std::string reason_text(const JobEnd& end);

}  // namespace contourd
