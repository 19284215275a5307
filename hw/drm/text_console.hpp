// The kernel's text console on a card's outputs. DRM master keeps it off the screen while this process lives;
// when it dies the kernel puts the console's picture back, as light. So that picture is made black, and the
// console told to draw no more. Both last beyond this process: that is their purpose. Who wants no console
// there at all boots with fbcon=map:9: another terminal that is switched to, or a login prompt that starts
// anew (getty sets its terminal to text), draws again.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace contourd {

// The console's device on that card ("/dev/fb0"), if it has one.
[[nodiscard]] std::optional<std::filesystem::path> console_of(const std::filesystem::path& card);

// Puts the active virtual terminal into graphics mode (KD_GRAPHICS: ioctl_console(2)), in which the kernel
// draws no text, and writes black all over the console's picture. Nothing to do on a card without console.
// Returns a sentence when the console could not be kept off, with what an owner can do.
[[nodiscard]] std::optional<std::string> keep_console_dark(const std::filesystem::path& card);

}  // namespace contourd
