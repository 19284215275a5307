#include "daemon/spool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "daemon/durable_file.hpp"
#include "daemon/job_copy.hpp"
#include "daemon/state_folder.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr const char* kOccupied = "plate-occupied";
constexpr const char* kHeld = "queue-held";
constexpr const char* kLock = ".lock";
constexpr const char* kEnded = "ended-print";
constexpr const char* kCopied = "copied-originals";
// In printing/: copies under way.
constexpr const char* kCopies = ".copies";

// File names have at most 255 bytes; a job's name leaves room for a number and for what is written beside it.
constexpr std::size_t kLongestName = 200;

// How often a file that is not known to be whole is looked at again, and after how many looks without a
// change it counts as whole where the file system cannot tell whether someone still writes (network shares).
// An empty file is given as long: it may be the first step of a copy.
constexpr Duration kLookInterval = 1s;
constexpr int kQuietLooks = 3;
// How many looks are begun in one turn of the event loop.
constexpr std::size_t kLooksATurn = 50;

std::system_error failure(const std::string& what) {
  return std::system_error(errno, std::generic_category(), what);
}

std::string why(const std::error_code& code) {
  return code.message() + (code == std::errc::read_only_file_system ? kReadOnlyHint : "");
}

// What it consists of, as far as that is possible.
void remove_job(const JobFiles& job) {
  std::error_code ignored;
  for (const fs::path& part : parts_of(job))
    fs::remove(part, ignored);
  if (job.plate) fs::remove(job.model, ignored);
}

enum class Writers { None, Some, Unknown };

// A read lease (fcntl(2), F_SETLEASE) is given only while nobody has the file open for writing.
Writers writers_of(const fs::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  if (!file.valid()) return Writers::Unknown;
  if (::fcntl(file.get(), F_SETLEASE, F_RDLCK) == 0) return Writers::None;  // given back on close
  return errno == EAGAIN ? Writers::Some : Writers::Unknown;
}

// In nanoseconds; 0 when it is not there.
std::int64_t change_time(const fs::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return 0;
  return status.st_ctim.tv_sec * std::int64_t{1'000'000'000} + status.st_ctim.tv_nsec;
}

constexpr std::uint32_t kChanges =
    IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_TO | IN_DELETE | IN_MOVED_FROM | IN_ONLYDIR;

bool is_folder(const fs::path& path) {
  std::error_code code;
  return fs::is_directory(fs::symlink_status(path, code));
}

// As many as are told.
constexpr std::size_t kMostMissing = 10;

// Which of a plate's files are not there, or the first of these. Nothing when its plate.json cannot be used:
// that is for its owner to hear.
std::vector<std::string> missing_models(const fs::path& plate) {
  std::vector<std::string> missing;
  try {
    for (const ModelTicket& model : load_plate_ticket(plate / kPlateTicket, Links::Refuse).models) {
      std::error_code code;
      const bool there = fs::exists(fs::symlink_status(plate / model.file, code));
      if (missing.size() == kMostMissing) break;
      if (!there && std::find(missing.begin(), missing.end(), model.file) == missing.end())
        missing.push_back(model.file);
    }
  } catch (const ConfigError&) {
  }
  return missing;
}

}  // namespace

std::string job_name_of(const std::string& file) {
  return is_model_name(file) ? fs::path(file).stem().string() : file;
}

bool is_model_name(const std::string& file) {
  std::string extension = fs::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension == ".stl" && !file.starts_with('.');
}

Spool::Spool(fs::path root, EventLoop& loop, SpoolObserver& observer)
    : root_(std::move(root)),
      state_(state_folder_path(root_)),
      loop_(loop),
      observer_(observer),
      originals_(state_ / kCopied),
      disk_(loop) {
  for (const Folder each : {Folder::Incoming, Folder::Printing, Folder::Done, Folder::Failed}) {
    std::error_code code;
    fs::create_directories(folder(each), code);
    if (code) throw std::runtime_error(fmt::format("cannot make {}: {}", folder(each).string(), why(code)));
    if (!is_folder(folder(each)))
      throw std::runtime_error(fmt::format("{} is a symbolic link, not a folder", folder(each).string()));
  }
  make_state_folder(state_);
  take_for_this_process();
  remove_leftovers();
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
  constexpr int flags = O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  lock_ = FileDescriptor(::open((root_ / kLock).c_str(), O_RDWR | flags, 0600));
  // A card that has become read-only may be written again later.
  if (!lock_.valid() && errno == EROFS)
    lock_ = FileDescriptor(::open((root_ / kLock).c_str(), (O_RDONLY | flags) & ~O_CREAT));
  if (!lock_.valid()) {
    const std::error_code code(errno, std::generic_category());
    throw std::runtime_error(fmt::format("cannot write in the spool {}: {}", root_.string(), why(code)));
  }
  (void)::fchmod(lock_.get(), 0600);  // where it cannot be changed now it is as it was made
  if (::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    throw std::runtime_error(fmt::format("another contourd uses the spool {}", root_.string()));
  }
}

