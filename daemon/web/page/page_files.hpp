// The files of the page, which anyone may load. Thread-safe (no state).
#pragma once

#include <string_view>

namespace contourd::web {

struct PageFile {
  std::string_view path;
  const char* type;
  const std::string_view& text;
};

// Returns the file at this path of the page; null if there is none.
[[nodiscard]] const PageFile* page_file(std::string_view path);

}  // namespace contourd::web
