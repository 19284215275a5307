// Parts of the messages about schema violations. Pure functions, thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// Returns ` mm` for ".../travel_mm", from the pointer's last key that ends in a unit; empty if there is none.
[[nodiscard]] std::string unit_of(std::string_view pointer);

// Returns a description of the value for use after "found".
[[nodiscard]] std::string found(const nlohmann::json& value);

// Joins the words with `between`.
[[nodiscard]] std::string joined(const std::vector<std::string>& words, std::string_view between);

// Returns the message about an unknown key. It suggests the known key that was probably meant, or lists all
// of them.
[[nodiscard]] std::string unknown_key(const std::string& key, const std::vector<std::string>& known);

}  // namespace contourd
