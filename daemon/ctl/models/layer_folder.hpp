// A folder with one file per layer: 0001.png, 0002.png and so on. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace contourd::ctl {

// Returns the name of a layer's file; layers are counted from 1.
[[nodiscard]] std::string layer_file(std::size_t layer, std::string_view extension);

// The treatment of an earlier slice's files. They cannot stay: files after the last new layer would look like
// layers of this model.
enum class Earlier { Refuse, Replace };

// Makes the folder and removes an earlier slice's files from it; other files stay. Throws OutputError if this
// fails, or if there are such files and `earlier` is Refuse; then nothing is changed.
void open_layer_folder(const std::filesystem::path& folder, std::string_view extension, Earlier earlier);

}  // namespace contourd::ctl
