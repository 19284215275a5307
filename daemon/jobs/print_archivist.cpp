#include "daemon/jobs/print_archivist.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/frames/frame_file.hpp"
#include "daemon/report/layer_pictures.hpp"
#include "daemon/report/print_report_html.hpp"
#include "daemon/report/print_report_json.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// Filing gives way to the event loop, and to the reading of a model.
constexpr int kArchivistNiceness = 5;
// Longest time that filing waits for the hold of the queue to be on the disk.
constexpr std::chrono::seconds kLongestHolding{2};
// Bytes that the record of frames leaves to the report's files.
constexpr std::uintmax_t kRoomForReport = 50'000'000;
// Time limit for all pictures of layers: contourd may be about to stop, and waits for the filing.
constexpr std::chrono::seconds kLongestLayerPictures{5};

// Calls `work`. Notes an exception as "`what`: why" and returns false; filing continues.
template <typename Work>
bool attempt(const std::string& what, FiledPrint& filed, Work work) {
  try {
    work();
    return true;
  } catch (const std::exception& error) {
    filed.troubles.push_back(fmt::format("{}: {}", what, error.what()));
    return false;
  }
}

void write_page_and_picture(const Spool& spool, EndedPrint& print, FiledPrint& filed) {
  PrintReport& report = print.report;
  const Spool::Folder folder = folder_for(print.end);
  attempt("no picture", filed, [&] {
    const Supports* const supports = report.summary.supports ? &*report.summary.supports : nullptr;
    report.preview = encode_picture(draw_job(*print.engine, supports, printed_height(report)), supports);
  });
  attempt("no pictures of layers", filed, [&] {
    report.layer_pictures = draw_layer_pictures(report, {*print.engine, print.undersides.get()},
                                                MaskBudget::Clock::now() + kLongestLayerPictures);
  });
  attempt("no report.html", filed,
          [&] { spool.write_beside(folder, report.job, "report.html", report_as_html(report)); });
  if (!report.preview) return;
  const std::string picture(report.preview->png.begin(), report.preview->png.end());
  attempt("no preview.png", filed, [&] { spool.write_beside(folder, report.job, "preview.png", picture); });
}

// Moves the file of the frames beside the report of a print that has risen.
void file_frames(const Spool& spool, EndedPrint& print, FiledPrint& filed) {
  const std::vector<LayerRecord>& layers = print.report.layers;
  const bool rose = std::ranges::find(layers, true, &LayerRecord::rises) != layers.end();
  if (!rose || !print.frames.valid()) return;
  attempt("no record of the masks that it showed while the plate rose", filed, [&] {
    if (print.frames.wait_for(kLongestHolding) != std::future_status::ready)
      throw std::runtime_error("the disk does not answer");
    const EndedFrameLog& log = print.frames.get();
    if (log.lost > 0)
      filed.troubles.push_back(fmt::format(
          "{} masks that it showed while the plate rose are not on record: {}", log.lost, log.trouble));
    if (log.file.empty()) return;
    PrintReport& report = print.report;
    const std::string text = frame_file_text(log.file);
    if (spool.free_bytes() < text.size() + kRoomForReport)
      throw std::runtime_error("the disk has no room for it beside the report");
    spool.write_beside(folder_for(print.end), report.job, FrameLogFile::kSuffix, text);
    report.frames = {report.job + "." + FrameLogFile::kSuffix, log.recorded, log.lost};
    std::error_code ignored;
    std::filesystem::remove(log.file, ignored);
  });
}

FiledPrint file_print(Spool& spool, EndedPrint& print) {
  PrintReport& report = print.report;
  FiledPrint filed{print.files, false, print.end, {}, {}};
  const Spool::Folder folder = folder_for(print.end);
  attempt("cannot record the end of the print", filed, [&] { spool.ends().add(print.end); });
  const std::string reason = reason_text(print.end);
  // A full disk has no room for what goes beside the job, but a rename needs none.
  if (!reason.empty())
    attempt("cannot write its reason file", filed,
            [&] { spool.write_beside(folder, report.job, "reason.txt", reason); });
  file_frames(spool, print, filed);
  const bool recorded = attempt("no report", filed, [&] {
    spool.write_beside(folder, report.job, "report.json", report_as_json(report));
  });
  if (recorded) write_page_and_picture(spool, print, filed);
  filed.reports = spool.reports_of(folder, report.job);
  // As long as the files are in printing/, the next start holds the queue.
  if (print.held.valid()) (void)print.held.wait_for(kLongestHolding);
  filed.moved = attempt("stays in printing", filed, [&] {
    if (!spool.end(print.files, folder))
      filed.troubles.push_back(fmt::format("{} is gone: someone removed it", print.files.model.string()));
  });
  return filed;
}

}  // namespace

PrintArchivist::PrintArchivist(EventLoop& loop, Spool& spool, std::optional<std::uint64_t> memory_limit)
    : spool_(spool),
      cured_(loop, spool, memory_limit),
      worker_(loop, "contourd-filing", kArchivistNiceness) {}

void PrintArchivist::file(EndedPrint print, std::function<void(const FiledPrint&)> done) {
  expects(!busy_, "no other print is being filed");
  busy_ = true;
  cured_.stop();
  print.report.cured = part_to_come(print.report);
  // Tasks of a worker are copied, but an engine cannot be. It is destroyed on a worker's thread, because a
  // large one takes time.
  auto shared = std::make_shared<EndedPrint>(std::move(print));
  auto to_cure = std::make_shared<PrintToCure>();
  worker_.run(
      [&spool = spool_, shared = std::move(shared), to_cure] {
        FiledPrint filed = file_print(spool, *shared);
        *to_cure = {std::move(shared->report), std::move(shared->engine), std::move(shared->undersides),
                    std::move(shared->given), folder_for(shared->end)};
        return filed;
      },
      [this, done = std::move(done), to_cure](const FiledPrint& filed) mutable {
        busy_ = false;
        cured_.begin(std::move(to_cure));
        done(filed);
      });
}

void PrintArchivist::record(const JobEnd& end) {
  worker_.run(
      [&spool = spool_, end] {
        try {
          spool.ends().add(end);
        } catch (const std::system_error&) {
          // Tried again, and reported, when the print is filed.
        }
        return true;
      },
      [](bool) {});
}

Spool::Folder folder_for(const JobEnd& end) {
  return end.outcome == name_of(PrintOutcome::Done) ? Spool::Folder::Done : Spool::Folder::Failed;
}

std::string reason_text(const JobEnd& end) {
  if (end.outcome == name_of(PrintOutcome::Done)) return "";
  if (end.outcome == name_of(PrintOutcome::Canceled)) return "Cancelled by the user.\n";
  return end.reason + (end.kind == JobEnd::Kind::Interrupted
                           ? ". Put the model into incoming again to print it from the start.\n"
                           : "\n");
}

}  // namespace contourd
