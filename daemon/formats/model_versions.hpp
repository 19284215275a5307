// The names of models in an archive: which of them are versions of one model, with and without supports or in
// several formats, as shops pack them. Thread-safe (no shared state).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// The supports of a model, by its path.
enum class NamedSupports { Unsaid, With, Without };

// A model's path in an archive, read as words.
struct VersionName {
  std::string model;  // the words that remain, in lower case: equal for the versions of one model
  NamedSupports supports = NamedSupports::Unsaid;
};

// Returns the parts of a path: folders, then the file. Windows' programs separate them by backslashes.
[[nodiscard]] std::vector<std::string_view> path_parts(std::string_view path);

// Reads the path of a model, whose file has this extension. "Supported/STL/Dragon_sup.stl", "Dragon.stl" and
// "un-supported/dragon.stl" are versions of one model: words for supports count in folders and files, names
// of formats do not count in folders.
[[nodiscard]] VersionName version_name(std::string_view path, std::string_view extension);

// True if the path of a model says that it carries supports.
[[nodiscard]] bool says_supported(std::string_view path);

}  // namespace contourd
