// Bytes as text and back, by RFC 4648's Base64 with its padding. Pure functions, thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

// Nothing when the text is not what base64() makes of any bytes.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace contourd
