#include "daemon/jobs/print_archivist.hpp"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/report/layer_pictures.hpp"
#include "daemon/report/print_report_html.hpp"
#include "daemon/report/print_report_json.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// Filing gives way to the event loop, and to the reading of a model.
constexpr int kArchivistNiceness = 5;
// Longest time that filing waits for the history to have the print.
constexpr std::chrono::seconds kLongestNoting{2};
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
  const Spool::Folder folder = folder_for(report.outcome);
  attempt("no picture", filed, [&] {
    const Supports* const supports = report.summary.supports ? &*report.summary.supports : nullptr;
    report.preview = encode_picture(draw_job(*print.engine, supports, printed_height(report)), supports);
  });
  attempt("no pictures of layers", filed, [&] {
    report.layer_pictures =
        draw_layer_pictures(report, *print.engine, MaskBudget::Clock::now() + kLongestLayerPictures);
  });
  attempt("no report.html", filed,
          [&] { spool.write_beside(folder, report.job, "report.html", report_as_html(report)); });
  if (!report.preview) return;
  const std::string picture(report.preview->png.begin(), report.preview->png.end());
  attempt("no preview.png", filed, [&] { spool.write_beside(folder, report.job, "preview.png", picture); });
}

// Returns the job's name as valid UTF-8, which JSON requires.
std::string as_recorded(const std::string& job) {
  return printable(job);
}

FiledPrint file_print(const Spool& spool, EndedPrint& print) {
  const PrintReport& report = print.report;
  FiledPrint filed{print.files, false, report.outcome, report.reason, {}, {}};
  const Spool::Folder folder = folder_for(report.outcome);
  const PrintEnd end{report.outcome, report.reason};
  attempt("cannot record the end of the print", filed, [&] { record_end(spool, report.job, end); });
  const std::string reason = reason_text(end);
  // A full disk has no room for what goes beside the job, but a rename needs none.
  if (!reason.empty())
    attempt("cannot write its reason file", filed,
            [&] { spool.write_beside(folder, report.job, "reason.txt", reason); });
  const bool recorded = attempt("no report", filed, [&] {
    spool.write_beside(folder, report.job, "report.json", report_as_json(report));
  });
  if (recorded) write_page_and_picture(spool, print, filed);
  filed.reports = spool.reports_of(folder, report.job);
  // As long as the files are in printing/, the next start learns of a print that the history does not have,
  // and holds the queue.
  for (const std::shared_future<void>& kept : {print.noted, print.held}) {
    if (kept.valid()) (void)kept.wait_for(kLongestNoting);
  }
  filed.moved = attempt("stays in printing", filed, [&] {
    if (!spool.end(print.files, folder))
      filed.troubles.push_back(fmt::format("{} is gone: someone removed it", print.files.model.string()));
  });
  return filed;
}

std::optional<PrintOutcome> outcome_called(std::string_view name) {
  for (const PrintOutcome outcome : {PrintOutcome::Done, PrintOutcome::Canceled, PrintOutcome::Failed}) {
    if (name_of(outcome) == name) return outcome;
  }
  return std::nullopt;
}

}  // namespace

PrintArchivist::PrintArchivist(EventLoop& loop, const Spool& spool)
    : spool_(spool), worker_(loop, "contourd-filing", kArchivistNiceness) {}

void PrintArchivist::file(EndedPrint print, std::function<void(const FiledPrint&)> done) {
  expects(!busy_, "no other print is being filed");
  busy_ = true;
  // Tasks of a worker are copied, but an engine cannot be. It is destroyed on the worker's thread, because a
  // large one takes time.
  auto shared = std::make_shared<EndedPrint>(std::move(print));
  worker_.run([&spool = spool_, shared = std::move(shared)] { return file_print(spool, *shared); },
              [this, done = std::move(done)](const FiledPrint& filed) {
                busy_ = false;
                done(filed);
              });
}

void record_end(const Spool& spool, const std::string& job, const PrintEnd& end) {
  if (recorded_end(spool, job)) return;
  const nlohmann::json record{
      {"job", as_recorded(job)}, {"outcome", name_of(end.outcome)}, {"reason", end.reason}, {"key", end.key}};
  spool.records().keep_end_of_print(record.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

std::shared_future<void> PrintArchivist::record(const std::string& job, const PrintEnd& end) {
  const auto recorded = std::make_shared<std::promise<void>>();
  worker_.run(
      [&spool = spool_, job, end, recorded] {
        try {
          record_end(spool, job, end);
        } catch (const std::system_error&) {
          // Tried again, and reported, when the print is filed.
        }
        recorded->set_value();
        return true;
      },
      [](bool) {});
  return recorded->get_future().share();
}

Spool::Folder folder_for(PrintOutcome outcome) {
  return outcome == PrintOutcome::Done ? Spool::Folder::Done : Spool::Folder::Failed;
}

std::string reason_text(const PrintEnd& end) {
  switch (end.outcome) {
    case PrintOutcome::Done:
      return "";
    case PrintOutcome::Canceled:
      return "Cancelled by the user.\n";
    case PrintOutcome::Failed:
      return end.reason + "\n";
  }
  return "";
}

EndedJob ended_job(const PrintEnd& end) {
  const auto now = std::chrono::system_clock::now();
  return {.name = end.job,
          .outcome = std::string(name_of(end.outcome)),
          .reason = end.reason,
          .began = now,
          .ended = now,
          .key = end.key};
}

// An unreadable record counts as no record.
std::optional<PrintEnd> last_recorded_end(const Spool& spool) {
  const auto record = nlohmann::json::parse(spool.records().end_of_print(), nullptr, false);
  if (!record.is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    const auto found = record.find(key);
    return found != record.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::optional<PrintOutcome> outcome = outcome_called(text("outcome"));
  const auto key = record.find("key");
  if (!outcome || key == record.end() || !key->is_number_integer()) return std::nullopt;
  return PrintEnd{*outcome, text("reason"), key->get<std::int64_t>(), text("job")};
}

std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job) {
  std::optional<PrintEnd> last = last_recorded_end(spool);
  if (last && last->job != as_recorded(job)) last.reset();
  return last;
}

}  // namespace contourd
