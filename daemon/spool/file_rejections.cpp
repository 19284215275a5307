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
  Result result;
  try {
    move(file, end, result);
  } catch (const std::system_error& error) {
    result.trouble = error.what();
  }
  result.job = end.job;
  if (result.rejection == Rejection::Unfinished) {
    ends_.drop(end.key);
  } else if (result.rejection != Rejection::Impossible || end.outcome == "failed") {
    // A refused job that stays in incoming/ is checked again at the next start. A job that a user has removed
    // is moved then.
    ends_.taken(end.key, EndConsumer::Files);
  }
  return result;
}

void FileRejections::move(const std::string& file, JobEnd& end, Result& result) {
  const JobFiles from = folders_.files_of(SpoolFolder::Incoming, file);
  result.rejection = Rejection::Unfinished;
  if (is_unfinished(from)) return;
  const JobFiles to = folders_.named(SpoolFolder::Failed, folders_.unused_name(from.name), from);
  end.job = to.name;
  end.file = file;
  end.mark = mark_of(from);
  end.changed_ns = change_time(from.model);
  try {
    ends_.add(end);
  } catch (const std::system_error&) {
    // A full disk has no room for the record, but a rename needs none.
  }
  result.trouble = write_reason(end);
  // Writing the reason may take seconds, and a user may have written the model again meanwhile.
  if (change_time(from.model) != end.changed_ns) {
    std::error_code ignored;
    fs::remove(reason_file(folders_, end), ignored);
    return;
  }
  result.rejection = Rejection::Impossible;
  result.rejection = move_files_of(from, to, end);
}

Rejection FileRejections::move_files_of(const JobFiles& from, const JobFiles& to, const JobEnd& end) {
  try {
    file_away(folders_, from, to);
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
      // A model that was moved to failed/ and back has another time.
      if (!end.mark.empty() && mark_of(from) == end.mark && change_time(from.model) == end.changed_ns) {
        (void)write_reason(end);
        (void)move_files_of(from, to, end);
      } else {
        bring_ticket(folders_, {end.file, SpoolFolder::Failed, to.model.filename(), end.mark});
      }
    } catch (const std::system_error&) {
      continue;  // the next start tries again
    }
    ends_.taken(end.key, EndConsumer::Files);
  }
}

std::string FileRejections::write_reason(const JobEnd& end) const {
  try {
    fs::create_directories(folders_.path(SpoolFolder::Failed));
    write_durably(reason_file(folders_, end), end.reason + "\n");
    return "";
  } catch (const std::system_error& error) {
    return error.what();
  }
}

}  // namespace contourd
