// An STL file that a job names: opened, looked at, then read. What was looked at is what is read, whatever is
// put in its place meanwhile. Thread-safe (no shared state).
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
  // Opens it and looks at its beginning. `name` stands before what is wrong with it, if there are several.
  // Throws JobRefused.
  ModelFile(std::filesystem::path path, const std::string& name, Links links);

  [[nodiscard]] const ModelOutline& outline() const { return outline_; }
  // As long as it was when it was opened. To be called once; blocks. Throws JobRefused.
  [[nodiscard]] Model read();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void open(Links links);
  template <typename Work>
  auto refusing(Work work) const;

  std::filesystem::path path_;
  std::string prefix_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::uint64_t bytes_ = 0;
  ModelOutline outline_;
};

}  // namespace contourd
