// The parts of the sentences about what a schema has against a value. Pure functions, thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// ` mm` for ".../travel_mm", by the pointer's last key that ends in a unit; nothing for a plain number.
[[nodiscard]] std::string unit_of(std::string_view pointer);

// The value as a message shows it, after "found".
[[nodiscard]] std::string found(const nlohmann::json& value);

[[nodiscard]] std::string joined(const std::vector<std::string>& words, std::string_view between);

// With the one of the known keys that was probably meant, or with all of them.
[[nodiscard]] std::string unknown_key(const std::string& key, const std::vector<std::string>& known);

}  // namespace contourd
