#include "daemon/history/history_store.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <optional>
#include <system_error>

#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Maximum number of damaged files that are kept; a further one replaces the last.
constexpr int kMostAside = 9;

struct FoundFile {
  ino_t inode = 0;
  std::string wrong;  // the clause that says what it is instead of a file, or empty
};

// Returns nullopt if the path does not exist. Throws std::system_error.
std::optional<FoundFile> look_at(const fs::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) {
    if (errno == ENOENT) return std::nullopt;
    throw std::system_error(errno, std::generic_category());
  }
  FoundFile found{.inode = status.st_ino, .wrong = {}};
  if (S_ISDIR(status.st_mode)) found.wrong = "is a folder";
  if (S_ISLNK(status.st_mode)) found.wrong = "is a link, which is not followed";
  if (found.wrong.empty() && !S_ISREG(status.st_mode)) found.wrong = "is not a file";
  return found;
}

fs::path with(const fs::path& file, const std::string& ending) {
  return file.string() + ending;
}

std::string reason(const SqliteError& error) {
  switch (error.code()) {
    case SQLITE_BUSY:
      return "another program has locked it";
    case SQLITE_FULL:
      return "the disk is full";
    case SQLITE_READONLY:
      return "it cannot be written";
    case SQLITE_INTERRUPT:
      return "the query takes too long";
    default:
      return error.what();
  }
}

}  // namespace

void HistoryStore::change(Call change) {
  waiting_.push_back(std::move(change));
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
  retry();
}

void HistoryStore::change_now_or_never(const Call& change) {
  try {
    with_database(change);
    trouble_.clear();
  } catch (const std::runtime_error& error) {
    trouble_ = error.what();
  }
}

void HistoryStore::retry() {
  change_now_or_never([](HistoryDatabase&) {});
}

void HistoryStore::ask(const Call& question) {
  with_database(question);
}

void HistoryStore::make_waiting_changes(HistoryDatabase& database) {
  while (!waiting_.empty()) {
    waiting_.front()(database);
    waiting_.pop_front();
  }
}

void HistoryStore::with_database(const Call& call) {
  const auto sentence = [this](const std::string& why) {
    return std::runtime_error(fmt::format("the history in {} cannot be used: {}", file_.string(), why));
  };
  for (bool is_retry = false;; is_retry = true) {
    try {
      open();
      make_waiting_changes(*database_);
      call(*database_);
      return;
    } catch (const SqliteError& error) {
      // After any error except a lock and a timeout, the file is opened and checked again.
      if (error.code() != SQLITE_BUSY && error.code() != SQLITE_INTERRUPT) database_.reset();
      if (is_retry || !error.is_corruption()) throw sentence(reason(error));
      try {
        put_aside(error.what());
      } catch (const std::system_error& not_renamed) {
        throw sentence(fmt::format("it is damaged ({}), and cannot be renamed: {}", error.what(),
                                   not_renamed.code().message()));
      }
    } catch (const NewerHistory& newer) {
      database_.reset();
      throw sentence(newer.what());
    } catch (const std::system_error& error) {
      database_.reset();
      throw sentence(error.code().message());
    }
  }
}

void HistoryStore::open() {
  const std::optional<FoundFile> found = look_at(file_);
  // A user may have removed or replaced the file.
  if (database_ && found && found->inode == inode_) return;
  database_.reset();
  for (const char* ending : {"", "-wal", "-shm"}) {
    const std::optional<FoundFile> each = look_at(with(file_, ending));
    if (each && !each->wrong.empty())
      throw SqliteError(SQLITE_CANTOPEN,
                        fmt::format("{} {}", with(file_, ending).filename().string(), each->wrong));
  }
  database_ = std::make_unique<HistoryDatabase>(file_);
  if (!found) sync_folder(file_.parent_path());
  const std::optional<FoundFile> opened = look_at(file_);
  inode_ = opened ? opened->inode : 0;
}

void HistoryStore::put_aside(const std::string& why) {
  int number = 1;
  while (number < kMostAside && look_at(with(file_, fmt::format(".damaged-{}", number))))
    ++number;
  const fs::path aside = with(file_, fmt::format(".damaged-{}", number));
  fs::rename(file_, aside);
  // The write-ahead log belongs to the damaged file and must not be applied to the new one.
  if (look_at(with(file_, "-wal"))) fs::rename(with(file_, "-wal"), with(aside, "-wal"));
  fs::remove(with(file_, "-shm"));
  sync_folder(file_.parent_path());
  notes_.push_back(
      fmt::format("the history was damaged ({}); it is kept as {}, and a new, empty one begins: the use of "
                  "lamp, film and vat is counted from zero",
                  why, aside.string()));
}

}  // namespace contourd