fs::path Spool::folder(Folder which) const {
  switch (which) {
    case Folder::Incoming:
      return root_ / "incoming";
    case Folder::Printing:
      return root_ / "printing";
    case Folder::Done:
      return root_ / "done";
    case Folder::Failed:
      return root_ / "failed";
  }
  return root_;
}

void Spool::open() {
  inotify_ = FileDescriptor(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (!inotify_.valid()) throw failure("cannot watch folders (inotify)");
  // Watched before it is read, so that nothing can come in between.
  watch_incoming();
  originals_.keep_those_in(folder(Folder::Incoming));
  inotify_source_ = loop_.on_ready(inotify_.get(), EPOLLIN, "the spool (inotify)",
                                   [this](std::uint32_t) { read_events(); });
  consider_all();
}

// Oldest first. The change time, since a copied or moved file may keep an old modification time.
std::vector<std::string> Spool::names_in_incoming() const {
  std::vector<std::pair<std::int64_t, std::string>> found;
  std::error_code code;
  for (fs::directory_iterator entry(folder(Folder::Incoming), code), end; !code && entry != end;
       entry.increment(code)) {
    found.emplace_back(change_time(entry->path()), entry->path().filename().string());
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (auto& [changed, name] : found)
    names.push_back(std::move(name));
  return names;
}

void Spool::consider_all() {
  disk_.run([this] { return names_in_incoming(); },
            [this](const std::vector<std::string>& names) {
              consider_soon({names.begin(), names.end()}, Look::Event);
            });
}

void Spool::consider_soon(std::deque<std::string> files, Look look) {
  for (std::string& file : files)
    to_consider_.emplace_back(std::move(file), look);
  if (!consider_timer_) consider_some();
}

void Spool::consider_some() {
  consider_timer_.reset();
  for (std::size_t i = 0; i < kLooksATurn && !to_consider_.empty(); ++i) {
    const auto [file, look] = to_consider_.front();
    to_consider_.pop_front();
    consider(file, look);
  }
  if (to_consider_.empty()) return;
  consider_timer_ = loop_.at(std::chrono::steady_clock::now(), "the spool", [this] { consider_some(); });
}

void Spool::watch_incoming() {
  const std::string incoming = folder(Folder::Incoming).string();
  fs::create_directories(incoming);
  incoming_watch_ = ::inotify_add_watch(inotify_.get(), incoming.c_str(), kChanges);
  if (incoming_watch_ < 0) throw failure("cannot watch " + incoming);
}

void Spool::watch_incoming_anew() {
  watch_again_timer_.reset();
  try {
    watch_incoming();
  } catch (const std::system_error& error) {
    if (!std::exchange(incoming_lost_, true)) observer_.incoming_lost(error.what());
    watch_again_timer_ = loop_.at(std::chrono::steady_clock::now() + kLookInterval, "the spool's timer",
                                  [this] { watch_incoming_anew(); });
    return;
  }
  incoming_lost_ = false;
  consider_all();
}

bool Spool::watch_plate(const std::string& file) {
  const fs::path path = folder(Folder::Incoming) / file;
  const int watch = ::inotify_add_watch(inotify_.get(), path.c_str(), kChanges | IN_DONT_FOLLOW);
  if (watch < 0) return false;
  plate_watches_[watch] = file;
  watch_of_plate_[file] = watch;
  return true;
}

void Spool::stop_watching_plate(const std::string& file) {
  const auto watch = watch_of_plate_.find(file);
  if (watch == watch_of_plate_.end()) return;
  ::inotify_rm_watch(inotify_.get(), watch->second);
  plate_watches_.erase(watch->second);
  watch_of_plate_.erase(watch);
}

// One buffer a turn of the event loop: a folder can have more events than a light could wait for.
void Spool::read_events() {
  alignas(inotify_event) std::array<char, 4096> buffer;
  const ssize_t bytes = ::read(inotify_.get(), buffer.data(), buffer.size());
  for (ssize_t at = 0; at < bytes;) {
    const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
    at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    take_event(*event);
  }
}

void Spool::take_event(const inotify_event& event) {
  if ((event.mask & IN_Q_OVERFLOW) != 0) {
    // Events were lost: everything in the folder is looked at afresh.
    return consider_all();
  }
  if (const auto plate = plate_watches_.find(event.wd); plate != plate_watches_.end()) {
    const std::string file = plate->second;
    if ((event.mask & IN_IGNORED) != 0) {
      plate_watches_.erase(plate);
      watch_of_plate_.erase(file);
    }
    return consider(file, Look::Event);
  }
  // A plate's that is not watched any more.
  if (event.wd != incoming_watch_) return;
  // The folder itself was removed: made and watched anew.
  if ((event.mask & IN_IGNORED) != 0) return watch_incoming_anew();
  const std::string file = event.len > 0 ? event.name : "";
  if ((event.mask & (IN_DELETE | IN_MOVED_FROM)) == 0) return consider(file, Look::Event);
  looks_.erase(file);
  candidates_.erase(file);
  incomplete_.erase(file);
  originals_here_.erase(file);
  if ((event.mask & IN_ISDIR) != 0) stop_watching_plate(file);
  if (is_model_name(file) || (event.mask & IN_ISDIR) != 0) observer_.model_withdrawn(file);
}

Spool::Sight Spool::look_at_model(const fs::path& path) const {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  Sight sight;
  sight.bytes = static_cast<std::uintmax_t>(status.st_size);
  const Writers writers = writers_of(path);
  sight.being_written = is_unfinished(path.filename().string());
  sight.known_to_be_whole = (sight.bytes > 0 && writers == Writers::None) || !S_ISREG(status.st_mode);
  return sight;
}

Spool::Sight Spool::look_at_plate(const fs::path& path) const {
  Sight sight;
  std::error_code code;
  // Anybody's folder, or not yet a plate: what is in it does not matter.
  if (!fs::exists(fs::symlink_status(path / kPlateTicket, code)) && code != std::errc::permission_denied) {
    sight.missing = {kPlateTicket};
    return sight;
  }
  sight.known_to_be_whole = !code;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, code)) {
    struct stat status {};
    if (::lstat(entry.path().c_str(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
    const auto bytes = static_cast<std::uintmax_t>(status.st_size);
    const Writers writers = writers_of(entry.path());
    sight.bytes += bytes;
    sight.being_written = sight.being_written || writers == Writers::Some;
    sight.known_to_be_whole = sight.known_to_be_whole && bytes > 0 && writers == Writers::None;
  }
  if (!sight.being_written) sight.missing = missing_models(path);
  return sight;
}

void Spool::consider(const std::string& file, Look look) {
  if (file.empty() || file.starts_with('.')) return;  // hidden: none of ours
  const std::uint64_t number = looks_[file] = ++looks_begun_;
  disk_.run([this, file] { return look_at(file); },
            [this, file, look, number](const Sight& sight) {
              const auto latest = looks_.find(file);
              if (latest == looks_.end()) return;  // gone since
              // Where there is a later look it is still told, so that files arrive in the order of their
              // first looks; the later one tells it again.
              if (latest->second == number) looks_.erase(latest);
              seen(file, look, sight);
            });
}

// On the disk's thread.
Spool::Sight Spool::look_at(const std::string& file) const noexcept {
  const fs::path path = folder(Folder::Incoming) / file;
  Sight sight;
  try {
    const bool plate = is_plate(Folder::Incoming, file);
    std::error_code code;
    if (!plate && (!is_model_name(file) || !fs::exists(fs::symlink_status(path, code)))) return sight;
    sight = plate ? look_at_plate(path) : look_at_model(path);
    sight.is_plate = plate;
    sight.taken = originals_.contains(files_of(Folder::Incoming, file));
  } catch (const std::exception&) {
    sight.being_written = true;  // cannot be looked at now: looked at again
  }
  sight.is_there = true;
  return sight;
}

void Spool::seen(const std::string& file, Look look, const Sight& sight) {
  if (!sight.is_there) {
    candidates_.erase(file);
    return;
  }
  if (sight.taken) {
    candidates_.erase(file);
    originals_here_.insert(file);
    return;
  }
  originals_here_.erase(file);
  const bool watched = !sight.is_plate || watch_of_plate_.contains(file);
  // Watched before it is looked at, so that nothing can come in between. (The disk was asked for its path
  // just now, the kernel knows it.)
  if (!watched && watch_plate(file)) return consider(file, look);
  note_missing(file, sight.missing);
  if (!sight.missing.empty()) {
    candidates_.erase(file);
    // What cannot be watched, for want of watches, is looked at by the timer.
    if (!watched) look_later(file);
    return;
  }
  Candidate& candidate = candidates_[file];
  if (sight.bytes != candidate.bytes) candidate.unchanged_looks = 0;
  if (look == Look::Timer) ++candidate.unchanged_looks;
  candidate.bytes = sight.bytes;
  const bool quiet = candidate.unchanged_looks >= kQuietLooks;
  if (!sight.being_written && (sight.known_to_be_whole || quiet)) {
    candidates_.erase(file);
    observer_.model_arrived(file);
    return;
  }
  look_later(file);
}

void Spool::look_later(const std::string& file) {
  candidates_.try_emplace(file);
  if (!look_again_timer_) {
    look_again_timer_ = loop_.at(std::chrono::steady_clock::now() + kLookInterval, "the spool's timer",
                                 [this] { look_again(); });
  }
}

// A folder without plate.json is none of ours, or not yet: nothing is said of it.
void Spool::note_missing(const std::string& file, const std::vector<std::string>& missing) {
  if (missing.empty()) {
    incomplete_.erase(file);
    return;
  }
  const bool was_complete = !incomplete_.contains(file);
  if (std::exchange(incomplete_[file], missing) != missing && missing.front() != kPlateTicket)
    observer_.plate_waits(file, missing);
  // It may be in the queue: a file was taken out of it again.
  if (was_complete) observer_.model_withdrawn(file);
}

void Spool::look_again() {
  look_again_timer_.reset();
  std::deque<std::string> files;
  for (const auto& [file, candidate] : candidates_)
    files.push_back(file);
  consider_soon(std::move(files), Look::Timer);
}

bool Spool::is_unfinished(const std::string& file) const {
  const JobFiles files = files_of(Folder::Incoming, file);
  if (files.plate) {
    const Sight sight = look_at_plate(files.model);
    return sight.being_written || !sight.missing.empty();
  }
  return writers_of(files.model) == Writers::Some ||
         (files.ticket && writers_of(*files.ticket) == Writers::Some);
}

bool Spool::is_waiting(const std::string& file) const {
  std::error_code code;
  return fs::symlink_status(folder(Folder::Incoming) / file, code).type() != fs::file_type::not_found;
}

void Spool::wait_for(const std::string& file) {
  consider(file, Look::Event);
}

// A folder of any name that is not hidden, but not one called like a model: that is refused as what it is
// not.
bool Spool::is_plate(Folder where, const std::string& file) const {
  return !file.empty() && !file.starts_with('.') && !is_model_name(file) && is_folder(folder(where) / file);
}

JobFiles Spool::files_of(Folder where, const std::string& file) const {
  const fs::path model = folder(where) / file;
  if (is_plate(where, file)) return {file, model, std::nullopt, true, Links::Refuse};
  fs::path ticket = model;
  ticket.replace_extension(".json");
  JobFiles files{job_name_of(file), model, std::nullopt, false, Links::Refuse};
  // A name too long to have a ticket has none.
  std::error_code code;
  if (fs::exists(fs::symlink_status(ticket, code))) files.ticket = ticket;
  return files;
}

std::string Spool::unused_name(const std::string& full_stem) const {
  std::string stem = full_stem.substr(0, kLongestName);
  // Not in the middle of a UTF-8 sequence, which has at most three continuation bytes.
  const auto continues = [&](std::size_t at) {
    return at < full_stem.size() && (static_cast<unsigned char>(full_stem[at]) & 0xC0U) == 0x80;
  };
  for (int i = 0; i < 3 && continues(stem.size()); ++i)
    stem.pop_back();
  for (int number = 1;; ++number) {
    const std::string name = number == 1 ? stem : fmt::format("{}-{}", stem, number);
    const auto used_in = [&](Folder where) {
      for (const char* suffix : {"", ".stl", ".json", ".report.json", ".reason.txt"}) {
        if (fs::exists(fs::symlink_status(folder(where) / (name + suffix)))) return true;
      }
      return false;
    };
    if (!used_in(Folder::Printing) && !used_in(Folder::Done) && !used_in(Folder::Failed)) return name;
  }
}

JobFiles Spool::named(Folder where, const std::string& name, const JobFiles& like) const {
  JobFiles files{name, folder(where) / (like.plate ? name : name + ".stl"), std::nullopt, like.plate,
                 like.links};
  if (like.ticket) files.ticket = folder(where) / (name + ".json");
  return files;
}

void Spool::move_job(const JobFiles& from, const JobFiles& to) const {
  // The model first: where it is, the job is. Cut off in between, a job is filed as interrupted; the other
  // way round it would be printed without its ticket.
  fs::rename(from.model, to.model);
  std::error_code code;
  if (from.ticket) fs::rename(*from.ticket, *to.ticket, code);
  if (code && code != std::errc::no_such_file_or_directory) {
    std::error_code ignored;
    fs::rename(to.model, from.model, ignored);
    throw std::system_error(code,
                            fmt::format("cannot move {} to {}", from.ticket->string(), to.ticket->string()));
  }
  sync_folder(to.model.parent_path());
  sync_folder(from.model.parent_path());
}

JobFiles Spool::begin(const std::string& file) {
  const JobFiles from = files_of(Folder::Incoming, file);
  const JobFiles to = named(Folder::Printing, unused_name(from.name), from);
  forget_end_of_print();
  move_job(from, to);
  return to;
}

void Spool::end(const JobFiles& files, Folder where) const {
  fs::create_directories(folder(where));
  move_job(files, named(where, files.name, files));
  forget_end_of_print();
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
              if (copy.job && !copy.job->original.empty()) originals_here_.insert(file);
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
    JobFiles to = named(Folder::Printing, unused_name(from.name), from);
    JobFiles copy = to;
    copy.model = copies / to.model.filename();
    if (to.ticket) copy.ticket = copies / to.ticket->filename();
    copy_job(from, copy, free_bytes(), stop_copying_);
    forget_end_of_print();
    move_job(copy, to);
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
  originals_.remove(mark_of(files_of(Folder::Incoming, copy.original)));
  originals_here_.erase(copy.original);
  remove_job(copy);
}

bool Spool::give_back(const JobFiles& files) {
  if (!files.original.empty()) {
    take_back(files);
    return true;
  }
  const JobFiles to = named(Folder::Incoming, files.name, files);
  if (fs::exists(fs::symlink_status(to.model)) || (to.ticket && fs::exists(fs::symlink_status(*to.ticket))))
    return false;
  move_job(files, to);
  return true;
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
        if (result.first == Rejection::LeftThere) originals_here_.insert(file);
        done(result.first, result.second);
      });
}

// On the disk's thread.
Spool::Rejection Spool::file_rejected(const std::string& file, const std::string& reason) {
  if (is_unfinished(file)) return Rejection::Unfinished;
  const JobFiles from = files_of(Folder::Incoming, file);
  const JobFiles to = named(Folder::Failed, unused_name(from.name), from);
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

std::vector<JobFiles> Spool::interrupted() {
  std::vector<JobFiles> jobs;
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder(Folder::Printing))) {
    const std::string file = entry.path().filename().string();
    if (is_model_name(file) || is_plate(Folder::Printing, file)) {
      jobs.push_back(files_of(Folder::Printing, file));
    } else {
      others.push_back(entry.path());
    }
  }
  for (const fs::path& other : others) {
    const bool belongs_to_job =
        std::any_of(jobs.begin(), jobs.end(), [&](const JobFiles& job) { return job.ticket == other; });
    if (belongs_to_job) continue;
    fs::path model_in_incoming = folder(Folder::Incoming) / other.filename();
    model_in_incoming.replace_extension(".stl");
    const bool claimed_too_early =
        fs::exists(model_in_incoming) && !files_of(Folder::Incoming, model_in_incoming.filename()).ticket;
    std::error_code code;  // where it cannot be moved it waits for the next start
    fs::rename(other, folder(claimed_too_early ? Folder::Incoming : Folder::Failed) / other.filename(), code);
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
  if (::access(root_.c_str(), W_OK) == 0) return "";
  return fmt::format("the spool {} cannot be written: {}", root_.string(),
                     why(std::error_code(errno, std::generic_category())));
}

std::uintmax_t Spool::free_bytes() const {
  return fs::space(root_).available;
}

}  // namespace contourd
