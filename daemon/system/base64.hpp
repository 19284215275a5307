// Encodes and decodes Base64 with padding (RFC 4648). Pure functions, thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

// Returns the decoded bytes, or nullopt if base64() never produces this text.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace contourd
