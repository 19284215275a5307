// The names of files that contourd takes for models. Thread-safe (no shared state).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace contourd {

// Returns the extensions of models, in lower case with their dots: ".stl", and ".stl.gz" for a compressed
// one. No extension ends with another one.
[[nodiscard]] std::span<const std::string_view> model_extensions();

// Returns the extension that makes a file of this name a model, in lower case; empty if the file is no model.
// The name may be in either case.
[[nodiscard]] std::string_view model_extension(std::string_view file_name);

// Returns the name without the extension of a model, or unchanged if it has none: "part" of "part.stl.gz".
[[nodiscard]] std::string model_stem(std::string_view file_name);

// Returns the extensions as a clause: ".stl, .obj or .zip".
[[nodiscard]] std::string model_extensions_text();

}  // namespace contourd
