#include "daemon/spool/printing_copies.hpp"

#include <fmt/format.h>

#include <exception>
#include <system_error>

#include "daemon/json/config_error.hpp"
#include "daemon/spool/job_moves.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// The folder for unfinished copies, in printing/.
constexpr const char* kCopies = ".copies";

}  // namespace

PrintingCopies::PrintingCopies(const SpoolFolders& folders, JobEndRecord& ends, CopiedOriginals& originals)
    : folders_(folders),
      ends_(ends),
      originals_(originals),
      under_way_(folders.path(SpoolFolder::Printing) / kCopies) {}

void PrintingCopies::remove_leftovers() const {
  std::error_code ignored;
  fs::remove_all(under_way_, ignored);
}

JobCopy PrintingCopies::copy(const std::string& file) {
  try {
    return {.job = copy_whole(file)};
  } catch (const JobUnreadable& error) {
    return {.job = {}, .unreadable = error.what()};
  } catch (const ConfigError& error) {
    return {.job = {}, .unreadable = fmt::format("the job ticket is wrong: {}", error.in_one_line())};
  } catch (const std::exception& error) {
    remove_leftovers();
    return {.job = {}, .unreadable = {}, .trouble = error.what()};
  }
}

JobFiles PrintingCopies::copy_whole(const std::string& file) {
  fs::remove_all(under_way_);
  fs::create_directory(under_way_);
  const JobFiles from = folders_.files_of(SpoolFolder::Incoming, file);
  const std::string mark = mark_of(from);
  JobFiles to = folders_.named(SpoolFolder::Printing, folders_.unused_name(from.name), from);
  JobFiles copy = to;
  copy.model = under_way_ / to.model.filename();
  if (to.ticket) copy.ticket = under_way_ / to.ticket->filename();
  copy_job(from, copy, fs::space(folders_.root()).available, stopped_);
  ends_.release_name(to.name);
  originals_.expect(mark, copy.model);
  move_files(folders_, copy, to);
  std::error_code ignored;
  fs::remove(under_way_, ignored);
  try {
    originals_.add(mark);
  } catch (const std::system_error&) {
    remove_files(folders_, to);
    throw;
  }
  // The original can be removed if only the move was impossible, as between two file systems.
  remove_files(folders_, from);
  if (fs::exists(fs::symlink_status(from.model))) to.original = file;
  return to;
}

void PrintingCopies::take_back(const JobFiles& copy) {
  const std::string mark = mark_of(folders_.files_of(SpoolFolder::Incoming, copy.original));
  fs::create_directories(under_way_);
  originals_.expect(mark, copy.model);
  // One rename removes the copy at once: a partial copy would be taken for a job.
  fs::rename(copy.model, under_way_ / copy.model.filename());
  sync_folder(folders_.path(SpoolFolder::Printing));
  originals_.remove(mark);
  std::error_code ignored;
  if (copy.ticket) fs::remove(*copy.ticket, ignored);
  fs::remove_all(under_way_, ignored);
}

void PrintingCopies::give_back(const JobFiles& from, const JobFiles& to) {
  copy_job(from, to, fs::space(folders_.path(SpoolFolder::Incoming)).available, stopped_);
  remove_files(folders_, from);
}

}  // namespace contourd
