// Devices of this computer to which a printer can be wired: GPIO chips, display outputs, serial ports. Only
// reads, and occupies no device. Names come unchanged from the kernel and the devices; describe() makes them
// printable. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::ctl {

struct FoundLine {
  std::string name;                 // "GPIO17"; empty if the line has no name
  std::optional<std::string> user;  // consumer of the line; nullopt if the line is free
};

struct FoundChip {
  std::string name;              // "gpiochip0"
  std::string label;             // "pinctrl-bcm2711"
  std::vector<FoundLine> lines;  // index: number of the line
};

struct FoundOutput {
  std::string name;  // "HDMI-A-1"
  bool connected = false;
  std::vector<std::string> modes;  // "1920x1080"; the preferred mode first, no duplicates
};

struct FoundPort {
  std::string path;  // if possible a link in /dev/serial/by-id, which does not depend on other ports
  std::string tty;   // "ttyUSB0"
};

struct MachineDevices {
  std::string model;  // "Raspberry Pi 4 Model B Rev 1.4"; empty if unknown
  std::vector<FoundChip> chips;
  std::vector<FoundOutput> outputs;
  std::vector<FoundPort> ports;
  std::vector<std::string> troubles;  // devices that cannot be read, one message each
};

// Finds devices in /dev, /proc and /sys below `root`.
[[nodiscard]] MachineDevices find_devices(const std::filesystem::path& root = "/");

// Returns a line for each device, and for each missing kind of device a line with advice. All lines are
// printable.
[[nodiscard]] std::vector<std::string> describe(const MachineDevices& devices);

// Returns the chip whose lines are on a Raspberry Pi's header, else the first chip, or nullptr if there is
// none.
[[nodiscard]] const FoundChip* header_chip(const MachineDevices& devices);
// Finds a chip by its name, path or label. Returns nullptr if there is none.
[[nodiscard]] const FoundChip* find_chip(const MachineDevices& devices, const std::string& word);
// Returns the first connected output, or nullptr if there is none.
[[nodiscard]] const FoundOutput* connected_output(const MachineDevices& devices);

}  // namespace contourd::ctl
