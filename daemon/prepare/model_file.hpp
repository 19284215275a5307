// A model file named by a job: opened and outlined first, read later. The opened file stays the one that is
// read, even if another file replaces it meanwhile. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "core/formats/model_reader.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

class ModelFile {
 public:
  // Opens the file and reads its outline from its beginning. `name` precedes error messages; empty if the job
  // has only one model. Throws JobRefused.
  ModelFile(std::filesystem::path path, const std::string& name, Links links);

  [[nodiscard]] const ModelOutline& outline() const { return outline_; }
  // Reads the model, up to the length that the file had when it was opened. Call it once. Blocks. Throws
  // JobRefused.
  [[nodiscard]] Model read();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void open(Links links);
  // Calls `work` and turns its exceptions into JobRefused.
  template <typename Work>
  auto or_refuse(Work work) const;

  std::filesystem::path path_;
  std::string prefix_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::uint64_t bytes_ = 0;
  ModelOutline outline_;
};

}  // namespace contourd
