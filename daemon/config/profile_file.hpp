// Profiles by name: NAME is the file NAME.json in a folder. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// Nothing when there is no such profile. The name may come from anywhere: it can never lead out of the
// folder.
[[nodiscard]] std::optional<std::filesystem::path> profile_file(const std::filesystem::path& folder,
                                                                std::string_view name);

// The sentence for that, with the profiles there are. `kind` is what they are: "resin profile".
[[nodiscard]] std::string no_such_profile(std::string_view kind, const std::filesystem::path& folder,
                                          std::string_view name);

}  // namespace contourd
