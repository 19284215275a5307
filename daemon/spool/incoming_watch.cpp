#include "daemon/spool/incoming_watch.hpp"

#include <sys/epoll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "daemon/config/job_ticket.hpp"
#include "daemon/spool/job_moves.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

// Interval between looks at a file that is not known to be complete, and the number of looks without a change
// after which it counts as complete if the file system does not report writers (network shares). An empty
// file waits as long, since it may be the first step of a copy.
constexpr Duration kLookInterval = 1s;
constexpr int kQuietLooks = 3;
// Maximum number of looks that one turn of the event loop starts.
constexpr std::size_t kLooksATurn = 50;

}  // namespace

IncomingWatch::IncomingWatch(const SpoolFolders& folders, const CopiedOriginals& copied,
                             std::function<void()> make_folders, EventLoop& loop, Worker& disk,
                             SpoolObserver& observer)
    : folders_(folders),
      copied_(copied),
      make_folders_(std::move(make_folders)),
      loop_(loop),
      disk_(disk),
      observer_(observer),
      ignored_(loop, observer),
      folder_(folders.path(SpoolFolder::Incoming), loop, disk, *this) {}

void IncomingWatch::open() {
  inotify_ = FileDescriptor(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (!inotify_.valid())
    throw std::system_error(errno, std::generic_category(), "cannot watch folders (inotify)");
  // The watch starts before the folder is read, so that no file is missed.
  folder_.watch_by(inotify_.get());
  inotify_source_ = loop_.on_ready(inotify_.get(), EPOLLIN, "the spool (inotify)",
                                   [this](std::uint32_t) { read_events(); });
  consider_all();
}

int IncomingWatch::watch_plate(const std::string& file) const {
  if (!folders_.is_plate(SpoolFolder::Incoming, file)) return -1;
  const fs::path path = folders_.path(SpoolFolder::Incoming) / file;
  return ::inotify_add_watch(inotify_.get(), path.c_str(), kFolderChanges | IN_DONT_FOLLOW);
}

void IncomingWatch::stop_watching_plate(const std::string& file) {
  const auto watch = watch_of_plate_.find(file);
  if (watch == watch_of_plate_.end()) return;
  (void)::inotify_rm_watch(inotify_.get(), watch->second);
  plate_watches_.erase(watch->second);
  watch_of_plate_.erase(watch);
}

void IncomingWatch::folder_left() {
  while (!watch_of_plate_.empty())
    stop_watching_plate(std::string(watch_of_plate_.begin()->first));
}

void IncomingWatch::folder_replaced() {
  observer_.incoming_replaced();
  consider_all();
}

// --- events

// Reads one buffer in each turn of the event loop: reading all events could delay light off.
void IncomingWatch::read_events() {
  alignas(inotify_event) std::array<char, 4096> buffer;
  const ssize_t bytes = ::read(inotify_.get(), buffer.data(), buffer.size());
  for (ssize_t at = 0; at < bytes;) {
    const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
    at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    take_event(*event);
  }
}

void IncomingWatch::take_event(const inotify_event& event) {
  if ((event.mask & IN_Q_OVERFLOW) != 0) {
    // Events were lost, so every file is examined again.
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
  // The event is of a folder that is no longer watched.
  if (!folder_.is_watched_by(event.wd)) return;
  if ((event.mask & (IN_IGNORED | IN_MOVE_SELF)) != 0) return folder_.watch_anew();
  const std::string file = event.len > 0 ? event.name : "";
  // A file that was just created has no content yet.
  if (event.mask != IN_CREATE) consider_models_of(file);
  if ((event.mask & (IN_DELETE | IN_MOVED_FROM)) == 0) return consider(file, Look::Event);
  looks_.erase(file);
  ignored_.forget(file);
  seen_to_be_gone(file);
}

// Reports the models of a changed ticket again, since they are other jobs now.
void IncomingWatch::consider_models_of(const std::string& ticket) {
  if (!ticket.ends_with(".json")) return;
  disk_.run([this, ticket] { return folders_.models_of_ticket(ticket); },
            [this](const std::vector<fs::path>& models) {
              for (const fs::path& model : models) {
                const std::string file = model.filename().string();
                if (arrived_.contains(file)) consider(file, Look::Event);
              }
            });
}

// --- files

// Returns the names, oldest first. The order is that of the change times, since a copied or moved file may
// keep an old modification time.
std::vector<std::string> IncomingWatch::names_in_folder() const {
  std::vector<std::pair<std::int64_t, std::string>> found;
  std::error_code code;
  for (fs::directory_iterator entry(folders_.path(SpoolFolder::Incoming), code), end; !code && entry != end;
       entry.increment(code)) {
    found.emplace_back(change_time(entry->path()), entry->path().filename().string());
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (auto& [changed, name] : found)
    names.push_back(std::move(name));
  return names;
}

void IncomingWatch::consider_all() {
  disk_.run([this] { return names_in_folder(); },
            [this](const std::vector<std::string>& names) {
              ignored_.forget_all_but({names.begin(), names.end()});
              // Known files that are not in the folder may have been removed without an event.
              std::set<std::string> others = arrived_;
              others.insert(originals_.begin(), originals_.end());
              for (const auto& [file, missing] : incomplete_)
                others.insert(file);
              for (const std::string& name : names)
                others.erase(name);
              consider_soon({others.begin(), others.end()}, Look::Event);
              consider_soon({names.begin(), names.end()}, Look::Event);
            });
}

void IncomingWatch::consider_soon(std::deque<std::string> files, Look look) {
  for (std::string& file : files)
    to_consider_.emplace_back(std::move(file), look);
  if (!consider_timer_) consider_some();
}

void IncomingWatch::consider_some() {
  consider_timer_.reset();
  for (std::size_t i = 0; i < kLooksATurn && !to_consider_.empty(); ++i) {
    const auto [file, look] = to_consider_.front();
    to_consider_.pop_front();
    consider(file, look);
  }
  if (to_consider_.empty()) return;
  consider_timer_ = loop_.at(std::chrono::steady_clock::now(), "the spool", [this] { consider_some(); });
}

void IncomingWatch::consider(const std::string& file, Look look) {
  if (file.empty() || file.starts_with('.')) return;  // hidden files are not jobs
  const std::uint64_t number = looks_[file] = ++looks_begun_;
  disk_.run([this, file] { return look_at(file); },
            [this, file, look, number](const Seen& what) {
              const auto latest = looks_.find(file);
              if (latest == looks_.end()) {  // the file was removed during the look
                if (what.watch >= 0 && !plate_watches_.contains(what.watch))
                  (void)::inotify_rm_watch(inotify_.get(), what.watch);
                return;
              }
              // An outdated look is reported too, so that files arrive in the order of their first looks; the
              // later look then updates it.
              if (latest->second == number) looks_.erase(latest);
              seen(file, look, what);
            });
}

IncomingWatch::Seen IncomingWatch::look_at(const std::string& file) const noexcept {
  Seen seen;
  try {
    seen.watch = watch_plate(file);
    seen.upload = upload_state(folders_, file);
    if (seen.upload.is_there) {
      seen.taken = copied_.contains(folders_.files_of(SpoolFolder::Incoming, file));
      if (seen.upload.missing == std::vector<std::string>{kPlateTicket}) seen.why = WhyIgnored::Folder;
    } else if (!is_model_name(file)) {
      seen.why = why_ignored(folders_.path(SpoolFolder::Incoming) / file);
    }
  } catch (const std::exception&) {
    seen.upload.is_there = seen.upload.being_written = true;  // failed, so the file is examined again
  }
  return seen;
}

void IncomingWatch::seen_to_be_gone(const std::string& file) {
  candidates_.erase(file);
  incomplete_.erase(file);
  originals_.erase(file);
  stop_watching_plate(file);
  if (arrived_.erase(file) > 0) observer_.model_withdrawn(file);
}

void IncomingWatch::seen(const std::string& file, Look look, const Seen& seen) {
  const UploadState& upload = seen.upload;
  note_ignored(file, seen.why);
  if (!upload.is_there) return seen_to_be_gone(file);
  if (seen.taken) {
    candidates_.erase(file);
    originals_.insert(file);
    return;
  }
  originals_.erase(file);
  const bool watched = !upload.is_plate || watch_of_plate_.contains(file);
  // Events of a new watch are known only from now on, so the plate is examined again.
  if (!watched && seen.watch >= 0) {
    plate_watches_[seen.watch] = file;
    watch_of_plate_[file] = seen.watch;
    return consider(file, look);
  }
  note_missing(file, upload.missing);
  if (!upload.missing.empty()) {
    candidates_.erase(file);
    // If the kernel has no watches left, the timer examines the plate.
    if (!watched) look_later(file);
    return;
  }
  Candidate& candidate = this->candidate(file);
  if (upload.bytes != candidate.bytes) candidate.unchanged_looks = 0;
  if (look == Look::Timer) ++candidate.unchanged_looks;
  candidate.bytes = upload.bytes;
  const bool quiet = candidate.unchanged_looks >= kQuietLooks;
  if (!upload.being_written && (upload.known_to_be_whole || quiet)) {
    candidates_.erase(file);
    arrived_.insert(file);
    observer_.model_arrived(file);
    return;
  }
  look_later(file);
}

void IncomingWatch::note_ignored(const std::string& file, const std::optional<WhyIgnored>& why) {
  if (why) {
    ignored_.saw(file, *why);
  } else {
    ignored_.forget(file);
  }
}

std::vector<std::string> IncomingWatch::arriving(std::size_t most) const {
  std::vector<std::string> files;
  const auto take = [&](const auto& each) {
    for (auto file = each.begin(); file != each.end() && files.size() < most; ++file)
      files.push_back(file->first);
  };
  take(candidates_);
  take(incomplete_);
  take(looks_);
  return files;
}

IncomingWatch::Candidate& IncomingWatch::candidate(const std::string& file) {
  const auto [found, is_new] = candidates_.try_emplace(file);
  if (is_new) found->second.number = ++candidates_begun_;
  return found->second;
}

void IncomingWatch::look_later(const std::string& file) {
  (void)candidate(file);
  if (!look_again_timer_) {
    look_again_timer_ = loop_.at(std::chrono::steady_clock::now() + kLookInterval, "the spool's timer",
                                 [this] { look_again(); });
  }
}

void IncomingWatch::look_again() {
  look_again_timer_.reset();
  std::vector<std::pair<std::uint64_t, std::string>> in_order;
  for (const auto& [file, candidate] : candidates_)
    in_order.emplace_back(candidate.number, file);
  std::ranges::sort(in_order);
  std::deque<std::string> files;
  for (auto& [number, file] : in_order)
    files.push_back(std::move(file));
  consider_soon(std::move(files), Look::Timer);
}

// A folder without plate.json is not a plate, or not yet: IgnoredFiles reports it.
void IncomingWatch::note_missing(const std::string& file, const std::vector<std::string>& missing) {
  if (missing.empty()) {
    incomplete_.erase(file);
    return;
  }
  const bool was_complete = !incomplete_.contains(file);
  if (std::exchange(incomplete_[file], missing) != missing && missing.front() != kPlateTicket)
    observer_.plate_waits(file, missing);
  // The plate may be in the queue: one of its files was removed after it had been complete.
  if (was_complete) {
    arrived_.erase(file);
    observer_.model_withdrawn(file);
  }
}

}  // namespace contourd
