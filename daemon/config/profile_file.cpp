#include "daemon/config/profile_file.hpp"

#include <algorithm>
#include <system_error>
#include <vector>

#include "daemon/config/config_error.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

std::string profile_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    const bool is_hidden = file.filename().string().starts_with('.');
    if (file.extension() == ".json" && !is_hidden) names.push_back(file.stem().string());
  }
  if (error) return "its folder cannot be read: " + error.message();
  if (names.empty()) return "there are none";
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "there are " : ", ") + in_quotes(name);
  return text;
}

}  // namespace

fs::path folder_of(const fs::path& file) {
  return fs::absolute(file).parent_path();
}

fs::path resolved(const fs::path& folder, const std::string& text) {
  fs::path path = (folder / text).lexically_normal();
  return path.has_filename() ? path : path.parent_path();  // "spool/" is "spool"
}

std::optional<fs::path> profile_file(const fs::path& folder, std::string_view name) {
  constexpr std::string_view forbidden("/\0", 2);
  if (name.empty() || name.front() == '.' || name.find_first_of(forbidden) != std::string_view::npos) {
    return std::nullopt;
  }
  fs::path file = folder / (std::string(name) + ".json");
  std::error_code error;
  return fs::exists(file, error) || error ? std::optional(std::move(file)) : std::nullopt;
}

std::string no_such_profile(std::string_view kind, const fs::path& folder, std::string_view name) {
  return "there is no " + std::string(kind) + " " + in_quotes(name) + " in " + in_quotes(folder.string()) +
         "; " + profile_names(folder);
}

}  // namespace contourd
