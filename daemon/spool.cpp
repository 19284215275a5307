#include "daemon/spool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "daemon/config/printer_places.hpp"
#include "daemon/durable_file.hpp"
#include "daemon/job_copy.hpp"
#include "daemon/state_folder.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOccupied = "plate-occupied";
constexpr const char* kHeld = "queue-held";
constexpr const char* kLock = ".lock";
constexpr const char* kEnded = "ended-print";
constexpr const char* kCopied = "copied-originals";
// In printing/: copies under way.
constexpr const char* kCopies = ".copies";

std::string why(const std::error_code& code) {
  return code.message() + (code == std::errc::read_only_file_system ? kReadOnlyHint : "");
}

// In nanoseconds; 0 when it is not there.
std::int64_t change_time(const fs::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return 0;
  return status.st_ctim.tv_sec * std::int64_t{1'000'000'000} + status.st_ctim.tv_nsec;
}

bool is_same_file(const FileDescriptor& a, const FileDescriptor& b) {
  struct stat one {
  }, other{};
  return ::fstat(a.get(), &one) == 0 && ::fstat(b.get(), &other) == 0 && one.st_dev == other.st_dev &&
         one.st_ino == other.st_ino;
}

}  // namespace

Spool::Spool(fs::path root, EventLoop& loop, SpoolObserver& observer)
    : folders_(std::move(root)),
      state_(state_folder_path(folders_.root())),
      originals_(state_ / kCopied),
      watch_(
          folders_, originals_, [this] { make_folders(); }, loop, disk_, observer),
      disk_(loop) {
  make_folders();
  remove_leftovers();
  originals_.settle(folder(Folder::Printing));
}

void Spool::make_folders() {
  for (const Folder each : {Folder::Incoming, Folder::Printing, Folder::Done, Folder::Failed}) {
    const fs::path path = folder(each);
    std::error_code code;
    fs::create_directories(path, code);
    if (code) throw std::runtime_error(fmt::format("cannot make {}: {}", path.string(), why(code)));
    if (!fs::is_directory(fs::symlink_status(path, code)))
      throw std::runtime_error(fmt::format("{} is a symbolic link, not a folder", path.string()));
  }
  make_state_folder(state_);
  take_for_this_process();
}

void Spool::remove_leftovers() const {
  for (const fs::path& each :
       {folder(Folder::Printing), folder(Folder::Done), folder(Folder::Failed), state_})
    remove_unfinished_files(each);
  std::error_code ignored;
  fs::remove_all(folder(Folder::Printing) / kCopies, ignored);
}

Spool::~Spool() {
  stop_copying();
}

// The lock can be read by nobody else: whoever can read it could hold it.
void Spool::take_for_this_process() {
  const fs::path& root = folders_.root();
  constexpr int flags = O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  FileDescriptor lock(::open((root / kLock).c_str(), O_RDWR | flags, 0600));
  // A card that has become read-only may be written again later.
  if (!lock.valid() && errno == EROFS)
    lock = FileDescriptor(::open((root / kLock).c_str(), (O_RDONLY | flags) & ~O_CREAT));
  if (!lock.valid()) {
    const std::error_code code(errno, std::generic_category());
    throw std::runtime_error(fmt::format("cannot write in the spool {}: {}", root.string(), why(code)));
  }
  if (is_same_file(lock, lock_)) return;
  (void)::fchmod(lock.get(), 0600);  // where it cannot be changed now it is as it was made
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error(fmt::format("another contourd uses the spool {}", root.string()));
  lock_ = std::move(lock);
}

void Spool::open() {
  originals_.keep_those_in(folder(Folder::Incoming));
  watch_.open();
}

bool Spool::is_unfinished(const std::string& file) const {
  return contourd::is_unfinished(files_of(Folder::Incoming, file));
}

bool Spool::is_waiting(const std::string& file) const {
  std::error_code code;
  return fs::symlink_status(folder(Folder::Incoming) / file, code).type() != fs::file_type::not_found;
}

