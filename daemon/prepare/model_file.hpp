// A model file named by a job: opened and outlined first, read later. The opened file stays the one that is
// read, even if another file replaces it meanwhile. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "daemon/formats/model_input.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

// The place of a model: a file, or a model in a ZIP archive.
struct ModelPlace {
  std::filesystem::path path;
  std::string entry{};  // name in the archive; empty: the file itself, or the archive's only model
  Links links = Links::Follow;
};

class ModelFile {
 public:
  // Opens the file and reads its outline from its beginning. `name` precedes error messages; empty if the job
  // has only one model. Throws JobRefused.
  ModelFile(ModelPlace place, const std::string& name);

  [[nodiscard]] const ModelOutline& outline() const { return input_->outline(); }
  // Reads the model, up to the length that the file had when it was opened. Call it once. Blocks. Throws
  // JobRefused, also if the file says how to make more than `most_facets` of what it holds.
  [[nodiscard]] Model read(std::uint64_t most_facets);

 private:
  [[nodiscard]] std::unique_ptr<ModelInput> open() const;
  // Calls `work` and turns its exceptions into JobRefused.
  template <typename Work>
  auto or_refuse(Work work) const;

  ModelPlace place_;
  std::string prefix_;
  std::unique_ptr<ModelInput> input_;
};

}  // namespace contourd
