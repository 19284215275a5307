// A model's file, opened for reading: the one place that decides by a file's content how it is read. Every
// model that contourd prints, and every one that contourctl reads, comes through here.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/formats/file_bytes.hpp"
#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/sliced_archive.hpp"
#include "daemon/formats/zip_models.hpp"

namespace contourd {

// The file to read. A value with an open file.
struct ModelSource {
  OpenFile file;               // at its beginning
  std::uint64_t bytes = 0;     // size when it was opened: nothing after it is read
  std::filesystem::path path;  // the name in messages
  ArchiveChoice choice{};      // models of a ZIP archive
};

// Used by one thread.
class ModelInput {
 public:
  ModelInput() = default;
  ModelInput(const ModelInput&) = delete;
  ModelInput& operator=(const ModelInput&) = delete;
  virtual ~ModelInput() = default;

  [[nodiscard]] virtual const ModelOutline& outline() const = 0;
  // Returns the archive if the file holds finished layers instead of a model; null for a model.
  [[nodiscard]] virtual const SlicedArchive* sliced() const { return nullptr; }
  // Reads the model. Call it once. Blocks for a time in proportion to the file, and to what it becomes when
  // it is unpacked, which input_limits.hpp bounds. Throws ModelError for bad data, for finished layers
  // and for a model that consists of more than `most_facets` copies of facets, std::system_error if the file
  // cannot be read.
  [[nodiscard]] virtual Model read(std::uint64_t most_facets) = 0;
};

// A model that a file holds.
struct OpenedModel {
  std::string entry;          // its path in a ZIP archive; empty: the file itself
  bool is_supported = false;  // see ChosenModel
  std::unique_ptr<ModelInput> input;
};

struct OpenedModels {
  std::vector<OpenedModel> models;  // at least one
  std::vector<std::string> notes;   // the choices made in an archive, a sentence each
};

// Opens the models of a file by its content, whatever its name is. Reads little of the file: its beginning,
// the list of an archive and the beginnings of the models in it; but all of a 3MF file in an archive, which
// is kept in memory. Throws ModelError if that shows what is wrong, std::system_error if the file cannot be
// read.
[[nodiscard]] OpenedModels open_models(ModelSource source);
// Does the same for a regular file.
[[nodiscard]] OpenedModels open_models(const std::filesystem::path& path, const ArchiveChoice& choice = {});

// Opens a file that holds one model, or the models that `names` choose of an archive, if that is one. The
// notes of OpenedModels become warnings of the model. Throws what open_models() throws, and ModelError if
// there are several.
[[nodiscard]] std::unique_ptr<ModelInput> open_model(const std::filesystem::path& path,
                                                     const std::vector<std::string>& names = {});

}  // namespace contourd
