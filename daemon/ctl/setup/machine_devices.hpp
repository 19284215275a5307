// What a printer can be wired to on this computer: GPIO chips, display outputs, serial ports. Changes nothing
// and takes no device. Names are as the kernel and the devices say them: whoever prints them makes them fit.
// Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::ctl {

struct FoundLine {
  std::string name;                 // "GPIO17"; empty when it has none
  std::optional<std::string> user;  // who holds it; nothing when it is free
};

struct FoundChip {
  std::string name;              // "gpiochip0"
  std::string label;             // "pinctrl-bcm2711"
  std::vector<FoundLine> lines;  // by their numbers
};

struct FoundOutput {
  std::string name;  // "HDMI-A-1"
  bool connected = false;
  std::vector<std::string> modes;  // "1920x1080", the preferred one first, each once
};

struct FoundPort {
  std::string path;  // best a link in /dev/serial/by-id, which stays the same when others are plugged in
  std::string tty;   // "ttyUSB0"
};

struct MachineDevices {
  std::string model;  // "Raspberry Pi 4 Model B Rev 1.4"; empty when it does not say
  std::vector<FoundChip> chips;
  std::vector<FoundOutput> outputs;
  std::vector<FoundPort> ports;
  std::vector<std::string> troubles;  // with what cannot be looked at: a sentence each
};

// Looks into /dev, /proc and /sys of that folder.
[[nodiscard]] MachineDevices find_devices(const std::filesystem::path& root = "/");

// A line for each of them, and for each kind that is missing a line of what to do.
[[nodiscard]] std::vector<std::string> describe(const MachineDevices& devices);

// The chip whose lines are on a Raspberry Pi's header, else the first; null when there is none.
[[nodiscard]] const FoundChip* header_chip(const MachineDevices& devices);
// By its name, its path or its label; null when there is none.
[[nodiscard]] const FoundChip* find_chip(const MachineDevices& devices, const std::string& word);
// The first that is connected, else null.
[[nodiscard]] const FoundOutput* connected_output(const MachineDevices& devices);

}  // namespace contourd::ctl
