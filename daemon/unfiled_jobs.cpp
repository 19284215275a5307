#include "daemon/unfiled_jobs.hpp"

#include <fmt/format.h>

#include "daemon/job_filing.hpp"
#include "daemon/readable.hpp"

namespace contourd {

void UnfiledJobs::file_all() {
  while (!jobs_.empty()) {
    const auto& [files, end] = jobs_.back();
    const Spool::Folder folder = end ? folder_for(end->outcome) : Spool::Folder::Failed;
    move_job(spool_, log_, files, folder,
             end ? reason_text(*end)
                 : "The print was interrupted: the power was cut, or contourd was killed or crashed. Put the "
                   "model into incoming again to print it from the start.\n");
    log_.info(
        "interrupted",
        fmt::format("{}: moved to {}", printable(files.name), spool_.folder(folder).filename().string()),
        job_fields(files.name));
    jobs_.pop_back();
  }
}

void UnfiledJobs::tell_they_stay() const {
  for (const Job& job : jobs_)
    log_.error("spool", fmt::format("{}: stays in printing until then", printable(job.files.name)),
               job_fields(job.files.name));
}

}  // namespace contourd
