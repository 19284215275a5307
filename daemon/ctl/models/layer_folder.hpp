// A folder with one file a layer: 0001.png, 0002.png and so on. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace contourd::ctl {

// The name of a layer's file, the first being 1.
[[nodiscard]] std::string layer_file(std::size_t layer, std::string_view extension);

// What becomes of the files of an earlier slice: those behind the last new one would pass for layers of this
// model.
enum class Earlier { Refuse, Replace };

// Makes the folder, and removes such files from it, whatever else lies there staying. Throws OutputError when
// that is not possible, or there are some that are not to be replaced; then nothing is changed.
void open_layer_folder(const std::filesystem::path& folder, std::string_view extension, Earlier earlier);

}  // namespace contourd::ctl
