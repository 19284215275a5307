// Computes the part that a print cured, once the print is filed, and writes it into the print's report, on a
// thread that gives way to all others. Event loop's thread only.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/engine/contour_engine.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

// A print that is filed.
struct PrintToCure {
  PrintReport report;
  std::unique_ptr<ContourEngine> engine;
  std::unique_ptr<DimmedMasks> undersides;
  std::unique_ptr<GivenLight> given;           // null: exposures were not split
  Spool::Folder folder = Spool::Folder::Done;  // of its report
};

class CuredPartWriter {
 public:
  // The spool must outlive the writer.
  CuredPartWriter(EventLoop& loop, const Spool& spool, std::optional<std::uint64_t> memory_limit);
  CuredPartWriter(const CuredPartWriter&) = delete;
  CuredPartWriter& operator=(const CuredPartWriter&) = delete;
  // Stops the computation; the report then says that it was not completed.
  ~CuredPartWriter();

  // Begins the computation after those before. If the report expects it, writes the report again with the
  // part, or with the reason why there is none: a time limit, too little memory, stop(). Leaves a report that
  // was changed or removed in between. Returns at once; the print is destroyed on the thread.
  void begin(std::shared_ptr<PrintToCure> print);
  // Stops the computation that was begun last.
  void stop();

 private:
  enum class Stop { No, NextPrint, Contourd };

  static void write(const Spool& spool, PrintToCure& print, const std::atomic<Stop>& stop,
                    std::optional<std::uint64_t> memory_limit);
  static PrintedPart cure(PrintToCure& print, const std::filesystem::path& folder,
                          const std::atomic<Stop>& stop, std::optional<std::uint64_t> memory_limit);

  const Spool& spool_;
  std::optional<std::uint64_t> memory_limit_;
  std::shared_ptr<std::atomic<Stop>> stop_;  // of the computation that was begun last
  Worker worker_;                            // last: its thread ends before what its tasks use
};

// Returns what a report says before the part is computed; nullopt if none will be: the resin has no working
// curve, or no layer had light.
[[nodiscard]] std::optional<PrintedPart> part_to_come(const PrintReport& report);

}  // namespace contourd
