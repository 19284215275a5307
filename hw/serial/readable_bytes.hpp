// Received bytes in readable form, for messages: printable ASCII as it is, all else as \r, \n or \xHH, in
// quotes. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace contourd {

// Returns the bytes in readable form, cut at 32 bytes.
[[nodiscard]] std::string readable_bytes(std::string_view bytes);

}  // namespace contourd
