// The kernel's text console on a card's outputs. While this process lives, DRM master keeps the console off
// the screen; when the process dies, the kernel shows the console's picture again, as light. So the picture
// is made black and the console is set to draw no text. Both deliberately outlast this process. They do not
// cover a switch to another terminal, or a login prompt that restarts (getty sets its terminal to text mode):
// booting with fbcon=map:9 keeps the console off the outputs for good.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace contourd {

// Returns the device of the console on that card ("/dev/fb0"), or nullopt if the card has none.
[[nodiscard]] std::optional<std::filesystem::path> console_of(const std::filesystem::path& card);

// Puts the active virtual terminal into graphics mode (KD_GRAPHICS: ioctl_console(2)), in which the kernel
// draws no text, and overwrites the console's picture with black. Does nothing on a card without a console.
// Returns a sentence, with what the operator can do, if the console could not be kept off.
[[nodiscard]] std::optional<std::string> keep_console_dark(const std::filesystem::path& card);

}  // namespace contourd
