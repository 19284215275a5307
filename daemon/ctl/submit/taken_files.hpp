// The record of files that were taken from USB sticks: a text file with one mark per line, the latest last.
// The oldest marks are dropped. Not thread-safe.
#pragma once

#include <deque>
#include <filesystem>
#include <string>

namespace contourd::ctl {

class TakenFiles {
 public:
  static constexpr std::size_t kMost = 5'000;

  // Reads the file; a file that cannot be read counts as empty.
  explicit TakenFiles(const std::filesystem::path& path);

  [[nodiscard]] bool contains(const std::string& mark) const;
  // Adds a mark and writes the file to disk. Throws std::system_error. REQUIRES: the mark has no line break.
  void add(const std::string& mark);

 private:
  std::filesystem::path path_;
  std::deque<std::string> marks_;
};

}  // namespace contourd::ctl
