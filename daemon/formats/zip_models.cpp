#include "daemon/formats/zip_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/model/model.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostFolders = 16;  // folders around a model
constexpr std::size_t kMostNamed = 6;     // models in a message

std::string_view name_without_folders(std::string_view path) {
  return path.substr(path.rfind('/') + 1);
}

// True if a file or a folder in the path is hidden, or belongs to macOS.
bool is_hidden(std::string_view path) {
  while (!path.empty()) {
    const std::string_view part = path.substr(0, path.find('/'));
    if ((part.starts_with('.') && part != ".") || part == "__MACOSX") return true;
    path.remove_prefix(std::min(part.size() + 1, path.size()));
  }
  return false;
}

// True for names of archives, and of 3MF packages, which are archives, too.
bool is_archive_name(std::string_view name) {
  return name.ends_with(".3mf") || name.ends_with(".zip") || name.ends_with(".gz") ||
         name.ends_with(".rar") || name.ends_with(".7z");
}

bool is_model(const ZipEntry& entry) {
  return !is_hidden(entry.name) && !is_archive_name(model_extension(entry.name)) &&
         !model_extension(entry.name).empty();
}

std::string names_of(const std::vector<const ZipEntry*>& models) {
  std::string text;
  for (const ZipEntry* model : models) {
    if (model == models[std::min(kMostNamed, models.size() - 1)] && models.size() > kMostNamed)
      return text + fmt::format(" and {} more", models.size() - kMostNamed);
    text += (text.empty() ? "" : ", ") + in_quotes(model->name);
  }
  return text;
}

[[noreturn]] void refuse_no_model(const ZipArchive& archive) {
  if (archive.find("prusaslicer.ini") != nullptr || archive.find("config.ini") != nullptr)
    throw ModelError(
        "the file is a sliced file for SL1 printers: contourd prints unsliced models: use the "
        "model that this file was made from");
  if (archive.find("Document.xml") != nullptr)
    throw ModelError("the file is a FreeCAD project: export the model as STL from FreeCAD");
  const auto nested = std::ranges::find_if(archive.entries(), [](const ZipEntry& entry) {
    return !is_hidden(entry.name) && is_archive_name(entry.name);
  });
  if (nested != archive.entries().end())
    throw ModelError(
        fmt::format("the archive holds no model, but another archive, {}: unpack it, and print "
                    "the model that is in it",
                    in_quotes(nested->name)));
  throw ModelError(
      fmt::format("the archive holds no model: a model's name ends in {}", model_extensions_text()));
}

const ZipEntry& named_model(const ZipArchive& archive, std::string_view name) {
  const std::vector<const ZipEntry*> models = models_of(archive);
  std::vector<const ZipEntry*> named;
  std::ranges::copy_if(models, std::back_inserter(named),
                       [&](const ZipEntry* model) { return model->name == name; });
  if (named.empty())
    std::ranges::copy_if(models, std::back_inserter(named),
                         [&](const ZipEntry* model) { return name_without_folders(model->name) == name; });
  if (named.size() == 1) return *named.front();
  if (named.empty())
    throw ModelError(
        models.empty()
            ? fmt::format("the archive holds no model, and the ticket names {}", in_quotes(name))
            : fmt::format("the archive holds no model {}: it holds {}", in_quotes(name), names_of(models)));
  throw ModelError(
      fmt::format("the archive holds {} models {}: name one of them with its folder, and pack the "
                  "archive again if two have the same folder: {}",
                  named.size(), in_quotes(name), names_of(named)));
}

}  // namespace

std::vector<const ZipEntry*> models_of(const ZipArchive& archive) {
  std::vector<const ZipEntry*> models;
  for (const ZipEntry& entry : archive.entries())
    if (is_model(entry)) models.push_back(&entry);
  return models;
}

const ZipEntry& model_in(const ZipArchive& archive, std::string_view name) {
  const std::vector<const ZipEntry*> models = models_of(archive);
  if (models.empty()) refuse_no_model(archive);
  if (name.empty() && models.size() > 1)
    throw ModelError(
        fmt::format("the archive holds {} models: name one of them as \"model\" in the ticket, or "
                    "unpack the archive: {}",
                    models.size(), names_of(models)));
  const ZipEntry& model = name.empty() ? *models.front() : named_model(archive, name);
  if (static_cast<std::size_t>(std::ranges::count(model.name, '/')) > kMostFolders)
    throw ModelError(fmt::format("{} lies in more than {} folders in the archive: unpack it",
                                 in_quotes(model.name), kMostFolders));
  return model;
}

}  // namespace contourd
