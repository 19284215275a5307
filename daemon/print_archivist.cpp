#include "daemon/print_archivist.hpp"

#include <fmt/format.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/image/preview.hpp"
#include "daemon/print_report_html.hpp"
#include "daemon/print_report_json.hpp"
#include "daemon/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// It gives way to the event loop, and to a model that is read.
constexpr int kNiceness = 5;
constexpr Pixels kPreviewWidth{720}, kPreviewHeight{720};

// What the preview shows: all copies on a plate, but one of each model when that is too much to draw.
std::vector<PreviewPart> preview_parts(const JobSummary& summary, const ContourEngine& engine) {
  constexpr std::uint64_t kMaxFacets = 5'000'000;  // some seconds of drawing
  std::uint64_t facets = 0;
  for (std::size_t i = 0; i < summary.models.size(); ++i)
    facets += engine.models()[i].model->facets().size() * summary.models[i].centers.size();
  const bool all = summary.plate && facets <= kMaxFacets;
  std::vector<PreviewPart> parts;
  for (std::size_t i = 0; i < summary.models.size(); ++i) {
    const PlateModel& standing = engine.models()[i];
    const HeightIndex& model = *standing.model;
    const std::vector<Point>& centers = summary.models[i].centers;
    const Point middle = model.bounds().center();
    const double lift_mm = standing.elevation.lift(model.bounds()).count();
    for (std::size_t copy = 0; copy < (all ? centers.size() : 1); ++copy) {
      parts.push_back({model.facets(), centers[copy].x - middle.x, centers[copy].y - middle.y, lift_mm});
    }
  }
  return parts;
}

std::vector<std::uint8_t> draw_preview(const PrintReport& report, const ContourEngine& engine) {
  const Nanometers printed =
      report.layers.empty() ? Nanometers{} : report.layers.back().bottom + report.layers.back().thickness;
  const std::vector<PreviewPart> parts = preview_parts(report.summary, engine);
  return encode_png(render_preview(parts, to_millimeters(printed), kPreviewWidth, kPreviewHeight));
}

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
  attempt("no picture", filed, [&] { report.preview_png = draw_preview(report, *print.engine); });
  attempt("no report.html", filed,
          [&] { spool.write_beside(folder, report.job, "report.html", report_as_html(report)); });
  if (report.preview_png.empty()) return;
  const std::string picture(report.preview_png.begin(), report.preview_png.end());
  attempt("no preview.png", filed, [&] { spool.write_beside(folder, report.job, "preview.png", picture); });
}

// A name may be no UTF-8, which JSON is.
std::string as_recorded(const std::string& job) {
  return printable(job);
}

void write_record(const Spool& spool, const std::string& job, const PrintEnd& end) {
  if (recorded_end(spool, job)) return;
  const nlohmann::json record{
      {"job", as_recorded(job)}, {"outcome", name_of(end.outcome)}, {"reason", end.reason}};
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
    : spool_(spool), worker_(loop, "contourd-filing", kNiceness) {}

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
std::optional<PrintEnd> recorded_end(const Spool& spool, const std::string& job) {
  const auto record = nlohmann::json::parse(spool.records().end_of_print(), nullptr, false);
  if (!record.is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    const auto found = record.find(key);
    return found != record.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::optional<PrintOutcome> outcome = outcome_called(text("outcome"));
  if (!outcome || text("job") != as_recorded(job)) return std::nullopt;
  return PrintEnd{*outcome, text("reason")};
}

}  // namespace contourd
