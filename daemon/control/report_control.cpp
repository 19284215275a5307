#include "daemon/control/report_control.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "daemon/control/file_pieces.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {

using Json = ReportControl::Json;

namespace {

// Blocks. Throws ControlRefusal.
Json read_piece(const Spool& spool, const std::string& job, const WantedPiece& wanted) {
  std::filesystem::path path;
  const char* folder = "done";
  if (is_own_name(job)) {
    path = spool.reports_of(Spool::Folder::Done, job).html;
    if (path.empty()) {
      folder = "failed";
      path = spool.reports_of(Spool::Folder::Failed, job).html;
    }
  }
  if (path.empty()) throw ControlRefusal(fmt::format("there is no report of {}", in_quotes(job)));
  Json reply{{"job", job}, {"folder", folder}};
  add_piece(reply, path, wanted);
  return reply;
}

}  // namespace

ControlMethods ReportControl::methods() {
  return {{"report",
           {.description = "Returns the report page of a print that has ended, in pieces of an HTML file.",
            .parameters = {ControlParameter::text("job", "the job's name, as in the history").needed(),
                           piece_parameter("version", "the version of the report, for the next piece"),
                           piece_parameter("from", "position of the piece: the number of bytes received")},
            .call_later = [this](const Json& given, const ControlCaller&, ControlMethod::Later later) {
              const auto job = given["job"].get<std::string>();
              const WantedPiece wanted = wanted_piece("the report of " + in_quotes(job), given);
              read_later(spool_, std::move(later),
                         [&spool = spool_, job, wanted] { return read_piece(spool, job, wanted); });
            }}}};
}

}  // namespace contourd
