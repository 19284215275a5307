// Why a file that an owner may want to print is not printed as it is: it is not a model that contourd reads.
// Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace contourd {

enum class WhyIgnored {
  Folder,  // without plate.json
  Model,   // a format that contourd does not read
  Sliced,  // sliced for another printer
  Archive,
  NotAFile,  // a link, a pipe or a device
  Other,
};

// Returns why a path in incoming/ that is neither a folder nor named like a model is ignored. Returns nullopt
// if it does not exist, is hidden, is a ticket (which may wait for its model), or has the name of an
// unfinished upload.
[[nodiscard]] std::optional<WhyIgnored> why_ignored(const std::filesystem::path& path);

// Returns Model, Sliced or Archive if the file's name is that of a format that contourd does not read but an
// owner may want to print; reads no file.
[[nodiscard]] std::optional<WhyIgnored> why_format_is_ignored(const std::filesystem::path& file);

// Returns a sentence that says why the file is ignored and what to put there instead.
[[nodiscard]] std::string_view sentence_for(WhyIgnored why);

}  // namespace contourd
