// The record of the jobs in incoming/ that were printed from a copy, because the daemon may not move them.
// Spool uses the record, which is on the disk, so that no job is printed twice. Also mark_of(), by which the
// spool and the job reader recognise a job whose files have not changed. Thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/spool/job_files.hpp"

namespace contourd {

class CopiedOriginals {
 public:
  // Reads the file `record` if it exists.
  explicit CopiedOriginals(std::filesystem::path record);

  [[nodiscard]] bool contains(const JobFiles& job) const;
  // Announces that the copy of the original with this mark, the folder or file `copy`, is about to be moved
  // into or out of printing/ in one step. If the process ends before add() or remove(), settle() decides.
  // Throws std::system_error.
  void expect(const std::string& mark, const std::filesystem::path& copy);
  // Throws std::system_error.
  void add(const std::string& mark);
  // Throws std::system_error.
  void remove(const std::string& mark);
  // Removes the originals that are no longer in the folder. Throws std::system_error.
  void keep_those_in(const std::filesystem::path& incoming);
  // Completes an expect() that the previous process left open: adds the original if its copy is in printing/,
  // else removes it. If the disk does not accept the record, only this process remembers it.
  void settle(const std::filesystem::path& printing);

 private:
  // A copy that is being moved, and the mark of its original.
  struct Expected {
    std::string copy, mark;  // the copy's inode
  };

  void change(const std::function<void(std::set<std::string>&)>& change,
              const std::optional<Expected>& expected = std::nullopt);

  std::filesystem::path record_;
  mutable std::mutex mutex_;
  std::set<std::string> marks_;
  std::optional<Expected> expected_;
};

// Returns a mark that identifies a job in incoming/ by inodes, sizes and times. The mark stays the same when
// the job is renamed, its permissions change, or the computer restarts (the device number is not part of it).
[[nodiscard]] std::string mark_of(const JobFiles& job);

// Returns the files of a job: a model and its ticket, or a plate's ticket and the models that it names.
// Throws ConfigError if the plate's ticket cannot be used.
[[nodiscard]] std::vector<std::filesystem::path> parts_of(const JobFiles& job);

}  // namespace contourd
