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

// Returns 0 or an errno. No virtual terminal, no text.
int stop_drawing_text() {
  const FileDescriptor terminal(::open("/dev/tty0", O_WRONLY | O_NOCTTY | O_CLOEXEC));
  if (!terminal.valid()) return errno == ENOENT || errno == ENODEV || errno == ENXIO ? 0 : errno;
  return ::ioctl(terminal.get(), KDSETMODE, KD_GRAPHICS) == 0 ? 0 : errno;
}

// Returns 0 or an errno.
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
  return "the text console (" + console->string() + ") may come back on " + card.string() +
         " when this program dies, as light: " +
         (drawing != 0
              ? std::string("the terminal does not let itself be set to graphics (/dev/tty0: ") +
                    std::strerror(drawing) + ")"
              : console->string() + " does not let itself be blackened (" + std::strerror(picture) + ")") +
         "; the kernel's parameter fbcon=map:9 keeps it off every output";
}

}  // namespace contourd
