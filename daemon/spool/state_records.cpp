#include "daemon/spool/state_records.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "daemon/system/durable_file.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOccupied = "plate-occupied";
constexpr const char* kHeld = "queue-held";
constexpr const char* kClaim = "claim";
constexpr const char* kEnded = "ended-jobs";
constexpr std::array kSpares{"ended-jobs.spare-1", "ended-jobs.spare-2"};
constexpr std::size_t kSpareBytes = 16'384;
constexpr const char* kOrder = "queue-order";
constexpr const char* kVat = "vat";
constexpr const char* kAccepted = "accepted";

[[noreturn]] void refuse(const std::filesystem::path& folder, const std::string& why) {
  throw std::runtime_error(fmt::format("cannot use the state folder {}: {}", folder.string(), why));
}

std::string joined(const std::vector<std::string>& texts, char end) {
  std::string all;
  for (const std::string& each : texts)
    all.append(each).push_back(end);
  return all;
}

std::string message(int error) {
  return std::generic_category().message(error);
}

}  // namespace

std::filesystem::path state_folder_path(const std::filesystem::path& spool) {
  const char* const folders = std::getenv("STATE_DIRECTORY");
  if (folders != nullptr && *folders != '\0') {
    const std::string_view all(folders);  // separated by colons
    return std::filesystem::path(all.substr(0, all.find(':')));
  }
  // A path may end with a slash.
  const std::filesystem::path folder = spool.has_filename() ? spool : spool.parent_path();
  return folder.string() + ".state";
}

std::filesystem::path progress_file(const std::filesystem::path& spool) {
  return state_folder_path(spool) / "print-progress";
}

std::filesystem::path frames_file(const std::filesystem::path& spool) {
  return state_folder_path(spool) / "print-frames";
}

void make_state_folder(const std::filesystem::path& folder) {
  // mkdir may fail although the folder exists already, as on a read-only disk.
  const int not_made = ::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST ? 0 : errno;
  const FileDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat status {};
  if (!opened.valid()) refuse(folder, message(not_made != 0 ? not_made : errno));
  if (::fstat(opened.get(), &status) != 0) refuse(folder, message(errno));
  if (status.st_uid != ::geteuid())
    refuse(folder,
           fmt::format("it belongs to user {}, contourd runs as user {}", status.st_uid, ::geteuid()));
  if ((status.st_mode & 077) != 0 && ::fchmod(opened.get(), 0700) != 0) refuse(folder, message(errno));
}

std::optional<std::string> StateRecords::first_line_of(const char* name) const {
  std::ifstream file(folder_ / name);
  if (!file) return std::nullopt;
  std::string line;
  std::getline(file, line);
  return line;
}

void StateRecords::keep_line(const char* name, const std::optional<std::string>& line) const {
  if (first_line_of(name) == line) return;
  if (line) {
    write_durably(folder_ / name, *line + "\n");
  } else {
    fs::remove(folder_ / name);
    sync_folder(folder_);
  }
}

std::optional<std::string> StateRecords::plate_occupant() const {
  return first_line_of(kOccupied);
}
void StateRecords::set_plate_occupant(const std::optional<std::string>& job) const {
  keep_line(kOccupied, job);
}

std::optional<std::string> StateRecords::hold() const {
  return first_line_of(kHeld);
}
void StateRecords::set_hold(const std::optional<std::string>& why) const {
  keep_line(kHeld, why);
}

std::optional<std::string> StateRecords::vat() const {
  return first_line_of(kVat);
}
void StateRecords::set_vat(const std::string& ml) const {
  keep_line(kVat, ml);
}

std::vector<std::string> StateRecords::texts_of(const char* name, char end) const {
  std::vector<std::string> texts;
  std::ifstream file(folder_ / name);
  // A last text without its end was cut off and is ignored.
  for (std::string text; std::getline(file, text, end) && !file.eof();)
    texts.push_back(text);
  return texts;
}

void StateRecords::keep_texts(const char* name, const std::vector<std::string>& texts, char end) const {
  if (texts.empty()) {
    if (fs::remove(folder_ / name)) sync_folder(folder_);
    return;
  }
  write_durably(folder_ / name, joined(texts, end));
}

std::vector<std::string> StateRecords::claim() const {
  return texts_of(kClaim, '\0');
}
void StateRecords::keep_claim(const std::vector<std::string>& fields) const {
  keep_texts(kClaim, fields, '\0');
}

std::vector<std::string> StateRecords::job_ends() const {
  return texts_of(kEnded, '\0');
}
void StateRecords::keep_job_ends(const std::vector<std::string>& fields) const {
  try {
    keep_texts(kEnded, fields, '\0');
  } catch (const std::system_error& error) {
    const bool is_full = error.code() == std::errc::no_space_on_device || error.code().value() == EDQUOT;
    if (!is_full || !write_over_spare(joined(fields, '\0'))) throw;
  }
}

void StateRecords::make_spares() const {
  for (const char* const name : kSpares) {
    std::error_code code;
    if (fs::file_size(folder_ / name, code) == kSpareBytes) continue;
    try {
      write_durably(folder_ / name, std::string(kSpareBytes, ' '));
    } catch (const std::system_error&) {
      return;  // without a spare, the files of a job that ends on a full disk still show its end
    }
  }
}

bool StateRecords::write_over_spare(const std::string& text) const {
  if (text.size() > kSpareBytes) return false;
  const std::string padded = text + std::string(kSpareBytes - text.size(), ' ');
  for (const char* const name : kSpares) {
    const FileDescriptor spare(::open((folder_ / name).c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
    if (!spare.valid()) continue;
    // The file keeps its blocks, and is a spare again once another one has taken its place. Readers ignore
    // the padding, a text without its end.
    if (::pwrite(spare.get(), padded.data(), padded.size(), 0) != static_cast<ssize_t>(padded.size()) ||
        ::fsync(spare.get()) != 0)
      continue;
    const fs::path from = folder_ / name, to = folder_ / kEnded;
    const bool replaced = ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0 ||
                          ::rename(from.c_str(), to.c_str()) == 0;
    sync_folder(folder_);
    return replaced;
  }
  return false;
}

std::vector<std::string> StateRecords::queue_order() const {
  return texts_of(kOrder, '\0');
}
void StateRecords::keep_queue_order(const std::vector<std::string>& files) const {
  keep_texts(kOrder, files, '\0');
}

std::vector<std::string> StateRecords::accepted() const {
  return texts_of(kAccepted, '\n');
}
void StateRecords::keep_accepted(const std::vector<std::string>& lines) const {
  keep_texts(kAccepted, lines, '\n');
}

}  // namespace contourd
