#include "daemon/spool/job_moves.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>

#include "daemon/formats/model_names.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

void move_ticket(const JobFiles& from, const JobFiles& to, bool shared) {
  if (shared) {
    try {
      return copy_ticket(*from.ticket, *to.ticket);
    } catch (const JobUnreadable&) {
      // The ticket is moved instead; its reader then reports what is wrong with it.
    }
  }
  std::error_code code;
  fs::rename(*from.ticket, *to.ticket, code);
  if (code && code != std::errc::no_such_file_or_directory)
    throw std::system_error(code,
                            fmt::format("cannot move {} to {}", from.ticket->string(), to.ticket->string()));
}

// Moves incoming/`ticket` beside the job's model, which was moved first.
void bring_ticket_to(const SpoolFolders& folders, const JobFiles& job, const std::string& ticket) {
  const fs::path left = folders.path(SpoolFolder::Incoming) / ticket;
  std::error_code code;  // a ticket that cannot be moved stays for the case that its model is submitted again
  if (job.plate || job.ticket || !folders.models_of_ticket(ticket).empty()) return;
  if (change_time(left) < change_time(job.model))
    fs::rename(left, job.model.parent_path() / (job.name + ".json"), code);
}

// Returns the folder for a file in printing/ that belongs to no job there: a ticket goes to its model.
SpoolFolder folder_of_lost(const SpoolFolders& folders, const std::string& ticket) {
  if (!ticket.ends_with(".json")) return SpoolFolder::Failed;
  std::error_code code;
  const auto lacks_it = [&](const fs::path& model) {
    return fs::exists(fs::symlink_status(model, code)) &&
           !fs::exists(fs::symlink_status(model.parent_path() / ticket, code));
  };
  for (const fs::path& model : folders.models_of_ticket(ticket)) {
    if (lacks_it(model)) return SpoolFolder::Incoming;
  }
  const bool is_done = std::ranges::any_of(model_extensions(), [&](std::string_view extension) {
    return lacks_it(folders.path(SpoolFolder::Done) /
                    (fs::path(ticket).stem().string() + std::string(extension)));
  });
  return is_done ? SpoolFolder::Done : SpoolFolder::Failed;
}

FileDescriptor open_part(const fs::path& path) {
  try {
    return open_regular_file(path, Links::Refuse);
  } catch (const UnreadableFile& error) {
    throw JobUnreadable(fmt::format("cannot read {}: {}", printable(path.string()), error.what()));
  }
}

std::system_error failure(const fs::path& path) {
  return std::system_error(errno, std::generic_category(), "cannot copy " + path.string());
}

void write_all(const FileDescriptor& file, const char* bytes, std::size_t size, const fs::path& path) {
  while (size > 0) {
    const ssize_t written = ::write(file.get(), bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure(path);
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
}

// Copies at most `size` bytes, so that a file that grows meanwhile cannot fill the disk.
void copy_file(const FileDescriptor& from, std::uintmax_t size, const fs::path& to,
               const std::atomic<bool>& stop) {
  const FileDescriptor file(::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file.valid()) throw failure(to);
  std::vector<char> buffer(std::size_t{1} << 20U);
  while (size > 0) {
    if (stop) throw std::system_error(std::make_error_code(std::errc::operation_canceled));
    const ssize_t bytes = ::read(from.get(), buffer.data(), std::min<std::uintmax_t>(buffer.size(), size));
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) throw failure(to);
    if (bytes == 0) break;
    write_all(file, buffer.data(), static_cast<std::size_t>(bytes), to);
    size -= static_cast<std::uintmax_t>(bytes);
  }
  if (::fsync(file.get()) != 0) throw failure(to);
}

std::uintmax_t size_of(const FileDescriptor& file, const fs::path& path) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw failure(path);
  return static_cast<std::uintmax_t>(status.st_size);
}

// Copies the job to the folder `hidden` beside its destination, then moves the copy there in one step.
void copy_away(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to) {
  const fs::path hidden = to.model.parent_path() / ".copies";
  fs::remove_all(hidden);
  fs::create_directory(hidden);
  const auto copy = [&hidden](const fs::path& part, const fs::path& place) {
    fs::path copied = hidden / place.filename();
    fs::copy(part, copied, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    sync_contents(copied);
    return copied;
  };
  JobFiles copied = to;
  copied.model = copy(from.model, to.model);
  if (from.ticket) copied.ticket = copy(*from.ticket, *to.ticket);
  if (to.plate) fs::remove_all(to.model);  // a rename replaces a file, but not a folder
  move_files(folders, copied, to);
  std::error_code ignored;
  fs::remove(hidden, ignored);
}

fs::path place_of(const fs::path& part, const JobFiles& from, const JobFiles& to) {
  if (from.plate) return to.model / part.filename();
  return part == from.model ? to.model : *to.ticket;
}

}  // namespace

