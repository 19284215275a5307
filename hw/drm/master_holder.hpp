// The program that is DRM master of a card, as far as this process may know. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// Returns the master's name and process from the kernel's list of a card's clients
// (/sys/kernel/debug/dri/N/clients): "Xorg (process 612)". Returns nullopt if no client is master.
[[nodiscard]] std::optional<std::string> master_among(std::string_view clients);

// Returns a clause such as "Xorg (process 612) is its DRM master". The source is that list if it can be read
// (usually only by root), else the processes that have the card open; if none is visible the clause says how
// to find out.
[[nodiscard]] std::string describe_master_holder(const std::filesystem::path& card);

}  // namespace contourd
