// Resolves references in a user's file: paths, and profiles by name, where NAME is the file NAME.json in a
// folder. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// Returns the folder of the file, from which its relative paths start.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& file);
// Returns the absolute form of a path in a file of that folder.
[[nodiscard]] std::filesystem::path resolved(const std::filesystem::path& folder, const std::string& text);

// Returns the sorted names of all profiles in the folder, without hidden files. Throws std::system_error.
[[nodiscard]] std::vector<std::string> profiles_in(const std::filesystem::path& folder);

// Returns the profile's file, or nullopt if there is no such profile. Safe for untrusted names: the result is
// always directly in the folder.
[[nodiscard]] std::optional<std::filesystem::path> profile_file(const std::filesystem::path& folder,
                                                                std::string_view name);

// Returns the message about a missing profile, with the names of the existing ones. `kind` is a noun such as
// "resin profile".
[[nodiscard]] std::string no_such_profile(std::string_view kind, const std::filesystem::path& folder,
                                          std::string_view name);

}  // namespace contourd
