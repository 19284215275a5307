// The models in a ZIP archive. Thread-safe (no shared state).
#pragma once

#include <string_view>
#include <vector>

#include "daemon/formats/zip_archive.hpp"

namespace contourd {

// Returns the entries that are models by their names, in the archive's order. Files of macOS (__MACOSX) and
// files and folders whose name begins with a dot are left out.
[[nodiscard]] std::vector<const ZipEntry*> models_of(const ZipArchive& archive);

// Returns the entry to print: the one of this name, with its folders or, if no other has it, without; if
// `name` is empty, the only model. Throws ModelError if there is none, or if there are several.
[[nodiscard]] const ZipEntry& model_in(const ZipArchive& archive, std::string_view name);

}  // namespace contourd
