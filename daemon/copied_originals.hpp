// Which jobs in incoming/ have had their turn and lie there still, as the daemon may not move them: what it
// printed is a copy. Kept on the disk, so that none is taken twice. Thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "daemon/print_job.hpp"

namespace contourd {

class CopiedOriginals {
 public:
  // Reads what `record` holds, if there is one.
  explicit CopiedOriginals(std::filesystem::path record);

  [[nodiscard]] bool contains(const JobFiles& job) const;
  // Throw std::system_error.
  void add(const std::string& mark);
  void remove(const std::string& mark);
  // Forgets what is not in the folder any more. Throws std::system_error.
  void keep_those_in(const std::filesystem::path& incoming);

 private:
  void change(const std::function<void(std::set<std::string>&)>& change);

  std::filesystem::path record_;
  mutable std::mutex mutex_;
  std::set<std::string> marks_;
};

// What tells a job in incoming/ from every other: device, inode, sizes and times. Renamed, or with other
// rights, it is the same.
[[nodiscard]] std::string mark_of(const JobFiles& job);

// The files that a job consists of: a model and its ticket, or a plate's ticket and the models that it names.
// Throws ConfigError when the plate's ticket cannot be used.
[[nodiscard]] std::vector<std::filesystem::path> parts_of(const JobFiles& job);

}  // namespace contourd
