// Changes one number of a configuration file and leaves the rest as the user wrote it. Thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// Returns the text of a JSON object with the number `key` of its object `section` set, adding the key if it
// is missing. Throws std::runtime_error with a readable message if the text is formatted so that it cannot be
// edited in place.
[[nodiscard]] std::string with_number(const std::string& text, std::string_view section, std::string_view key,
                                      double number);

// Sets a number in a printer's configuration file. The new file has the owner and permissions of the old one
// and replaces it only if it is valid. Blocks until the data is on the disk. Throws ConfigError if the old or
// the new file is invalid, std::runtime_error as with_number() does, and std::system_error.
void set_config_number(const std::filesystem::path& file, std::string_view section, std::string_view key,
                       double number);

// Returns the content of a file. Throws std::system_error.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);

// Replaces an existing file with the text, which the caller has checked. Links are followed. The new file has
// the owner and permissions of the old one and is never partly written. Blocks until the data is on the disk.
// Throws std::system_error; then the file is unchanged.
void replace_file(const std::filesystem::path& file, std::string_view text);

// Writes a new file beside an existing one, with that one's owner and permissions. The new file is never
// partly written. Blocks until the data is on the disk. Throws std::system_error; then there is no new file.
void write_beside(const std::filesystem::path& existing, const std::filesystem::path& file,
                  std::string_view content);

// The treatment of the previous file.
enum class FileBefore {
  Kept,  // beside the new one as FILE.before-setup; if that exists, as FILE.before-setup-2, and so on
  Gone,
};

// Replaces the file with the text if it is a valid printer's configuration. Returns the path of the previous
// file if it was kept. The new file has the previous one's owner and permissions; without a previous file,
// everyone can read it. The file is never partly written, not even after a power cut. Blocks until the data
// is on the disk. Throws ConfigError and std::system_error; then the file is unchanged.
std::optional<std::filesystem::path> replace_config(const std::filesystem::path& file,
                                                    const std::string& text, FileBefore before);

}  // namespace contourd
