#include "daemon/json/profile_file.hpp"

#include <algorithm>
#include <system_error>

#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

std::string profile_names(const fs::path& folder) {
  std::string text;
  try {
    for (const std::string& name : profiles_in(folder))
      text += (text.empty() ? "there are " : ", ") + in_quotes(name);
  } catch (const std::system_error& error) {
    return "its folder cannot be read: " + error.code().message();
  }
  return text.empty() ? "there are none" : text;
}

}  // namespace

fs::path folder_of(const fs::path& file) {
  return fs::absolute(file).parent_path();
}

fs::path resolved(const fs::path& folder, const std::string& text) {
  fs::path path = (folder / text).lexically_normal();
  return path.has_filename() ? path : path.parent_path();  // "spool/" is "spool"
}

std::vector<std::string> profiles_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    const bool is_hidden = file.filename().string().starts_with('.');
    if (file.extension() == ".json" && !is_hidden) names.push_back(file.stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
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
