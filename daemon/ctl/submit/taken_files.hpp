// What was taken from sticks before, by marks: a text file of a mark a line, the latest last, which forgets
// the oldest. Not thread-safe.
#pragma once

#include <deque>
#include <filesystem>
#include <string>

namespace contourd::ctl {

class TakenFiles {
 public:
  static constexpr std::size_t kMost = 5'000;

  // Reads what is there; what cannot be read was not taken.
  explicit TakenFiles(const std::filesystem::path& path);

  [[nodiscard]] bool contains(const std::string& mark) const;
  // On the disk when it returns. Throws std::system_error. REQUIRES: no line break in it.
  void add(const std::string& mark);

 private:
  std::filesystem::path path_;
  std::deque<std::string> marks_;
};

}  // namespace contourd::ctl
