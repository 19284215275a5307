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
#include "daemon/report/printed_part.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// It gives way to the event loop, and to a model that is read.
constexpr int kArchivistNiceness = 5;
// How long a disk may take to note the print in the history before the print is filed all the same.
constexpr std::chrono::seconds kLongestNoting{2};
// For the part's picture, and for those of layers in all: contourd may be about to stop, and waits for what
// is filed.
constexpr std::chrono::seconds kLongestPartPicture{10}, kLongestLayerPictures{5};

// What goes wrong is told as "`what`: why", and nothing follows from it.
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
    const auto deadline = MaskBudget::Clock::now() + kLongestPartPicture;
    report.preview = draw_printed_part(report, *print.engine, deadline);
    if (!report.preview) throw std::runtime_error("its masks take too long");
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

// A name may be no UTF-8, which JSON is.
std::string as_recorded(const std::string& job) {
  return printable(job);
}

void write_record(const Spool& spool, const std::string& job, const PrintEnd& end) {
  if (recorded_end(spool, job)) return;
  const nlohmann::json record{
      {"job", as_recorded(job)}, {"outcome", name_of(end.outcome)}, {"reason", end.reason}, {"key", end.key}};
  spool.records().keep_end_of_print(record.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

FiledPrint file_print(const Spool& spool, EndedPrint& print) {
  const PrintReport& report = print.report;
  FiledPrint filed{print.files, false, report.outcome, report.reason, {}, {}};
  const Spool::Folder folder = folder_for(report.outcome);
  const PrintEnd end{report.outcome, report.reason};
  attempt("no record of its end", filed, [&] { write_record(spool, report.job, end); });
  const std::string reason = reason_text(end);
  // A full disk has no room for what goes beside the job, but a rename needs none.
  if (!reason.empty())
    attempt("no reason beside it", filed,
            [&] { spool.write_beside(folder, report.job, "reason.txt", reason); });
  const bool recorded = attempt("no report", filed, [&] {
    spool.write_beside(folder, report.job, "report.json", report_as_json(report));
  });
  if (recorded) write_page_and_picture(spool, print, filed);
  filed.reports = spool.reports_of(folder, report.job);
  // As long as they are in printing/, the next start knows of the print what the history does not.
  if (print.noted.valid()) (void)print.noted.wait_for(kLongestNoting);
  filed.moved = attempt("stays in printing", filed, [&] {
    if (!spool.end(print.files, folder))
      filed.troubles.push_back(fmt::format("{} is gone: somebody took it away", print.files.model.string()));
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
  // Tasks are handed on by copy, an engine is not. It goes on the worker's thread: a large one takes its
  // time.
  auto shared = std::make_shared<EndedPrint>(std::move(print));
  worker_.run([&spool = spool_, shared = std::move(shared)] { return file_print(spool, *shared); },
              [this, done = std::move(done)](const FiledPrint& filed) {
                busy_ = false;
                done(filed);
              });
}

void PrintArchivist::record(const std::string& job, const PrintEnd& end) {
  worker_.run(
      [&spool = spool_, job, end] {
        try {
          write_record(spool, job, end);
        } catch (const std::system_error&) {
          return false;  // tried again, and told, when it is filed
        }
        return true;
      },
      [](bool) {});
}

Spool::Folder folder_for(PrintOutcome outcome) {
  return outcome == PrintOutcome::Done ? Spool::Folder::Done : Spool::Folder::Failed;
}

std::string reason_text(const PrintEnd& end) {
  switch (end.outcome) {
    case PrintOutcome::Done:
      return "";
    case PrintOutcome::Canceled:
      return "Cancelled by the owner.\n";
    case PrintOutcome::Failed:
      return end.reason + "\n";
  }
  return "";
}

// A record that nobody could make out is one of nothing.
std::optional<RecordedEnd> last_recorded_end(const Spool& spool) {
  const auto record = nlohmann::json::parse(spool.records().end_of_print(), nullptr, false);
  if (!record.is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    const auto found = record.find(key);
    return found != record.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::optional<PrintOutcome> outcome = outcome_called(text("outcome"));
  if (!outcome) return std::nullopt;
  const auto key = record.find("key");
  const bool has_key = key != record.end() && key->is_number_integer();
  return RecordedEnd{text("job"), {*outcome, text("reason"), has_key ? key->get<std::int64_t>() : 0}};
}

std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job) {
  const std::optional<RecordedEnd> last = last_recorded_end(spool);
  if (!last || last->job != as_recorded(job)) return std::nullopt;
  return last->end;
}

}  // namespace contourd
