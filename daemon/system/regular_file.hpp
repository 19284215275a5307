// Opens untrusted files for reading. Only regular files are opened, and opening never blocks, even if the
// file is replaced at the same moment (by a FIFO, for example). Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include "hw/file_descriptor.hpp"

namespace contourd {

// The treatment of symbolic links, for the file and its folder. Refuse them where other users can write.
enum class Links { Follow, Refuse };

// The error for a path that is not a readable regular file. what() is a clause: "it is a folder, not a file".
class UnreadableFile : public std::system_error {
 public:
  UnreadableFile(std::error_code code, const std::string& clause);
  [[nodiscard]] const char* what() const noexcept override { return clause_.what(); }

 private:
  std::runtime_error clause_;  // copying it cannot throw
};

// Opens a regular file for reading. Throws UnreadableFile.
[[nodiscard]] FileDescriptor open_regular_file(const std::filesystem::path& path, Links links);

}  // namespace contourd
