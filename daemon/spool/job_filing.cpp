#include "daemon/spool/job_filing.hpp"

#include <fmt/format.h>

#include <system_error>

#include "daemon/system/readable.hpp"

namespace contourd {

std::vector<std::string> move_job(Spool& spool, const JobFiles& files, Spool::Folder to,
                                  const std::string& reason) {
  std::vector<std::string> troubles;
  try {
    if (!reason.empty()) spool.write_beside(to, files.name, "reason.txt", reason);
  } catch (const std::system_error& error) {
    // On a full disk the reason cannot be written, but the job can be renamed.
    troubles.push_back(
        fmt::format("{}: cannot write its reason file: {}", printable(files.name), printable(error.what())));
  }
  if (!spool.end(files, to))
    troubles.push_back(fmt::format("{} is gone: someone removed it", printable(files.model.string())));
  return troubles;
}

}  // namespace contourd
