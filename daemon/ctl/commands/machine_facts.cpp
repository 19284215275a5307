#include "daemon/ctl/commands/machine_facts.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

#include "daemon/ctl/terminal/program.hpp"
#include "hw/gpio/gpio_lines.hpp"
#include "hw/gpio/gpiod.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfAFile = 65'536;
constexpr unsigned kMostLines = 512;  // listed per GPIO chip
constexpr std::size_t kMostEntries = 256;

std::string section(const fs::path& file) {
  return fmt::format("{}:\n{}\n\n", file.string(), text_of(file));
}

// Returns ", USB vendor:product manufacturer product" for a port of a USB device, else an empty text. The
// device is a parent folder of the interface in sysfs.
std::string usb_maker(const fs::path& tty) {
  std::error_code code;
  fs::path device = fs::canonical(tty / "device", code);
  constexpr int kMostLevels = 4;
  for (int i = 0; !code && i < kMostLevels; ++i, device = device.parent_path()) {
    if (fs::exists(device / "idVendor", code))
      return fmt::format(", USB {}:{} {} {}", text_of(device / "idVendor"), text_of(device / "idProduct"),
                         text_of(device / "manufacturer"), text_of(device / "product"));
  }
  return "";
}

std::string chip_facts(const fs::path& device) {
  try {
    const GpiodChip chip(device);
    std::string text = fmt::format("{} ({}), {} lines\n", chip.name(), chip.label(), chip.line_count());
    for (unsigned i = 0; i < std::min(chip.line_count(), kMostLines); ++i) {
      const GpiodLineInfo line = chip.line_info(i);
      text += fmt::format("  {}\n",
                          describe({chip.name(), chip.label(), i, line.name, line.consumer, line.output}));
    }
    return text;
  } catch (const std::exception& error) {
    return fmt::format("{}: {}\n", device.string(), error.what());
  }
}

}  // namespace

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
    entries.push_back(entry->path());
  std::ranges::sort(entries);
  entries.resize(std::min(entries.size(), kMostEntries));
  return entries;
}

std::string text_of(const fs::path& file) {
  try {
    std::string text = beginning_of(file, kMostOfAFile, Links::Follow);
    std::erase(text, '\0');
    while (text.ends_with('\n'))
      text.pop_back();
    return text;
  } catch (const UnreadableFile& error) {
    return fmt::format("({})", error.what());
  }
}

std::string name_of_link(const fs::path& link) {
  std::error_code none;
  return fs::read_symlink(link, none).filename().string();
}

std::string beginning_of(const fs::path& file, std::size_t most, Links links) {
  const FileDescriptor open = open_regular_file(file, links);
  std::string text(most, '\0');
  std::size_t size = 0;
  while (size < most) {
    const ssize_t bytes = ::read(open.get(), text.data() + size, most - size);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0)
      throw UnreadableFile({errno, std::generic_category()}, std::generic_category().message(errno));
    if (bytes == 0) break;
    size += static_cast<std::size_t>(bytes);
  }
  text.resize(size);
  return text;
}

std::string versions() {
  std::string text = fmt::format("contourctl {}\n\n", CONTOURD_VERSION) + section("/usr/lib/os-release");
  try {
    text +=
        "packages:\n" + run_program({"dpkg-query", "--show", "contourd", "libdrm2", "libgpiod2", "libgpiod3",
                                     "libserialport0", "libsystemd0", "linux-image-*", "raspi-firmware"},
                                    kMostOfAFile)
                            .text;
  } catch (const std::system_error& error) {
    text += fmt::format("({})\n", error.what());
  }
  return text;
}

std::string kernel_facts() {
  utsname kernel{};
  (void)::uname(&kernel);
  std::string text =
      fmt::format("{} {} {} {}\n\n", kernel.sysname, kernel.release, kernel.version, kernel.machine);
  for (const char* file : {"/proc/cmdline", "/proc/device-tree/model", "/proc/meminfo", "/proc/loadavg",
                           "/proc/uptime", "/proc/modules"})
    text += section(file);
  return text;
}

std::string display_facts() {
  std::string text;
  for (const fs::path& entry : entries_of("/sys/class/drm")) {
    const fs::path driver = entry / "device" / "driver";
    if (const std::string name = name_of_link(driver); !name.empty())
      text += fmt::format("{}: driver {}\n", entry.filename().string(), name);
    std::error_code none;
    if (!fs::exists(entry / "status", none)) continue;
    text += fmt::format("{}: {}, {}, modes:\n{}\n\n", entry.filename().string(), text_of(entry / "status"),
                        text_of(entry / "enabled"), text_of(entry / "modes"));
  }
  return text.empty() ? "this computer has no display by DRM (/sys/class/drm)\n" : text;
}

std::string gpio_facts() {
  std::string text;
  for (const fs::path& device : entries_of("/dev"))
    if (device.filename().string().starts_with("gpiochip")) text += chip_facts(device);
  return text.empty() ? "this computer has no GPIO chip (/dev/gpiochip...)\n" : text;
}

std::string serial_facts() {
  std::string text;
  for (const fs::path& tty : entries_of("/sys/class/tty")) {
    const std::string driver = name_of_link(tty / "device" / "driver");
    if (!driver.empty())
      text += fmt::format("/dev/{}: driver {}{}\n", tty.filename().string(), driver, usb_maker(tty));
  }
  for (const fs::path& port : entries_of("/dev/serial/by-path"))
    text += fmt::format("{} -> {}\n", port.string(), name_of_link(port));
  return text.empty() ? "this computer has no serial port (/sys/class/tty)\n" : text;
}

}  // namespace contourd::ctl
