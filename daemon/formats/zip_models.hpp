// The models in a ZIP archive, and the choice of those that are printed. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/formats/zip_archive.hpp"

namespace contourd {

// The models of an archive that are asked for.
struct ArchiveChoice {
  // Models, by their paths or by their names without folders, and folders; empty: all models.
  std::vector<std::string> names{};
  // True: versions without supports are chosen, of models that the archive holds with and without.
  bool unsupported = false;
};

// The number of models that an archive may give: as many as a plate may name.
inline constexpr std::size_t kMostArchiveModels = 100;

struct ChosenModel {
  const ZipEntry* entry;
  bool is_supported = false;  // chosen because it carries supports, from versions with and without
};

struct ZipChoice {
  std::vector<ChosenModel> models;  // at least one, in the archive's order
  std::vector<std::string> notes;   // the choices made, a sentence each
};

// Chooses the models. Files of macOS (__MACOSX) and hidden files and folders do not count. Of the versions of
// a model (see model_versions.hpp) one is chosen, unless it is asked for by its own name. Throws ModelError
// if there is no model, a name is not found or not unique, or the models exceed a limit.
[[nodiscard]] ZipChoice choose_models(const ZipArchive& archive, const ArchiveChoice& asked);

// Returns the paths of models for a message: the first ones and the number of the others.
[[nodiscard]] std::string names_text(const std::vector<std::string_view>& paths);

}  // namespace contourd
