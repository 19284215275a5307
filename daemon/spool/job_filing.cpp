#include "daemon/spool/job_filing.hpp"

#include <fmt/format.h>

#include <system_error>

#include "daemon/system/readable.hpp"

namespace contourd {

void move_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason) {
  std::string trouble;
  try {
    if (!reason.empty()) spool.write_beside(to, files.name, "reason.txt", reason);
  } catch (const std::system_error& error) {
    trouble = error.what();  // on a full disk the reason cannot be written, but the job can be renamed
  }
  if (!spool.end(files, to))
    log.error("spool", fmt::format("{} is gone: someone removed it", printable(files.model.string())),
              job_fields(files.name));
  if (!trouble.empty())
    log.error("spool",
              fmt::format("{}: cannot write its reason file: {}", printable(files.name), printable(trouble)),
              job_fields(files.name));
}

void file_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason) {
  try {
    move_job(spool, log, files, to, reason);
  } catch (const std::system_error& error) {
    log.error("spool",
              fmt::format("{}: stays in printing: {}", printable(files.name), printable(error.what())),
              job_fields(files.name));
  }
}

}  // namespace contourd
