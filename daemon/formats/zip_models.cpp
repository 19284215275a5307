#include "daemon/formats/zip_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "core/model/model.hpp"
#include "daemon/formats/input_limits.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/formats/model_versions.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostFolders = 16;    // folders around a model
constexpr std::size_t kMostNamed = 6;       // models in a message
constexpr std::size_t kLongestNamed = 200;  // bytes of a path in a list

constexpr std::array<std::string_view, 9> kArchives{".zip", ".gz",   ".rar",     ".7z",     ".tar",
                                                    ".sl1", ".sl1s", ".sl1_svg", ".nanodlp"};
// Projects of Lychee Slicer and of CHITUBOX.
constexpr std::array<std::string_view, 2> kProjects{".lys", ".chitubox"};
// Formats in the order of preference, for a model that is there in several.
constexpr std::array<std::string_view, 4> kPreferredFormats{".stl", ".3mf", ".obj", ".amf"};

// True if a file or a folder in the path is hidden, or belongs to macOS.
bool is_hidden(std::string_view path) {
  return std::ranges::any_of(path_parts(path), [](std::string_view part) {
    return (part.starts_with('.') && part != "." && part != "..") || part == "__MACOSX";
  });
}

template <std::size_t Count>
bool ends_with_one_of(std::string_view name, const std::array<std::string_view, Count>& extensions) {
  std::string lower(name);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::ranges::any_of(extensions,
                             [&](std::string_view extension) { return lower.ends_with(extension); });
}

template <std::size_t Count>
std::vector<const ZipEntry*> entries_ending_in(const ZipArchive& archive,
                                               const std::array<std::string_view, Count>& extensions) {
  std::vector<const ZipEntry*> found;
  for (const ZipEntry& entry : archive.entries())
    if (!is_hidden(entry.name) && ends_with_one_of(entry.name, extensions)) found.push_back(&entry);
  return found;
}

std::vector<const ZipEntry*> models_of(const ZipArchive& archive) {
  std::vector<const ZipEntry*> models;
  for (const ZipEntry& entry : archive.entries())
    if (!is_hidden(entry.name) && !ends_with_one_of(entry.name, kArchives) &&
        !model_extension(entry.name).empty())
      models.push_back(&entry);
  return models;
}

std::string names_of(const std::vector<const ZipEntry*>& entries) {
  std::vector<std::string_view> paths;
  for (const ZipEntry* entry : entries)
    paths.emplace_back(entry->name);
  return names_text(paths);
}

[[noreturn]] void refuse_no_model(const ZipArchive& archive) {
  if (archive.find("prusaslicer.ini") != nullptr || archive.find("config.ini") != nullptr)
    throw ModelError(
        "the file is a sliced file for SL1 printers without a PNG picture or SVG outlines for each layer: "
        "slice "
        "the model again with the archive format SL1 or SL1SVG, or print the model itself");
  if (archive.find("Document.xml") != nullptr)
    throw ModelError("the file is a FreeCAD project: export the model as STL from FreeCAD");
  if (const auto projects = entries_ending_in(archive, kProjects); !projects.empty())
    throw ModelError(fmt::format(
        "the archive holds no model, but {}, which only Lychee Slicer or CHITUBOX can read: export "
        "it as STL there",
        in_quotes(projects.front()->name)));
  if (const auto nested = entries_ending_in(archive, kArchives); !nested.empty())
    throw ModelError(
        fmt::format("the archive holds no model, but another archive, {}: unpack it, and print "
                    "the model that is in it",
                    in_quotes(nested.front()->name)));
  throw ModelError(
      "the archive holds no model: a model's name in an archive ends in .stl, .3mf, .obj or .amf");
}

// A model of the archive, and how the ticket asks for it.
struct Candidate {
  const ZipEntry* entry;
  bool is_named = false;  // by its own name, so that no other version is chosen instead
  VersionName version{};
  std::string_view extension{};
};

// The versions of a model that are there.
struct Versions {
  bool with = false, without = false;

  void add(NamedSupports supports) { (supports == NamedSupports::With ? with : without) = true; }
  [[nodiscard]] bool both() const { return with && without; }
};

// True if the path lies in a folder with this name, which may consist of several parts.
bool lies_in(std::string_view path, std::string_view folder) {
  const std::vector<std::string_view> parts = path_parts(path), asked = path_parts(folder);
  if (asked.empty() || parts.empty()) return false;
  const auto folders_end = parts.end() - 1;
  return std::search(parts.begin(), folders_end, asked.begin(), asked.end()) != folders_end;
}

