// The four folders of a spool that no process has locked. Not thread-safe.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "daemon/spool/spool_folders.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::testing {

class SpoolFixture {
 public:
  SpoolFixture() {
    for (const SpoolFolder each :
         {SpoolFolder::Incoming, SpoolFolder::Printing, SpoolFolder::Done, SpoolFolder::Failed})
      std::filesystem::create_directories(folders.path(each));
  }
  // Writes a file by its path in the spool, such as "incoming/part.stl".
  void put(const std::string& path, std::string_view text = "a model") const {
    (void)folder.write(path, text);
  }
  [[nodiscard]] bool has(const std::string& path) const {
    return std::filesystem::exists(std::filesystem::symlink_status(folder.path() / path));
  }
  [[nodiscard]] std::string text_of(const std::string& path) const {
    std::ifstream file(folder.path() / path);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TemporaryFolder folder;
  SpoolFolders folders{folder.path()};
};

}  // namespace contourd::testing
