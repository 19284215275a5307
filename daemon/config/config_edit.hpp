// One figure of a configuration changed, and all else left as its owner has written it. Thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// The text of a JSON object with the number `key` of its object `section` set, put there if it is missing.
// Throws std::runtime_error, fit for a person, where the text is written so that this cannot be done in
// place.
[[nodiscard]] std::string with_number(const std::string& text, std::string_view section, std::string_view key,
                                      double number);

// The same for a printer's configuration, with owner and rights of the file before; the new one takes its
// place only when it is good. Blocks until the disk has it. Throws ConfigError for what is wrong with either,
// std::runtime_error as above and std::system_error.
void set_config_number(const std::filesystem::path& file, std::string_view section, std::string_view key,
                       double number);

// What becomes of the file that was there.
enum class FileBefore {
  Kept,  // beside the new one, as FILE.before-setup, or FILE.before-setup-2 where there is one already, and
         // so on
  Gone,
};

// The text becomes the file, if it is good as a printer's configuration. Returns the name by which the one
// before is kept, if there was one. A file that is there keeps its owner and rights; a new one can be read by
// all. Nobody sees half of it, after a power cut neither. Blocks until the disk has it. Throws ConfigError
// and std::system_error; then the file is as it was.
std::optional<std::filesystem::path> replace_config(const std::filesystem::path& file,
                                                    const std::string& text, FileBefore before);

}  // namespace contourd
