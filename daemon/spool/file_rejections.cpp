#include "daemon/spool/file_rejections.hpp"

#include <filesystem>
#include <system_error>

#include "daemon/spool/job_moves.hpp"
#include "daemon/spool/upload_state.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

fs::path reason_file(const SpoolFolders& folders, const JobEnd& end) {
  return folders.path(SpoolFolder::Failed) / (end.job + ".reason.txt");
}

}  // namespace

FileRejections::Result FileRejections::file(const std::string& file, JobEnd end) {
  Result result{Rejection::Impossible};
  try {
    result.rejection = move(file, end);
  } catch (const std::system_error& error) {
    result.trouble = error.what();
  }
  if (result.rejection == Rejection::Unfinished)
    ends_.drop(end.key);
  else
    ends_.taken(end.key,
                EndConsumer::Files);  // a job that stays in incoming/ is checked again at the next start
  return result;
}

Rejection FileRejections::move(const std::string& file, JobEnd& end) {
  const JobFiles from = folders_.files_of(SpoolFolder::Incoming, file);
  if (is_unfinished(from)) return Rejection::Unfinished;
  const JobFiles to = folders_.named(SpoolFolder::Failed, folders_.unused_name(from.name), from);
  const std::int64_t changed = change_time(from.model);
  end.job = to.name;
  end.file = file;
  end.mark = mark_of(from);
  try {
    ends_.add(end);
  } catch (const std::system_error&) {
    // A full disk has no room for the record, but a rename needs none.
  }
  write_reason(end);
  // Writing the reason may take seconds, and a user may have written the model again meanwhile.
  if (change_time(from.model) != changed) {
    fs::remove(reason_file(folders_, end));
    return Rejection::Unfinished;
  }
  try {
    move_files(folders_, from, to);
    return Rejection::Filed;
  } catch (const std::system_error& error) {
    if (!is_immovable(error.code())) throw;
    originals_.add(end.mark);
    return Rejection::LeftThere;
  }
}

void FileRejections::finish() {
  for (const JobEndRecord::Pending& each : ends_.pending()) {
    const JobEnd& end = each.end;
    if (end.file.empty() || !each.awaits(EndConsumer::Files)) continue;
    const JobFiles from = folders_.files_of(SpoolFolder::Incoming, end.file);
    const JobFiles to = folders_.named(SpoolFolder::Failed, end.job, from);
    try {
      if (!end.mark.empty() && mark_of(from) == end.mark) {
        write_reason(end);
        move_files(folders_, from, to);
      } else {
        bring_ticket(folders_, {end.file, SpoolFolder::Failed, to.model.filename(), end.mark});
      }
    } catch (const std::system_error&) {
      continue;  // the next start tries again; a job that is still in incoming/ is checked again
    }
    ends_.taken(end.key, EndConsumer::Files);
  }
}

void FileRejections::write_reason(const JobEnd& end) const {
  fs::create_directories(folders_.path(SpoolFolder::Failed));
  write_durably(reason_file(folders_, end), end.reason + "\n");
}

}  // namespace contourd
