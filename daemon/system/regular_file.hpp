// Opens files for reading, with distrust: whatever lies under a name, or is put in its place in that moment,
// nobody is waited for, and only a regular file is read. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include "hw/file_descriptor.hpp"

namespace contourd {

// Whether the file, and the folder that it is in, may be symbolic links: not where others than the owner
// write.
enum class Links { Follow, Refuse };

// What lies under that name is no file to be read. what() is a clause about it: "it is a folder, not a file".
class UnreadableFile : public std::system_error {
 public:
  UnreadableFile(std::error_code code, const std::string& clause);
  [[nodiscard]] const char* what() const noexcept override { return clause_.what(); }

 private:
  std::runtime_error clause_;  // its copies cannot fail
};

// Throws UnreadableFile.
[[nodiscard]] FileDescriptor open_regular_file(const std::filesystem::path& path, Links links);

}  // namespace contourd
