#include "daemon/jobs/unfiled_jobs.hpp"

#include <fmt/format.h>

#include "daemon/spool/job_filing.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
void JobFilingRun::run(Spool& spool) {
  for (const UnfiledJob& job : jobs_) {
    const Spool::Folder folder = folder_for(job.end);
    std::vector<std::string> troubles = move_job(spool, job.files, folder, reason_text(job.end));
    filed_.push_back({job, spool.reports_of(folder, job.files.name), std::move(troubles)});
  }
}

JobFilingRun UnfiledJobs::begin_filing() {
  if (filing_) return JobFilingRun({});
  filing_ = !jobs_.empty();
  return JobFilingRun({jobs_.rbegin(), jobs_.rend()});
}

void UnfiledJobs::end_filing(const JobFilingRun& run) {
  if (run.jobs_.empty()) return;
  filing_ = false;
  for (const auto& [job, reports, troubles] : run.filed_) {
    const std::string& name = job.files.name;
    for (const std::string& trouble : troubles)
      log_.error("spool", trouble, job_fields(name));
    std::erase_if(jobs_, [&name](const UnfiledJob& each) { return each.files.name == name; });
    log_.info("interrupted",
              fmt::format("{}: moved to {}", printable(name),
                          folder_for(job.end) == Spool::Folder::Done ? "done" : "failed"),
              job_fields(name));
    if (!job.left) continue;
    EndedJob ended = ended_job(job.end);
    ended.reports = reports;
    use_.left_job_filed(ended);
  }
}

void UnfiledJobs::log_that_they_stay() const {
  for (const UnfiledJob& job : jobs_)
    log_.error("spool",
               fmt::format("{}: stays in printing until the state is saved", printable(job.files.name)),
               job_fields(job.files.name));
}

}  // namespace contourd
