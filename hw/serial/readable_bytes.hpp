// What came over a line, fit for a message: printable ASCII as it is, all else as \r, \n or \xHH, in quotes.
// Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace contourd {

// Cut at 32 bytes.
[[nodiscard]] std::string readable_bytes(std::string_view bytes);

}  // namespace contourd
