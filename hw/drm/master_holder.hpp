// Who is DRM master of a card, as far as this process may know. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// The master's name and process in the kernel's list of a card's clients (/sys/kernel/debug/dri/N/clients):
// "Xorg (process 612)".
[[nodiscard]] std::optional<std::string> master_among(std::string_view clients);

// A part of a sentence, from that list when it can be read (by root alone as a rule), else from who has the
// card open, else what an owner can do to find out: "Xorg (process 612) is its DRM master".
[[nodiscard]] std::string describe_master_holder(const std::filesystem::path& card);

}  // namespace contourd
