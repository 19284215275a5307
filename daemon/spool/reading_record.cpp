#include "daemon/spool/reading_record.hpp"

#include <fstream>
#include <system_error>
#include <utility>

#include "daemon/spool/copied_originals.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Returns the kernel's boot ID, which is different after each start of the computer.
std::string boot() {
  std::string id;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
  return id;
}

}  // namespace

ReadingRecord::ReadingRecord(fs::path file) : file_(std::move(file)) {
  std::ifstream record(file_);
  std::string line;
  if (!std::getline(record, line) || line != boot()) return;
  while (std::getline(record, line))
    ended_.insert(line);
}

bool ReadingRecord::take_ended(const JobFiles& job) {
  const std::lock_guard lock(mutex_);
  if (ended_.empty() || ended_.erase(mark_of(job)) == 0) return false;
  write();
  return true;
}

void ReadingRecord::begin(const JobFiles& job) {
  const std::string mark = mark_of(job);
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  under_way_ = mark;
  write();
}

void ReadingRecord::end() {
  const std::lock_guard lock(mutex_);
  under_way_.clear();
  write();
}

void ReadingRecord::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  under_way_.clear();
  write();
}

// Replaces the file by rename, since this process may end at any moment.
void ReadingRecord::write() const noexcept {
  std::error_code code;
  if (ended_.empty() && under_way_.empty()) {
    fs::remove(file_, code);
    return;
  }
  try {
    const fs::path next = file_.string() + ".next";
    std::ofstream record(next, std::ios::trunc);
    record << boot() << "\n";
    for (const std::string& mark : ended_)
      record << mark << "\n";
    if (!under_way_.empty()) record << under_way_ << "\n";
    record.close();
    if (record) fs::rename(next, file_, code);
  } catch (const std::exception&) {
    fs::remove(file_, code);  // no record is better than one that names another model
  }
}

}  // namespace contourd
