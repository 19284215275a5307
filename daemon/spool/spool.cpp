#include "daemon/spool/spool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <utility>

#include "daemon/spool/job_moves.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCopied = "copied-originals";

constexpr const char* kLock = ".lock";

bool is_same_file(const FileDescriptor& a, const FileDescriptor& b) {
  struct stat one {
  }, other{};
  return ::fstat(a.get(), &one) == 0 && ::fstat(b.get(), &other) == 0 && one.st_dev == other.st_dev &&
         one.st_ino == other.st_ino;
}

// Moves a job that has not begun from printing/ to incoming/. Throws std::runtime_error.
void return_to_incoming(const SpoolFolders& folders, PrintingCopies& copies, const JobFiles& files) {
  if (!files.original.empty()) return copies.take_back(files);
  const JobFiles to = folders.unused_in_incoming(files);
  try {
    move_files(folders, files, to);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::cross_device_link) throw;
    copies.give_back(files, to);
  }
}

}  // namespace

// Other users get no read permission for the lock file: a process that can open it could lock it.
void SpoolLock::take(const std::filesystem::path& spool) {
  constexpr int kFlags = O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  FileDescriptor lock(::open((spool / kLock).c_str(), O_RDWR | kFlags, 0600));
  // A memory card that has become read-only may become writable again later.
  if (!lock.valid() && errno == EROFS)
    lock = FileDescriptor(::open((spool / kLock).c_str(), (O_RDONLY | kFlags) & ~O_CREAT));
  if (!lock.valid()) {
    const std::error_code code(errno, std::generic_category());
    throw std::runtime_error(
        fmt::format("cannot write to the spool {}: {}", spool.string(), why_not_written(code)));
  }
  if (is_same_file(lock, lock_)) return;
  (void)::fchmod(lock.get(), 0600);  // a failure is ignored: the file keeps the mode that it was created with
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error(fmt::format("another contourd uses the spool {}", spool.string()));
  lock_ = std::move(lock);
}

Spool::Spool(fs::path root, EventLoop& loop, SpoolObserver& observer)
    : folders_(std::move(root)),
      state_(state_folder_path(folders_.root())),
      records_(state_),
      ends_(records_),
      originals_(state_ / kCopied),
      copies_(folders_, ends_, originals_),
      rejections_(folders_, ends_, originals_),
      watch_(
          folders_, originals_, [this] { make_folders(); }, loop, disk_, observer),
      disk_(loop, "contourd-spool") {
  make_folders();
  remove_leftovers();
  originals_.settle(folder(Folder::Printing));
  bring_ticket_of_last_claim();
  rejections_.finish();
}

void Spool::make_folders() {
  for (const Folder each : {Folder::Incoming, Folder::Printing, Folder::Done, Folder::Failed}) {
    const fs::path path = folder(each);
    std::error_code code;
    fs::create_directories(path, code);
    if (code)
      throw std::runtime_error(fmt::format("cannot make {}: {}", path.string(), why_not_written(code)));
    if (!fs::is_directory(fs::symlink_status(path, code)))
      throw std::runtime_error(fmt::format("{} is a symbolic link, not a folder", path.string()));
  }
  make_state_folder(state_);
  lock_.take(folders_.root());
}

void Spool::remove_leftovers() const {
  for (const fs::path& each :
       {folder(Folder::Printing), folder(Folder::Done), folder(Folder::Failed), state_})
    remove_unfinished_files(each);
  copies_.remove_leftovers();
}

Spool::~Spool() {
  stop_copying();
}

void Spool::open() {
  originals_.keep_those_in(folder(Folder::Incoming));
  watch_.open();
}

bool Spool::is_waiting(const std::string& file) const {
  std::error_code code;
  return fs::symlink_status(folder(Folder::Incoming) / file, code).type() != fs::file_type::not_found;
}

void Spool::bring_ticket_of_last_claim() const {
  const std::vector<std::string> claim = records_.claim();
  if (claim.size() == 3) bring_ticket(folders_, {claim[0], Folder::Printing, claim[1], claim[2]});
}

JobFiles Spool::begin(const std::string& file) {
  const JobFiles from = files_of(Folder::Incoming, file);
  const JobFiles to = folders_.named(Folder::Printing, folders_.unused_name(from.name), from);
  ends_.release_name(to.name);
  // Without a record, the next process would not find the ticket of a job that got another name.
  if (from.ticket && to.name != from.name)
    records_.keep_claim({file, to.model.filename().string(), mark_of(from)});
  move_files(folders_, from, to);
  return to;
}

bool Spool::end(const JobFiles& files, Folder where) {
  fs::create_directories(folder(where));
  const bool there = fs::exists(fs::symlink_status(files.model));
  if (there) file_away(folders_, files, folders_.named(where, files.name, files));
  ends_.files_taken(files.name);
  return there;
}

void Spool::begin_with_copy(const std::string& file, std::function<void(const Copy&)> done) {
  disk_.run([this, file] { return copies_.copy(file); },
            [this, file, done = std::move(done)](const Copy& copy) {
              if (copy.job && !copy.job->original.empty()) watch_.add_original(file);
              done(copy);
            });
}

void Spool::give_back(const JobFiles& files, std::function<void(const std::string&)> done) {
  disk_.run(
      [this, files]() -> std::string {
        try {
          return_to_incoming(folders_, copies_, files);
          return "";
        } catch (const std::runtime_error& error) {
          return error.what();
        }
      },
      [this, original = files.original, done = std::move(done)](const std::string& trouble) {
        if (!original.empty() && trouble.empty()) watch_.remove_original(original);
        done(trouble);
      });
}

void Spool::reject(const std::string& file, const JobEnd& end, Rejected done) {
  disk_.run([this, file, end] { return rejections_.file(file, end); },
            [this, file, done = std::move(done)](const FileRejections::Result& result) {
              if (result.rejection == Rejection::LeftThere) watch_.add_original(file);
              done(result);
            });
}

void Spool::write_beside(Folder where, const std::string& name, const std::string& suffix,
                         const std::string& text) const {
  fs::create_directories(folder(where));
  write_durably(folder(where) / (name + "." + suffix), text);
}

ReportFiles Spool::reports_of(Folder where, const std::string& name) const {
  const auto report = [&](const char* suffix) {
    std::error_code error;
    const fs::path file = folder(where) / (name + suffix);
    return fs::exists(fs::symlink_status(file, error)) ? file : fs::path();
  };
  return {.json = report(".report.json"), .html = report(".report.html")};
}

std::vector<JobFiles> Spool::interrupted() const {
  return jobs_left_in_printing(folders_);
}

std::vector<std::string> Spool::order() const {
  std::vector<std::string> files = records_.queue_order();
  std::erase_if(files, [this](const std::string& file) {
    return file.empty() || file.find('/') != std::string::npos || !is_waiting(file);
  });
  return files;
}

void Spool::keep(std::function<void(const StateRecords& records)> change,
                 std::function<void(const std::string& trouble)> done) {
  disk_.run(
      [this, change = std::move(change)]() -> std::string {
        try {
          change(records_);
          return "";
        } catch (const std::system_error& error) {
          return error.what();
        }
      },
      std::move(done));
}

std::string Spool::trouble() const {
  if (::access(folders_.root().c_str(), W_OK) == 0) return "";
  return fmt::format("the spool {} cannot be written: {}", folders_.root().string(),
                     why_not_written(std::error_code(errno, std::generic_category())));
}

std::uintmax_t Spool::free_bytes() const {
  return fs::space(folders_.root()).available;
}

}  // namespace contourd
