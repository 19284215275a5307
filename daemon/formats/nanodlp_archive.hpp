// A plate of NanoDLP (.nanodlp), as DragonFruit writes it: a ZIP archive with plate.json, profile.json and
// options.json, and a PNG picture of each layer: 1.png, 2.png and so on. Thread-safe (no state).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/formats/sl1_config.hpp"
#include "daemon/formats/zip_archive.hpp"

namespace contourd {

// True if the archive has plate.json, 1.png, and profile.json or options.json.
[[nodiscard]] bool is_nanodlp(const ZipArchive& archive);

// The texts of the archive's files; empty if there is no such file.
struct NanodlpTexts {
  std::string plate, profile, options;
};

// Returns the settings. A number that is missing or 0 is not told by the file. Throws ModelError, a sentence,
// for a text that is no JSON object, and for a setting that is wrong; or missing, if it is the layers'
// thickness.
[[nodiscard]] SlicedSettings read_nanodlp_settings(const NanodlpTexts& texts);

// Returns the pictures from the lowest layer up. Throws ModelError if one is missing, or if there are not
// `layers` (0: any number). REQUIRES: is_nanodlp().
[[nodiscard]] std::vector<const ZipEntry*> nanodlp_layers(const ZipArchive& archive, std::int64_t layers);

}  // namespace contourd
