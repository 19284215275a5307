// Where an owner's file refers to: paths, and profiles by name, NAME being the file NAME.json in a folder.
// Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// What relative paths of the file start from.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& file);
// The absolute path that the text means in a file of that folder.
[[nodiscard]] std::filesystem::path resolved(const std::filesystem::path& folder, const std::string& text);

// The names of all profiles in the folder, hidden files aside, in order. Throws std::system_error.
[[nodiscard]] std::vector<std::string> profiles_in(const std::filesystem::path& folder);

// Nothing when there is no such profile. The name may come from anywhere: it can never lead out of the
// folder.
[[nodiscard]] std::optional<std::filesystem::path> profile_file(const std::filesystem::path& folder,
                                                                std::string_view name);

// The sentence for that, with the profiles there are. `kind` is what they are: "resin profile".
[[nodiscard]] std::string no_such_profile(std::string_view kind, const std::filesystem::path& folder,
                                          std::string_view name);

}  // namespace contourd
