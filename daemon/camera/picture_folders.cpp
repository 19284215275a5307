#include "daemon/camera/picture_folders.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPictureEnd = ".jpg";
constexpr std::size_t kMostListed = 10'000;

// Returns the layer of a picture's name, from 0; nullopt if it is not the name of a picture.
std::optional<std::int32_t> layer_of(const std::string& name) {
  if (!name.ends_with(kPictureEnd)) return std::nullopt;
  const char* const end = name.data() + name.size() - kPictureEnd.size();
  std::int32_t number = 0;
  const auto read = std::from_chars(name.data(), end, number);
  if (read.ec != std::errc() || read.ptr != end || number < 1) return std::nullopt;
  return number - 1;
}

bool is_folder(const fs::path& path) {
  std::error_code code;
  return fs::is_directory(fs::symlink_status(path, code));
}

bool is_there(const fs::path& path) {
  std::error_code code;
  return fs::exists(fs::symlink_status(path, code));
}

// Makes a folder that other users can read but not write. Does nothing if it exists.
void make_folder(const fs::path& path) {
  constexpr mode_t kMode = 0755;
  if (::mkdir(path.c_str(), kMode) == 0 || errno == EEXIST) return;
  throw std::system_error(errno, std::generic_category(), "cannot make " + path.string());
}

// Moves a folder of files; copies it if the other one is on another file system.
void move_folder(const fs::path& from, const fs::path& to) {
  std::error_code code;
  fs::rename(from, to, code);
  if (!code) return;
  if (code != std::errc::cross_device_link) throw fs::filesystem_error("cannot move", from, to, code);
  // Not into a folder or a link that another user has put there.
  if (!fs::create_directory(to))
    throw fs::filesystem_error("cannot copy", from, to, std::make_error_code(std::errc::file_exists));
  for (const auto& each : fs::directory_iterator(from))
    fs::copy_file(each.path(), to / each.path().filename());
  fs::remove_all(from);
}

}  // namespace

fs::path PictureFolders::current(const std::string& job) const {
  return folders_.root() / "pictures" / job;
}

fs::path PictureFolders::find(const std::string& job) const {
  expects(job.find('/') == std::string::npos, "the name of a job is no path");
  const std::array folders{current(job), folders_.path(SpoolFolder::Done) / (job + kSuffix),
                           folders_.path(SpoolFolder::Failed) / (job + kSuffix)};
  const auto* const found = std::ranges::find_if(folders, is_folder);
  return found == folders.end() ? fs::path() : *found;
}

void PictureFolders::make(const std::string& job) const {
  make_folder(current(job).parent_path());
  make_folder(current(job));
}

bool PictureFolders::is_printing(const std::string& job) const {
  std::error_code code;
  for (const auto& each : fs::directory_iterator(folders_.path(SpoolFolder::Printing), code))
    if (job_name_of(each.path().filename().string()) == job) return true;
  return static_cast<bool>(code);  // a folder that cannot be read may hold the job
}

void PictureFolders::file_away(const fs::path& pictures) const {
  const std::string job = pictures.filename().string();
  if (fs::is_empty(pictures)) {
    fs::remove(pictures);
    return;
  }
  for (const SpoolFolder folder : {SpoolFolder::Done, SpoolFolder::Failed}) {
    const fs::path beside = folders_.path(folder) / job;
    const auto has = [&](const char* suffix) { return is_there(beside.string() + suffix); };
    if (!has(".report.json") && !has(".reason.txt")) continue;
    // Members of the group may delete the files of jobs that have ended.
    fs::permissions(pictures, fs::perms::group_write, fs::perm_options::add);
    return move_folder(pictures, beside.string() + kSuffix);
  }
  fs::remove_all(pictures);
}

void PictureFolders::tidy() const {
  std::vector<fs::path> left;
  std::error_code code;  // there is no folder before the first picture
  for (const auto& each : fs::directory_iterator(folders_.root() / "pictures", code))
    left.push_back(each.path());
  for (const fs::path& pictures : left) {
    if (is_folder(pictures) && !is_printing(pictures.filename().string())) file_away(pictures);
  }
}

StoredPictures pictures_in(const fs::path& folder) {
  StoredPictures stored;
  std::error_code code;
  for (const auto& each : fs::directory_iterator(folder, code)) {
    const auto layer = layer_of(each.path().filename().string());
    if (!layer || stored.layers.size() >= kMostListed) continue;
    stored.layers.push_back(*layer);
    const std::uintmax_t bytes = each.file_size(code);
    if (!code) stored.bytes += bytes;
  }
  std::ranges::sort(stored.layers);
  return stored;
}

fs::path picture_file(const fs::path& folder, std::int32_t layer) {
  return folder / fmt::format("{:05}{}", layer + 1, kPictureEnd);
}

fs::path film_file(const fs::path& folder) {
  return folder / "time-lapse.mp4";
}

}  // namespace contourd