void Spool::move_job(const JobFiles& from, const JobFiles& to) const {
  const bool shared = folders_.shares_ticket(from);
  // The model first: where it is, the job is. Cut off in between, a job is filed as interrupted; the other
  // way round it would be printed without its ticket.
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

void Spool::move_ticket(const JobFiles& from, const JobFiles& to, bool shared) const {
  if (shared) {
    try {
      return copy_ticket(*from.ticket, *to.ticket);
    } catch (const JobUnreadable&) {
      // Moved: whoever reads it says what is wrong with it.
    }
  }
  std::error_code code;
  fs::rename(*from.ticket, *to.ticket, code);
  if (code && code != std::errc::no_such_file_or_directory)
    throw std::system_error(code,
                            fmt::format("cannot move {} to {}", from.ticket->string(), to.ticket->string()));
}

void Spool::remove_job(const JobFiles& job) const {
  JobFiles own = job;
  if (folders_.shares_ticket(job)) own.ticket.reset();
  std::error_code ignored;
  for (const fs::path& part : parts_of(own))
    fs::remove(part, ignored);
  if (own.plate) fs::remove(own.model, ignored);
}

JobFiles Spool::begin(const std::string& file) {
  const JobFiles from = files_of(Folder::Incoming, file);
  const JobFiles to = folders_.named(Folder::Printing, folders_.unused_name(from.name), from);
  forget_end_of_print();
  move_job(from, to);
  return to;
}

bool Spool::end(const JobFiles& files, Folder where) const {
  fs::create_directories(folder(where));
  const bool there = fs::exists(fs::symlink_status(files.model));
  if (there) move_job(files, folders_.named(where, files.name, files));
  forget_end_of_print();
  return there;
}

std::string Spool::end_of_print() const {
  return first_line_of(kEnded).value_or("");
}

void Spool::keep_end_of_print(const std::string& text) const {
  keep_line(kEnded, text);
}

// Another job may get this one's name.
void Spool::forget_end_of_print() const {
  std::error_code ignored;
  if (fs::remove(state_ / kEnded, ignored)) sync_folder(state_);
}

void Spool::begin_with_copy(const std::string& file, std::function<void(const Copy&)> done) {
  disk_.run([this, file] { return copy_to_printing(file); },
            [this, file, done = std::move(done)](const Copy& copy) {
              if (copy.job && !copy.job->original.empty()) watch_.add_original(file);
              done(copy);
            });
}

bool Spool::is_immovable(const std::error_code& code) {
  return code == std::errc::permission_denied || code == std::errc::operation_not_permitted ||
         code == std::errc::cross_device_link || code == std::errc::device_or_resource_busy;
}

// On the disk's thread. Copied under a name that is no job's: in printing/, a job is whole.
Spool::Copy Spool::copy_to_printing(const std::string& file) {
  const fs::path copies = folder(Folder::Printing) / kCopies;
  try {
    fs::remove_all(copies);
    fs::create_directory(copies);
    const JobFiles from = files_of(Folder::Incoming, file);
    const std::string mark = mark_of(from);
    JobFiles to = folders_.named(Folder::Printing, folders_.unused_name(from.name), from);
    JobFiles copy = to;
    copy.model = copies / to.model.filename();
    if (to.ticket) copy.ticket = copies / to.ticket->filename();
    copy_job(from, copy, free_bytes(), stop_copying_);
    forget_end_of_print();
    originals_.expect(mark, copy.model);
    move_job(copy, to);
    std::error_code ignored;
    fs::remove(copies, ignored);
    try {
      originals_.add(mark);
    } catch (const std::system_error&) {
      remove_job(to);
      throw;
    }
    // Possible where only the move was not, as to another file system.
    remove_job(from);
    if (fs::exists(fs::symlink_status(from.model))) to.original = file;
    return {.job = to, .unreadable = {}, .trouble = {}};
  } catch (const JobUnreadable& error) {
    return {.job = {}, .unreadable = error.what(), .trouble = {}};
  } catch (const ConfigError& error) {
    return {
        .job = {}, .unreadable = fmt::format("the job ticket is wrong:\n{}", error.what()), .trouble = {}};
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove_all(copies, ignored);
    return {.job = {}, .unreadable = {}, .trouble = error.what()};
  }
}

void Spool::take_back(const JobFiles& copy) {
  const std::string mark = mark_of(files_of(Folder::Incoming, copy.original));
  const fs::path copies = folder(Folder::Printing) / kCopies;
  fs::create_directories(copies);
  originals_.expect(mark, copy.model);
  // At once: half of it would be taken for a print.
  fs::rename(copy.model, copies / copy.model.filename());
  sync_folder(folder(Folder::Printing));
  originals_.remove(mark);
  watch_.remove_original(copy.original);
  std::error_code ignored;
  if (copy.ticket) fs::remove(*copy.ticket, ignored);
  fs::remove_all(copies, ignored);
}

void Spool::give_back(const JobFiles& files) {
  if (!files.original.empty()) return take_back(files);
  const JobFiles to = folders_.unused_in_incoming(files);
  try {
    move_job(files, to);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::cross_device_link) throw;
    copy_job(files, to, fs::space(folder(Folder::Incoming)).available, stop_copying_);
    remove_job(files);
  }
}

void Spool::reject(const std::string& file, const std::string& reason, Rejected done) {
  using Result = std::pair<Rejection, std::string>;
  disk_.run(
      [this, file, reason]() -> Result {
        try {
          return {file_rejected(file, reason), ""};
        } catch (const std::system_error& error) {
          return {Rejection::Impossible, error.what()};
        }
      },
      [this, file, done = std::move(done)](const Result& result) {
        if (result.first == Rejection::LeftThere) watch_.add_original(file);
        done(result.first, result.second);
      });
}

