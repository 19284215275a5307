#include "daemon/jobs/unfiled_jobs.hpp"

#include <fmt/format.h>

#include "daemon/spool/job_filing.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr const char* kInterrupted =
    "The print was interrupted: the power was cut, or contourd was killed or crashed";

}  // namespace

void UnfiledJobs::file_all() {
  while (!jobs_.empty()) {
    const auto& [files, end, left] = jobs_.back();
    const Spool::Folder folder = end ? folder_for(end->outcome) : Spool::Folder::Failed;
    move_job(spool_, log_, files, folder,
             end ? reason_text(*end)
                 : fmt::format("{}. Put the model into incoming again to print it from the start.\n",
                               kInterrupted));
    log_.info(
        "interrupted",
        fmt::format("{}: moved to {}", printable(files.name), spool_.folder(folder).filename().string()),
        job_fields(files.name));
    if (left) {
      PrintEnd how = end.value_or(PrintEnd{PrintOutcome::Failed, kInterrupted});
      how.job = files.name;
      EndedJob ended = ended_job(how);
      ended.reports = spool_.reports_of(folder, files.name);
      use_.left_job_filed(ended);
    }
    jobs_.pop_back();
  }
}

void UnfiledJobs::log_that_they_stay() const {
  for (const Job& job : jobs_)
    log_.error("spool",
               fmt::format("{}: stays in printing until the state is saved", printable(job.files.name)),
               job_fields(job.files.name));
}

}  // namespace contourd
