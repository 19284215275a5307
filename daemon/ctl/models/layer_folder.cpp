#include "daemon/ctl/models/layer_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/ctl/terminal/exit_codes.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

// True if layer_file() returns this name for some layer.
bool is_layer_file(const fs::path& path, std::string_view extension) {
  const std::string stem = path.stem().string();
  return path.extension() == extension && stem.size() >= 4 &&
         std::ranges::all_of(stem, [](char c) { return c >= '0' && c <= '9'; }) &&
         (stem.size() == 4 || stem.front() != '0');
}

std::vector<fs::path> layer_files_in(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    // A folder with such a name is not a layer's file.
    if (is_layer_file(entry.path(), extension) && entry.symlink_status().type() != fs::file_type::directory)
      files.push_back(entry.path());
  }
  // Sorted by number: shorter names first.
  std::ranges::sort(files, {},
                    [](const fs::path& path) { return std::pair(path.native().size(), path.native()); });
  return files;
}

}  // namespace

std::string layer_file(std::size_t layer, std::string_view extension) {
  return fmt::format("{:04}{}", layer, extension);
}

void open_layer_folder(const fs::path& folder, std::string_view extension, Earlier earlier) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) throw OutputError(fmt::format("cannot make the folder {}: {}", folder.string(), code.message()));
  try {
    const std::vector<fs::path> files = layer_files_in(folder, extension);
    if (files.empty()) return;
    if (earlier == Earlier::Refuse) {
      throw OutputError(fmt::format("{} contains {} of an earlier slice, {} to {}; --force replaces them",
                                    folder.string(),
                                    files.size() == 1 ? "a file" : fmt::format("{} files", files.size()),
                                    files.front().filename().string(), files.back().filename().string()));
    }
    for (const fs::path& file : files)
      fs::remove(file);
  } catch (const fs::filesystem_error& error) {
    throw OutputError(fmt::format("cannot replace the files of an earlier slice in {}: {}", folder.string(),
                                  error.code().message()));
  }
}

}  // namespace contourd::ctl
