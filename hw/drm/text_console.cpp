#include "hw/drm/text_console.hpp"

#include <fcntl.h>
#include <linux/kd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Sets the active virtual terminal to graphics mode. Returns 0 or an errno; 0 also if there are no virtual
// terminals, because then no text is drawn.
int stop_drawing_text() {
  const FileDescriptor terminal(::open("/dev/tty0", O_WRONLY | O_NOCTTY | O_CLOEXEC));
  if (!terminal.valid()) return errno == ENOENT || errno == ENODEV || errno == ENXIO ? 0 : errno;
  return ::ioctl(terminal.get(), KDSETMODE, KD_GRAPHICS) == 0 ? 0 : errno;
}

// Overwrites the console's picture with black. Returns 0 or an errno.
int blacken(const fs::path& console) {
  const FileDescriptor picture(::open(console.c_str(), O_WRONLY | O_CLOEXEC));
  if (!picture.valid()) return errno;
  static constexpr std::array<char, 65536> kBlack{};
  for (;;) {
    const ssize_t count = ::write(picture.get(), kBlack.data(), kBlack.size());
    if (count > 0) continue;
    return count == 0 || errno == ENOSPC || errno == EFBIG ? 0 : errno;
  }
}

}  // namespace

std::optional<fs::path> console_of(const fs::path& card) {
  std::error_code none;
  for (const auto& entry :
       fs::directory_iterator("/sys/class/drm" / card.filename() / "device" / "graphics", none)) {
    if (entry.path().filename().string().starts_with("fb")) return "/dev" / entry.path().filename();
  }
  return std::nullopt;
}

std::optional<std::string> keep_console_dark(const fs::path& card) {
  const auto console = console_of(card);
  if (!console) return std::nullopt;
  const int drawing = stop_drawing_text();
  const int picture = blacken(*console);
  if (drawing == 0 && picture == 0) return std::nullopt;
  return "the text console (" + console->string() + ") may come back as light on " + card.string() +
         " if this program dies: " +
         (drawing != 0 ? std::string("the terminal cannot be set to graphics mode (/dev/tty0: ") +
                             std::strerror(drawing) + ")"
                       : console->string() + " cannot be blackened (" + std::strerror(picture) + ")") +
         "; the kernel parameter fbcon=map:9 keeps it off every output";
}

}  // namespace contourd
