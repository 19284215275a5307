// A file that contourd sends in pieces, such as a picture. Event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

inline constexpr int kNoFile = -32097;  // the error's code if contourd sends no file, or too large a one

// A method whose reply has a piece of a file (`data`, Base64), the file's size (`bytes`), and under the name
// `version` a number with which the next piece is asked for.
struct FileQuestion {
  std::string method;
  ControlLink::Json parameters = ControlLink::Json::object();
  const char* version = "picture";
  std::size_t most_bytes = std::size_t{8} << 20U;
};

// Gets the file; or no bytes, and the "error" of contourd's answer.
using FileFetched = std::function<void(std::string bytes, const ControlLink::Json& error)>;

// Asks for one piece after the other. Calls `fetched` later, exactly once. The link must outlive that call.
void fetch_file(ControlLink& printer, FileQuestion question, FileFetched fetched);

}  // namespace contourd::web
