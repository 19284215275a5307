// A model as every command reads it.
#pragma once

#include <filesystem>

#include "core/model/model.hpp"

namespace contourd::ctl {

// read_model_file(), with the file's name in front of what is wrong with it; what needs more memory than
// there is is not read. Throws as that does.
[[nodiscard]] Model read_model(const std::filesystem::path& path);

}  // namespace contourd::ctl