// On the disk's thread.
Spool::Rejection Spool::file_rejected(const std::string& file, const std::string& reason) {
  if (is_unfinished(file)) return Rejection::Unfinished;
  const JobFiles from = files_of(Folder::Incoming, file);
  const JobFiles to = folders_.named(Folder::Failed, folders_.unused_name(from.name), from);
  const std::int64_t changed = change_time(from.model);
  write_beside(Folder::Failed, to.name, "reason.txt", reason);
  // The disk took its time, and the owner wrote it anew meanwhile.
  if (change_time(from.model) != changed) {
    fs::remove(folder(Folder::Failed) / (to.name + ".reason.txt"));
    return Rejection::Unfinished;
  }
  try {
    move_job(from, to);
    return Rejection::Filed;
  } catch (const std::system_error& error) {
    if (!is_immovable(error.code())) throw;
    originals_.add(mark_of(from));
    return Rejection::LeftThere;
  }
}

void Spool::write_beside(Folder where, const std::string& name, const std::string& suffix,
                         const std::string& text) const {
  fs::create_directories(folder(where));
  write_durably(folder(where) / (name + "." + suffix), text);
}

// A ticket is moved after its model. Where that was cut off it lies in incoming/ still, and is older there
// than its model is in printing/.
void Spool::bring_ticket_of(const std::string& file) const {
  const JobFiles job = files_of(Folder::Printing, file);
  const std::string ticket = job.name + ".json";
  const fs::path left = folder(Folder::Incoming) / ticket;
  std::error_code code;  // where it cannot be moved it stays for its model to be put in again
  if (job.plate || job.ticket || !folders_.models_of_ticket(ticket).empty()) return;
  if (change_time(left) < change_time(job.model)) fs::rename(left, folder(Folder::Printing) / ticket, code);
}

// Where what lies in printing/ and is no job's belongs: a ticket to its model.
Spool::Folder Spool::folder_of_lost(const std::string& ticket) const {
  if (!ticket.ends_with(".json")) return Folder::Failed;
  std::error_code code;
  const auto lacks_it = [&](const fs::path& model) {
    return fs::exists(fs::symlink_status(model, code)) &&
           !fs::exists(fs::symlink_status(model.parent_path() / ticket, code));
  };
  for (const fs::path& model : folders_.models_of_ticket(ticket)) {
    if (lacks_it(model)) return Folder::Incoming;
  }
  const bool is_done = lacks_it((folder(Folder::Done) / ticket).replace_extension(".stl"));
  return is_done ? Folder::Done : Folder::Failed;
}

std::vector<JobFiles> Spool::interrupted() {
  std::vector<JobFiles> jobs;
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder(Folder::Printing))) {
    const std::string file = entry.path().filename().string();
    if (is_model_name(file) || folders_.is_plate(Folder::Printing, file)) {
      bring_ticket_of(file);
      jobs.push_back(files_of(Folder::Printing, file));
    } else {
      others.push_back(entry.path());
    }
  }
  for (const fs::path& other : others) {
    const bool belongs_to_job =
        std::any_of(jobs.begin(), jobs.end(), [&](const JobFiles& job) { return job.ticket == other; });
    if (belongs_to_job) continue;
    std::error_code code;  // where it cannot be moved it waits for the next start
    fs::rename(other, folder(folder_of_lost(other.filename())) / other.filename(), code);
  }
  return jobs;
}

std::optional<std::string> Spool::first_line_of(const char* name) const {
  std::ifstream file(state_ / name);
  if (!file) return std::nullopt;
  std::string line;
  std::getline(file, line);
  return line;
}

void Spool::keep_line(const char* name, const std::optional<std::string>& line) const {
  if (first_line_of(name) == line) return;
  if (line) {
    write_durably(state_ / name, *line + "\n");
  } else {
    fs::remove(state_ / name);
    sync_folder(state_);
  }
}

std::optional<std::string> Spool::plate_occupant() const {
  return first_line_of(kOccupied);
}
void Spool::set_plate_occupant(const std::optional<std::string>& job) const {
  keep_line(kOccupied, job);
}

std::optional<std::string> Spool::hold() const {
  return first_line_of(kHeld);
}
void Spool::set_hold(const std::optional<std::string>& why) const {
  keep_line(kHeld, why);
}

std::string Spool::trouble() const {
  if (::access(folders_.root().c_str(), W_OK) == 0) return "";
  return fmt::format("the spool {} cannot be written: {}", folders_.root().string(),
                     why(std::error_code(errno, std::generic_category())));
}

std::uintmax_t Spool::free_bytes() const {
  return fs::space(folders_.root()).available;
}

}  // namespace contourd
