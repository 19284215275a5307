// A model's file, opened for reading: the one place that decides by a file's content how it is read. Every
// model that contourd prints, and every one that contourctl reads, comes through here.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include "core/formats/file_bytes.hpp"
#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"

namespace contourd {

// The file to read. A value with an open file.
struct ModelSource {
  OpenFile file;               // at its beginning
  std::uint64_t bytes = 0;     // size when it was opened: nothing after it is read
  std::filesystem::path path;  // the name in messages
  std::string entry{};         // name of a model in a ZIP archive; empty if the archive holds only one
};

// Used by one thread.
class ModelInput {
 public:
  ModelInput() = default;
  ModelInput(const ModelInput&) = delete;
  ModelInput& operator=(const ModelInput&) = delete;
  virtual ~ModelInput() = default;

  [[nodiscard]] virtual const ModelOutline& outline() const = 0;
  // Reads the model. Call it once. Blocks for a time in proportion to the file, and to what it becomes when
  // it is unpacked, which input_limits.hpp bounds. Throws ModelError for bad data and for a model that
  // consists of more than `most_facets` copies of facets, std::system_error if the file cannot be read.
  [[nodiscard]] virtual Model read(std::uint64_t most_facets) = 0;
};

// Opens a model by its content, whatever its name is. Reads little of the file: its beginning, and the list
// of an archive. Throws ModelError if that shows what is wrong, std::system_error if the file cannot be read.
[[nodiscard]] std::unique_ptr<ModelInput> open_model(ModelSource source);

// Opens a regular file, or the model `entry` in it. Throws what the function above throws.
[[nodiscard]] std::unique_ptr<ModelInput> open_model(const std::filesystem::path& path,
                                                     const std::string& entry = "");

}  // namespace contourd
