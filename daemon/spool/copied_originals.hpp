// Jobs in incoming/ that were printed from a copy, because the daemon may not move them. Kept on the disk, so
// that none is printed twice. Thread-safe.
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
  // Reads what `record` holds, if there is one.
  explicit CopiedOriginals(std::filesystem::path record);

  [[nodiscard]] bool contains(const JobFiles& job) const;
  // Throw std::system_error.
  //
  // The original with this mark has a copy, the folder or file `copy`, which appears in printing/ or
  // disappears from there in one step. If the process ends before add() or remove(), settle() decides.
  void expect(const std::string& mark, const std::filesystem::path& copy);
  void add(const std::string& mark);
  void remove(const std::string& mark);
  // Forgets what is not in the folder any more. Throws std::system_error.
  void keep_those_in(const std::filesystem::path& incoming);
  // An original whose copy lies in printing/ has had its turn, another has not. What the disk does not take
  // is known to this process.
  void settle(const std::filesystem::path& printing);

 private:
  // A copy on its way, by its inode.
  struct Expected {
    std::string copy, mark;
  };

  void change(const std::function<void(std::set<std::string>&)>& change,
              const std::optional<Expected>& expected = std::nullopt);

  std::filesystem::path record_;
  mutable std::mutex mutex_;
  std::set<std::string> marks_;
  std::optional<Expected> expected_;
};

// What tells a job in incoming/ from every other: inodes, sizes and times. Renamed, or with other rights, it
// is the same. So it is after a restart of the computer, which may give its disk another number.
[[nodiscard]] std::string mark_of(const JobFiles& job);

// The files that a job consists of: a model and its ticket, or a plate's ticket and the models that it names.
// Throws ConfigError when the plate's ticket cannot be used.
[[nodiscard]] std::vector<std::filesystem::path> parts_of(const JobFiles& job);

}  // namespace contourd
