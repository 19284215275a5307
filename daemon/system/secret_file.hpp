// Small files of lines "KEY VALUE" that only their owner, and who the service manager passes them to, may
// read. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace contourd {

inline constexpr std::size_t kMostSecretBytes = 4096;

// Returns the text of the file, at most kMostSecretBytes of it. Throws UnreadableFile; throws
// std::runtime_error with a sentence if other users can read the file.
[[nodiscard]] std::string read_secret_file(const std::filesystem::path& file);
// Returns the value of the first line with this key; empty if there is none.
[[nodiscard]] std::string secret_value(std::string_view text, std::string_view key);
// Writes the text into a file that only its owner can read, and replaces an earlier one. Blocks until the
// file is on the disk. Throws std::system_error. Changes the umask of the process meanwhile.
void write_secret_file(const std::filesystem::path& file, std::string_view text);

}  // namespace contourd
