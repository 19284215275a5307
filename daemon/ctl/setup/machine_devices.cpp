#include "daemon/ctl/setup/machine_devices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <sstream>
#include <system_error>

#include "daemon/ctl/commands/machine_facts.hpp"
#include "daemon/system/readable.hpp"
#include "hw/gpio/gpiod.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kMostLines = 512;  // read per chip
constexpr std::size_t kMostModes = 200;

FoundChip look_at_chip(const fs::path& device) {
  const GpiodChip chip(device);
  FoundChip found{chip.name(), chip.label(), {}};
  for (unsigned i = 0; i < std::min(chip.line_count(), kMostLines); ++i) {
    const GpiodLineInfo line = chip.line_info(i);
    found.lines.push_back({line.name, line.consumer});
  }
  return found;
}

void find_chips(const fs::path& root, MachineDevices& devices) {
  for (const fs::path& device : entries_of(root / "dev")) {
    if (!device.filename().string().starts_with("gpiochip")) continue;
    try {
      devices.chips.push_back(look_at_chip(device));
    } catch (const std::exception& error) {
      devices.troubles.push_back(fmt::format("{}: {}: run this as root, or as a member of the group gpio",
                                             device.string(), error.what()));
    }
  }
}

// Returns "HDMI-A-1" for "card1-HDMI-A-1", or an empty string if the entry is not an output.
std::string output_name(const std::string& entry) {
  const std::size_t dash = entry.find('-');
  return entry.starts_with("card") && dash != std::string::npos ? entry.substr(dash + 1) : "";
}

void find_outputs(const fs::path& root, MachineDevices& devices) {
  for (const fs::path& entry : entries_of(root / "sys/class/drm")) {
    const std::string name = output_name(entry.filename().string());
    std::error_code none;
    if (name.empty() || name.starts_with("Writeback") || !fs::exists(entry / "status", none)) continue;
    FoundOutput output{name, text_of(entry / "status") == "connected", {}};
    std::istringstream modes(text_of(entry / "modes"));
    for (std::string mode; std::getline(modes, mode) && output.modes.size() < kMostModes;)
      if (std::ranges::find(output.modes, mode) == output.modes.end() && mode.find('x') != std::string::npos)
        output.modes.push_back(mode);
    devices.outputs.push_back(std::move(output));
  }
}

// True if the port exists. A PC has nodes for serial ports without hardware, and their type is 0.
bool is_there(const fs::path& tty) {
  std::error_code none;
  return fs::exists(tty / "device" / "driver", none) &&
         !(fs::exists(tty / "type", none) && text_of(tty / "type") == "0");
}

void find_ports(const fs::path& root, MachineDevices& devices) {
  std::set<std::string> known;
  for (const fs::path& link : entries_of(root / "dev/serial/by-id")) {
    const std::string tty = name_of_link(link);
    known.insert(tty);
    devices.ports.push_back({"/" + link.lexically_relative(root).string(), tty});
  }
  for (const fs::path& tty : entries_of(root / "sys/class/tty")) {
    const std::string name = tty.filename().string();
    if (is_there(tty) && !known.contains(name)) devices.ports.push_back({"/dev/" + name, name});
  }
}

std::string describe(const FoundChip& chip) {
  const auto used =
      std::ranges::count_if(chip.lines, [](const FoundLine& line) { return line.user.has_value(); });
  return fmt::format("GPIO: {} ({}), {} lines, {} of them in use", chip.name, chip.label, chip.lines.size(),
                     used);
}

std::string describe(const FoundOutput& output) {
  if (!output.connected) return fmt::format("Display: {}, nothing connected", output.name);
  if (output.modes.empty()) return fmt::format("Display: {}, connected, reports no modes", output.name);
  const std::size_t others = output.modes.size() - 1;
  return fmt::format("Display: {}, connected, {}{}", output.name, output.modes.front(),
                     others > 0 ? fmt::format(" and {} other sizes", others) : "");
}

}  // namespace

MachineDevices find_devices(const fs::path& root) {
  MachineDevices devices;
  std::error_code none;
  if (const fs::path model = root / "proc/device-tree/model"; fs::exists(model, none))
    devices.model = text_of(model);
  find_chips(root, devices);
  find_outputs(root, devices);
  find_ports(root, devices);
  return devices;
}

std::vector<std::string> describe(const MachineDevices& devices) {
  std::vector<std::string> lines;
  if (!devices.model.empty()) lines.push_back(fmt::format("Computer: {}", devices.model));
  for (const FoundChip& chip : devices.chips)
    lines.push_back(describe(chip));
  for (const FoundOutput& output : devices.outputs)
    lines.push_back(describe(output));
  for (const FoundPort& port : devices.ports)
    lines.push_back(port.path.ends_with(port.tty) ? fmt::format("Serial port: {}", port.path)
                                                  : fmt::format("Serial port: {} ({})", port.path, port.tty));
  for (const std::string& trouble : devices.troubles)
    lines.push_back(trouble);
  if (devices.chips.empty() && devices.troubles.empty())
    lines.emplace_back(
        "GPIO: none. The motor's driver and the switch need a computer with GPIO lines, such as a Raspberry "
        "Pi.");
  if (devices.outputs.empty())
    lines.emplace_back(
        "Display: none. On a Raspberry Pi, dtoverlay=vc4-kms-v3d in /boot/firmware/config.txt enables the "
        "outputs.");
  else if (connected_output(devices) == nullptr)
    lines.emplace_back("Display: plug the projector in and switch it on; otherwise enter its size by hand.");
  if (devices.ports.empty())
    lines.emplace_back(
        "Serial port: none. Plug in the USB serial adapter of the projector, unless a GPIO line switches the "
        "light.");
  for (std::string& line : lines)
    line = printable(line);
  return lines;
}

const FoundChip* header_chip(const MachineDevices& devices) {
  const auto has_header = [](const FoundChip& chip) {
    return chip.label == "pinctrl-rp1" || chip.label.starts_with("pinctrl-bcm");
  };
  const auto chip = std::ranges::find_if(devices.chips, has_header);
  if (chip != devices.chips.end()) return &*chip;
  return devices.chips.empty() ? nullptr : &devices.chips.front();
}

const FoundChip* find_chip(const MachineDevices& devices, const std::string& word) {
  const auto chip = std::ranges::find_if(devices.chips, [&](const FoundChip& each) {
    return word == each.name || word == "/dev/" + each.name || word == each.label;
  });
  return chip != devices.chips.end() ? &*chip : nullptr;
}

const FoundOutput* connected_output(const MachineDevices& devices) {
  const auto output = std::ranges::find_if(devices.outputs, &FoundOutput::connected);
  return output != devices.outputs.end() ? &*output : nullptr;
}

}  // namespace contourd::ctl
