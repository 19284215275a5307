#include "daemon/spool/copied_originals.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "daemon/config/job_ticket.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

std::int64_t nanoseconds(const timespec& time) {
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

std::string identity_of(const struct stat& status) {
  return std::to_string(status.st_ino);
}

std::set<std::string> identities_in(const fs::path& folder, std::error_code& code) {
  std::set<std::string> there;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    struct stat status {};
    if (::lstat(entry->path().c_str(), &status) == 0) there.insert(identity_of(status));
  }
  return there;
}

// Prefix of the record's line with the inode of the expected copy and the mark of its original.
constexpr std::string_view kExpected = "copying ";

std::string content_of(const struct stat& status) {
  return fmt::format(" {}:{}:{}", status.st_ino, status.st_size, nanoseconds(status.st_mtim));
}

}  // namespace

// Only files that the plate's ticket names are part of the mark: other files in the folder may come and go.
std::string mark_of(const JobFiles& job) {
  struct stat status {};
  if (::lstat(job.model.c_str(), &status) != 0) return "";
  std::string mark = identity_of(status);
  if (!job.plate) return mark + content_of(status);
  try {
    for (const fs::path& part : parts_of(job)) {
      struct stat file {};
      if (::lstat(part.c_str(), &file) == 0) mark += content_of(file);
    }
  } catch (const ConfigError&) {
    struct stat ticket {};
    const bool seen = ::lstat((job.model / kPlateTicket).c_str(), &ticket) == 0;
    mark += content_of(seen ? ticket : status);
  }
  return mark;
}

std::vector<fs::path> parts_of(const JobFiles& job) {
  std::vector<fs::path> parts;
  if (!job.plate) {
    parts.push_back(job.model);
    if (job.ticket) parts.push_back(*job.ticket);
    return parts;
  }
  parts.push_back(job.model / kPlateTicket);
  for (const ModelTicket& model : load_plate_ticket(parts.front(), job.links).models) {
    const fs::path part = job.model / model.file;
    if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
  }
  return parts;
}

CopiedOriginals::CopiedOriginals(fs::path record) : record_(std::move(record)) {
  std::ifstream file(record_);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(kExpected)) {
      marks_.insert(line);
      continue;
    }
    line.erase(0, kExpected.size());
    const std::size_t space = line.find(' ');
    if (space != std::string::npos) expected_ = {line.substr(0, space), line.substr(space + 1)};
  }
}

bool CopiedOriginals::contains(const JobFiles& job) const {
  {
    const std::lock_guard lock(mutex_);
    if (marks_.empty()) return false;
  }
  const std::string mark = mark_of(job);
  const std::lock_guard lock(mutex_);
  return marks_.contains(mark);
}

void CopiedOriginals::expect(const std::string& mark, const fs::path& copy) {
  struct stat status {};
  if (::lstat(copy.c_str(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot find " + copy.string());
  change([&](std::set<std::string>& marks) { marks.erase(mark); }, Expected{identity_of(status), mark});
}

void CopiedOriginals::add(const std::string& mark) {
  change([&](std::set<std::string>& marks) { marks.insert(mark); });
}

void CopiedOriginals::remove(const std::string& mark) {
  change([&](std::set<std::string>& marks) { marks.erase(mark); });
}

void CopiedOriginals::keep_those_in(const fs::path& incoming) {
  std::error_code code;
  const std::set<std::string> there = identities_in(incoming, code);
  if (code) return;
  change([&](std::set<std::string>& marks) {
    std::erase_if(marks,
                  [&](const std::string& mark) { return !there.contains(mark.substr(0, mark.find(' '))); });
  });
}

void CopiedOriginals::settle(const fs::path& printing) {
  if (!expected_) return;
  std::error_code ignored;
  const bool is_there = identities_in(printing, ignored).contains(expected_->copy);
  const std::string mark = expected_->mark;
  try {
    if (is_there) return add(mark);
    remove(mark);
  } catch (const std::system_error&) {
    expected_.reset();
    if (is_there) marks_.insert(mark);
  }
}

void CopiedOriginals::change(const std::function<void(std::set<std::string>&)>& change,
                             const std::optional<Expected>& expected) {
  const std::lock_guard lock(mutex_);
  std::set<std::string> marks = marks_;
  change(marks);
  if (marks == marks_ && !expected && !expected_) return;
  std::string text;
  for (const std::string& mark : marks)
    text += mark + "\n";
  if (expected) text += fmt::format("{}{} {}\n", kExpected, expected->copy, expected->mark);
  write_durably(record_, text);
  marks_ = std::move(marks);
  expected_ = expected;
}

}  // namespace contourd