class Choice {
 public:
  explicit Choice(const ZipArchive& archive) : archive_(archive), models_(models_of(archive)) {}

  ZipChoice run(const ArchiveChoice& asked) {
    if (models_.empty() && asked.names.empty()) refuse_no_model(archive_);
    for (const std::string& name : asked.names)
      find(name);
    std::vector<Candidate> candidates;
    for (const ZipEntry* model : models_)
      if (const auto how = asked_for(asked, *model)) candidates.push_back({model, *how == Asked::ByName});
    choose_formats(candidates);
    choose_versions(candidates, asked.unsupported);
    if (asked.names.empty()) note_others();
    check();
    return std::move(choice_);
  }

 private:
  enum class Asked { ByName, WithOthers };

  // Returns how the model is asked for, or nullopt if it is not.
  [[nodiscard]] std::optional<Asked> asked_for(const ArchiveChoice& asked, const ZipEntry& model) const {
    if (asked.names.empty()) return Asked::WithOthers;
    const auto found = names_.find(&model);
    return found == names_.end() ? std::nullopt : std::optional(found->second);
  }

  // Notes the models that a name of the ticket means.
  void find(const std::string& name) {
    std::vector<const ZipEntry*> named = models_where([&](std::string_view path) { return path == name; });
    if (named.empty())
      named = models_where([&](std::string_view path) { return path_parts(path).back() == name; });
    if (named.size() > 1)
      throw ModelError(
          fmt::format("the archive holds {} models {}: name one of them with its folder, and pack the "
                      "archive again if two have the same folder: {}",
                      named.size(), in_quotes(name), names_of(named)));
    if (!named.empty()) {
      names_.insert_or_assign(named.front(), Asked::ByName);
      return;
    }
    named = models_where([&](std::string_view path) { return lies_in(path, name); });
    for (const ZipEntry* model : named)
      names_.emplace(model, Asked::WithOthers);
    if (!named.empty()) return;
    throw ModelError(models_.empty()
                         ? fmt::format("the archive holds no model, and the ticket names {}", in_quotes(name))
                         : fmt::format("the archive holds no model and no folder {}: it holds {}",
                                       in_quotes(name), names_of(models_)));
  }

  template <typename IsMeant>
  [[nodiscard]] std::vector<const ZipEntry*> models_where(IsMeant is_meant) const {
    std::vector<const ZipEntry*> found;
    std::ranges::copy_if(models_, std::back_inserter(found),
                         [&](const ZipEntry* model) { return is_meant(std::string_view(model->name)); });
    return found;
  }

  // Leaves out the models that are there in a better format, with the same words in their names.
  void choose_formats(std::vector<Candidate>& candidates) {
    for (Candidate& each : candidates) {
      each.extension = model_extension(each.entry->name);
      each.version = version_name(each.entry->name, each.extension);
    }
    using Key = std::pair<std::string, NamedSupports>;
    const auto rank = [](const Candidate& each) {
      return std::ranges::find(kPreferredFormats, each.extension) - kPreferredFormats.begin();
    };
    std::map<Key, const Candidate*> best;
    for (const Candidate& each : candidates) {
      const auto [place, is_new] = best.try_emplace(Key(each.version.model, each.version.supports), &each);
      if (!is_new && rank(each) < rank(*place->second)) place->second = &each;
    }
    std::vector<const ZipEntry*> left_out;
    std::string instead;
    const auto is_worse = [&](const Candidate& each) {
      const Candidate& chosen = *best.at(Key(each.version.model, each.version.supports));
      if (each.is_named || rank(each) == rank(chosen)) return false;
      if (left_out.empty()) instead = in_quotes(chosen.entry->name);
      left_out.push_back(each.entry);
      return true;
    };
    std::vector<Candidate> kept;
    std::ranges::copy_if(candidates, std::back_inserter(kept),
                         [&](const Candidate& each) { return !is_worse(each); });
    candidates = std::move(kept);
    if (left_out.empty()) return;
    choice_.notes.push_back(fmt::format("{}: left out, because {} is the same model in another format{}",
                                        names_of(left_out), instead,
                                        left_out.size() > 1 ? ", and likewise the others" : ""));
  }

