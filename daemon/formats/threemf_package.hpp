// A 3MF model in its package, a ZIP archive (3MF Core Specification 1.4). Used by one thread.
#pragma once

#include <cstdint>
#include <string>

#include "core/formats/model_format.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/zip_archive.hpp"

namespace contourd {

// True if the archive is the package of a 3MF model.
[[nodiscard]] bool is_threemf(const ZipArchive& archive);

class ThreeMfPackage {
 public:
  // Finds the root model. The archive must outlive the package. Throws ModelError if there is none, or if the
  // model files become too large when they are unpacked.
  explicit ThreeMfPackage(const ZipArchive& archive);

  // The number of facets is an estimate, because components may place an object many times.
  [[nodiscard]] const ModelOutline& outline() const { return outline_; }
  // Reads the model; blocks. Throws ModelError, also for one that has more than `most_facets` facets with all
  // its components and copies, and std::system_error if the file cannot be read.
  [[nodiscard]] Model read(std::uint64_t most_facets) const;

 private:
  const ZipArchive& archive_;
  std::string root_;  // name of the root model's entry
  ModelOutline outline_;
};

}  // namespace contourd
