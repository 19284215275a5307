// An untrusted folder, for example of an inserted USB stick. Its files are found and opened without following
// links, leaving its file system, or waiting for other processes. Not thread-safe; blocks as long as its disk
// does.
#pragma once

#include <dirent.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

struct FoundModels {
  std::vector<std::string> paths;   // relative, sorted
  std::vector<std::string> others;  // of formats that contourd does not read but an owner may want to print
  bool all = true;                  // false: the limit of names was reached
  std::size_t unread = 0;           // number of subfolders that cannot be read
};

class ForeignFolder {
 public:
  // Limits of the search: the depth of subfolders, and the number of all names.
  static constexpr int kDeepest = 2;
  static constexpr std::size_t kMostNames = 20'000;

  // Throws std::system_error.
  explicit ForeignFolder(const std::filesystem::path& path);

  // Finds the files whose names are models' names, and those of other formats. Hidden files of those, hidden
  // folders and folders of an operating system are skipped. Throws std::system_error.
  [[nodiscard]] FoundModels models() const;
  // Opens a regular file of the folder for reading. Throws UnreadableFile.
  [[nodiscard]] FileDescriptor open(const std::string& path) const;

 private:
  // Returns an invalid descriptor and sets errno if the path does not exist or leads over a link.
  [[nodiscard]] FileDescriptor open(const std::string& path, int flags) const;
  // Returns null and sets errno in these cases.
  [[nodiscard]] DIR* open_stream(const std::string& path) const;

  FileDescriptor folder_;
};

}  // namespace contourd::ctl
