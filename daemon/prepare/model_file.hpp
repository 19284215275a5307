// A model named by a job, a file or a part of an archive: opened and outlined first, read later. The opened
// file stays the one that is read, even if another file replaces it meanwhile. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/contour/outline_stack.hpp"
#include "core/mask/picture_stack.hpp"
#include "daemon/formats/model_input.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

// The place of models: a file, or models in a ZIP archive.
struct ModelPlace {
  std::filesystem::path path;
  ArchiveChoice choice{};
  Links links = Links::Follow;
};

// The layers that a file holds instead of a model: one of both, or none for a model.
struct FinishedLayers {
  std::shared_ptr<const PictureStack> pictures{};
  std::shared_ptr<const OutlineStack> outlines{};

  // Returns the memory that they take.
  [[nodiscard]] std::uint64_t bytes() const {
    return (pictures ? pictures->bytes() : 0) + (outlines ? outlines->bytes() : 0);
  }
};

class ModelFile {
 public:
  // `file` is the model's file in messages. `name` precedes messages; empty if the job has only one model.
  ModelFile(std::filesystem::path file, OpenedModel opened, const std::string& name);

  // Returns the model's path in a ZIP archive; empty if the file itself is the model.
  [[nodiscard]] const std::string& entry() const { return opened_.entry; }
  // True if the model was chosen because it carries supports: see ChosenModel.
  [[nodiscard]] bool is_supported() const { return opened_.is_supported; }

  [[nodiscard]] const ModelOutline& outline() const { return opened_.input->outline(); }
  // Reads the model, up to the length that the file had when it was opened. Call it once. Blocks. Throws
  // JobRefused, also if the file says how to make more than `most_facets` of what it holds.
  [[nodiscard]] Model read(std::uint64_t most_facets);
  // Returns the archive if the file holds finished layers; null for a model.
  [[nodiscard]] const SlicedArchive* sliced() const { return opened_.input->sliced(); }
  // Reads the finished layers for a display: see SlicedArchive::read() and read_outlines(). Throws
  // JobRefused. REQUIRES: sliced().
  [[nodiscard]] FinishedLayers read_layers(const DisplayGeometry& display, std::uint64_t most_bytes,
                                           const std::stop_token& stop) const;

 private:
  std::filesystem::path file_;
  OpenedModel opened_;
  std::string prefix_;
};

// The models of a file, with their outlines.
struct ModelFiles {
  std::vector<ModelFile> files;    // at least one
  std::vector<std::string> notes;  // see OpenedModels
};

// Opens a file and reads the outlines of its models from their beginnings. `name` precedes error messages,
// and the paths of models in an archive follow it; empty if the file is the whole job. Throws JobRefused.
[[nodiscard]] ModelFiles open_model_files(const ModelPlace& place, const std::string& name);

}  // namespace contourd
