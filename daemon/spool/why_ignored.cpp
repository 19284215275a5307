#include "daemon/spool/why_ignored.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <string>

namespace contourd {
namespace {

constexpr std::array<std::string_view, 14> kUnfinished{
    ".part",   ".partial", ".tmp",        ".temp",  ".crdownload", ".download", ".filepart",
    ".upload", ".swp",     ".opdownload", ".aria2", ".!ut",        ".bak",      ".new"};
constexpr std::array<std::string_view, 11> kModels{".ply", ".step", ".stp", ".iges", ".igs", ".blend",
                                                   ".glb", ".gltf", ".fbx", ".f3d",  ".scad"};
constexpr std::array<std::string_view, 18> kSliced{
    ".gcode", ".gco",  ".g",    ".ctb", ".cbddlp", ".photon", ".photons", ".pws", ".pw0",
    ".pwmx",  ".pwmo", ".pwmb", ".phz", ".lgs",    ".zcodex", ".cws",     ".goo", ".prz"};
constexpr std::array<std::string_view, 6> kArchives{".gz", ".7z", ".rar", ".tar", ".xz", ".bz2"};

bool is_one_of(std::string_view word, const auto& words) {
  return std::ranges::find(words, word) != words.end();
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

}  // namespace

std::optional<WhyIgnored> why_format_is_ignored(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  if (is_one_of(extension, kModels)) return WhyIgnored::Model;
  if (is_one_of(extension, kSliced)) return WhyIgnored::Sliced;
  if (is_one_of(extension, kArchives)) return WhyIgnored::Archive;
  return std::nullopt;
}

std::optional<WhyIgnored> why_ignored(const std::filesystem::path& path) {
  const std::string name = path.filename().string(), extension = lower_extension(path);
  if (name.empty() || name.starts_with('.') || name.ends_with('~')) return std::nullopt;
  if (is_one_of(extension, kUnfinished)) return std::nullopt;
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode)) return WhyIgnored::NotAFile;
  if (extension == ".json") return std::nullopt;
  return why_format_is_ignored(path).value_or(WhyIgnored::Other);
}

std::string_view sentence_for(WhyIgnored why) {
  switch (why) {
    case WhyIgnored::Folder:
      return "it is a folder without plate.json: add plate.json, or put its models directly into incoming";
    case WhyIgnored::Model:
      return "its format is not supported: export the model as STL or 3MF";
    case WhyIgnored::Sliced:
      return "it is sliced for another printer: put the model itself here";
    case WhyIgnored::Archive:
      return "this kind of archive is not unpacked: extract the models and put them here, or pack them as "
             "ZIP";
    case WhyIgnored::NotAFile:
      return "it is a link, a pipe or a device: put the file itself here";
    case WhyIgnored::Other:
      break;
  }
  return "its name is not one of a model: put a model such as NAME.stl or NAME.3mf, its ticket NAME.json, or "
         "a plate's "
         "folder here";
}

}  // namespace contourd
