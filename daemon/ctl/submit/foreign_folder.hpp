// A folder that nobody vouches for, such as an inserted stick's: what is in it is found and opened without
// following a link, leaving its file system or waiting. Not thread-safe; blocks as long as its disk does.
#pragma once

#include <dirent.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

struct FoundModels {
  std::vector<std::string> paths;  // relative, sorted
  bool all = true;                 // false: there is more than is looked at
  std::size_t unread = 0;          // folders below it that cannot be read
};

class ForeignFolder {
 public:
  // So many folders deep below it, and so many names in all, are looked at.
  static constexpr int kDeepest = 2;
  static constexpr std::size_t kMostNames = 20'000;

  // Throws std::system_error.
  explicit ForeignFolder(const std::filesystem::path& path);

  // Files that are models by their names; not in folders that are hidden or that a system keeps for itself.
  // Throws std::system_error.
  [[nodiscard]] FoundModels models() const;
  // A regular file in it, for reading. Throws UnreadableFile.
  [[nodiscard]] FileDescriptor open(const std::string& path) const;

 private:
  // -1 and errno where there is none, or only by way of a link.
  [[nodiscard]] FileDescriptor open(const std::string& path, int flags) const;
  // Null and errno likewise.
  [[nodiscard]] DIR* open_stream(const std::string& path) const;

  FileDescriptor folder_;
};

}  // namespace contourd::ctl