void move_files(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to) {
  const bool shared = folders.shares_ticket(from);
  // The model moves first, because the model's folder is the job's folder. A power cut between the two moves
  // then leaves an interrupted job; in the other order the job would be printed without its ticket.
  fs::rename(from.model, to.model);
  try {
    if (from.ticket) move_ticket(from, to, shared);
  } catch (const std::system_error&) {
    std::error_code ignored;
    fs::rename(to.model, from.model, ignored);
    throw;
  }
  sync_folder(to.model.parent_path());
  sync_folder(from.model.parent_path());
}

void file_away(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to) {
  try {
    return move_files(folders, from, to);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::cross_device_link) throw;
  }
  const bool shared = folders.shares_ticket(from);
  copy_away(folders, from, to);
  fs::remove_all(from.model);
  if (from.ticket && !shared) fs::remove(*from.ticket);
  sync_folder(from.model.parent_path());
}

bool is_immovable(const std::error_code& code) {
  return code == std::errc::permission_denied || code == std::errc::operation_not_permitted ||
         code == std::errc::cross_device_link || code == std::errc::device_or_resource_busy;
}

void bring_ticket(const SpoolFolders& folders, const MovedModel& moved) {
  const JobFiles job = folders.files_of(moved.folder, moved.model);
  if (!moved.mark.empty() && mark_of(job) == moved.mark)
    bring_ticket_to(folders, job, job_name_of(moved.file) + ".json");
}

void remove_files(const SpoolFolders& folders, const JobFiles& job) {
  JobFiles own = job;
  if (folders.shares_ticket(job)) own.ticket.reset();
  std::error_code ignored;
  for (const fs::path& part : parts_of(own))
    fs::remove(part, ignored);
  if (own.plate) fs::remove(own.model, ignored);
}

std::int64_t change_time(const fs::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return 0;
  return status.st_ctim.tv_sec * std::int64_t{1'000'000'000} + status.st_ctim.tv_nsec;
}

std::vector<JobFiles> jobs_left_in_printing(const SpoolFolders& folders) {
  std::vector<JobFiles> jobs;
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folders.path(SpoolFolder::Printing))) {
    const std::string file = entry.path().filename().string();
    if (is_model_name(file) || folders.is_plate(SpoolFolder::Printing, file)) {
      bring_ticket_to(folders, folders.files_of(SpoolFolder::Printing, file), job_name_of(file) + ".json");
      jobs.push_back(folders.files_of(SpoolFolder::Printing, file));
    } else {
      others.push_back(entry.path());
    }
  }
  for (const fs::path& other : others) {
    const bool belongs_to_job =
        std::any_of(jobs.begin(), jobs.end(), [&](const JobFiles& job) { return job.ticket == other; });
    if (belongs_to_job) continue;
    const fs::path place = folders.path(folder_of_lost(folders, other.filename())) / other.filename();
    std::error_code code;  // a file that cannot be moved waits for the next start
    if (!fs::exists(fs::symlink_status(place, code))) fs::rename(other, place, code);
  }
  return jobs;
}

void copy_job(const JobFiles& from, const JobFiles& to, std::uintmax_t most_bytes,
              const std::atomic<bool>& stop) {
  if (from.plate) fs::create_directory(to.model);
  for (const fs::path& part : parts_of(from)) {
    const FileDescriptor file = open_part(part);
    const std::uintmax_t size = size_of(file, part);
    if (size > most_bytes)
      throw std::system_error(std::make_error_code(std::errc::no_space_on_device),
                              "cannot copy " + part.string());
    most_bytes -= size;
    copy_file(file, size, place_of(part, from, to), stop);
  }
  if (from.plate) sync_folder(to.model);
}

void copy_ticket(const fs::path& from, const fs::path& to) {
  const FileDescriptor file = open_part(from);
  const std::uintmax_t size = size_of(file, from);
  if (size > JsonDocument::kLargestBytes) throw JobUnreadable(from.string() + " is too large for a ticket");
  copy_file(file, size, to, false);
}

}  // namespace contourd