  // Keeps one version of each model that is there with supports and without.
  void choose_versions(std::vector<Candidate>& candidates, bool unsupported) {
    std::map<std::string, Versions> in_archive, asked_for;
    for (const ZipEntry* model : models_) {
      const VersionName name = version_name(model->name, model_extension(model->name));
      in_archive[name.model].add(name.supports);
    }
    for (const Candidate& each : candidates)
      asked_for[each.version.model].add(each.version.supports);
    std::vector<const ZipEntry*> taken, left;
    for (const Candidate& each : candidates) {
      const bool has_supports = each.version.supports == NamedSupports::With;
      const bool is_choice = asked_for.at(each.version.model).both() && !each.is_named;
      if (is_choice) (has_supports == unsupported ? left : taken).push_back(each.entry);
      if (!is_choice || has_supports != unsupported)
        choice_.models.push_back({each.entry, has_supports && in_archive.at(each.version.model).both()});
    }
    if (left.empty()) return;
    const bool one = taken.size() == 1;
    choice_.notes.push_back(fmt::format(
        "the archive holds versions with supports and without: {} {} printed{} instead of {}, because {}; "
        "\"model\": \"{}\" in the ticket chooses otherwise (contourctl submit --model)",
        names_of(taken), one ? "is" : "are", unsupported ? "" : (one ? ", as it is," : ", as they are,"),
        names_of(left),
        unsupported ? "the ticket asks for contourd's own supports"
                    : "supports that come with a model fit it best",
        left.size() == 1 ? printable(left.front()->name) : "a model or a folder"));
  }

  // Notes what else the archive holds that a user may expect to be printed.
  void note_others() {
    const bool has_supported = std::ranges::any_of(choice_.models, &ChosenModel::is_supported);
    if (const auto projects = entries_ending_in(archive_, kProjects); !projects.empty() && !has_supported)
      choice_.notes.push_back(fmt::format(
          "{}: left out, because only Lychee Slicer or CHITUBOX can read it; to print the supports "
          "that are in it, export it as STL there",
          names_of(projects)));
    if (const auto nested = entries_ending_in(archive_, kArchives); !nested.empty())
      choice_.notes.push_back(
          fmt::format("{}: left out, because archives in an archive are not opened", names_of(nested)));
  }

  [[nodiscard]] std::vector<const ZipEntry*> chosen() const {
    std::vector<const ZipEntry*> entries;
    std::ranges::transform(choice_.models, std::back_inserter(entries), &ChosenModel::entry);
    return entries;
  }

  void check() const {
    if (choice_.models.size() > kMostArchiveModels)
      throw ModelError(
          fmt::format("the archive holds {} models, and a plate has at most {}: name some of them, or a "
                      "folder, as \"model\" in the ticket (contourctl submit --model): {}",
                      choice_.models.size(), kMostArchiveModels, names_of(chosen())));
    std::set<std::string_view> names;
    InflatedSize all{0, 0};
    for (const ChosenModel& model : choice_.models) {
      const ZipEntry& entry = *model.entry;
      if (!names.insert(entry.name).second)
        throw ModelError(fmt::format("the archive holds {} twice: pack it again", in_quotes(entry.name)));
      if (path_parts(entry.name).size() > kMostFolders + 1)
        throw ModelError(fmt::format("{} lies in more than {} folders in the archive: unpack it",
                                     in_quotes(entry.name), kMostFolders));
      refuse_inflation({entry.compressed, entry.inflated}, in_quotes(entry.name) + " in the archive");
      // Entries may share their data, but not have more of it than the archive.
      all = {std::min(all.compressed + entry.compressed, archive_.bytes()), all.inflated + entry.inflated};
    }
    refuse_inflation(all, fmt::format("the archive, with {} models,", choice_.models.size()));
  }

  const ZipArchive& archive_;
  std::vector<const ZipEntry*> models_;
  std::map<const ZipEntry*, Asked> names_;  // models that the ticket names
  ZipChoice choice_;
};

}  // namespace

std::string names_text(const std::vector<std::string_view>& paths) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostNamed, paths.size()); ++i)
    text += (text.empty() ? "" : ", ") + in_quotes(shortened(paths[i], kLongestNamed));
  if (paths.size() > kMostNamed) text += fmt::format(" and {} more", paths.size() - kMostNamed);
  return text;
}

ZipChoice choose_models(const ZipArchive& archive, const ArchiveChoice& asked) {
  return Choice(archive).run(asked);
}

}  // namespace contourd
