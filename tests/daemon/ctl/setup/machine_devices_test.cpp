#include "daemon/ctl/setup/machine_devices.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd::ctl;
namespace fs = std::filesystem;

namespace {

void link(const TemporaryFolder& folder, const fs::path& from, const fs::path& to) {
  fs::create_directories((folder.path() / from).parent_path());
  fs::create_symlink(to, folder.path() / from);
}

}  // namespace

TEST_CASE("Outputs are found by their connectors, with each size once and the preferred size first") {
  const TemporaryFolder folder;
  folder.write("proc/device-tree/model", std::string("Raspberry Pi 4 Model B\0", 23));
  folder.write("sys/class/drm/card1-HDMI-A-1/status", "disconnected\n");
  folder.write("sys/class/drm/card1-HDMI-A-1/modes", "");
  folder.write("sys/class/drm/card1-HDMI-A-2/status", "connected\n");
  folder.write("sys/class/drm/card1-HDMI-A-2/modes", "1920x1080\n1920x1080\n1280x720\n");
  folder.write("sys/class/drm/card1-Writeback-1/status", "unknown\n");
  folder.write("sys/class/drm/card1/dev", "226:1\n");
  const MachineDevices devices = find_devices(folder.path());
  CHECK(devices.model == "Raspberry Pi 4 Model B");
  REQUIRE(devices.outputs.size() == 2);
  CHECK_FALSE(devices.outputs[0].connected);
  const FoundOutput* const output = connected_output(devices);
  REQUIRE(output != nullptr);
  CHECK(output->name == "HDMI-A-2");
  CHECK(output->modes == std::vector<std::string>{"1920x1080", "1280x720"});
}

TEST_CASE("A serial port has its permanent name, and a port without hardware is ignored") {
  const TemporaryFolder folder;
  link(folder, "dev/serial/by-id/usb-FTDI_1-if00-port0", "../../ttyUSB0");
  for (const char* tty : {"ttyUSB0", "ttyAMA0", "ttyS0"})
    link(folder, fs::path("sys/class/tty") / tty / "device/driver", "/bus/driver");
  folder.write("sys/class/tty/ttyS0/type", "0\n");
  folder.write("sys/class/tty/ttyAMA0/type", "32\n");
  folder.write("sys/class/tty/tty1/dev", "4:1\n");
  // A dangling link does not count as a driver.
  fs::create_directories(folder.path() / "bus/driver");
  for (const char* tty : {"ttyUSB0", "ttyAMA0", "ttyS0"}) {
    const fs::path driver = folder.path() / "sys/class/tty" / tty / "device/driver";
    fs::remove(driver);
    fs::create_symlink(folder.path() / "bus/driver", driver);
  }
  const MachineDevices devices = find_devices(folder.path());
  REQUIRE(devices.ports.size() == 2);
  CHECK(devices.ports[0].path == "/dev/serial/by-id/usb-FTDI_1-if00-port0");
  CHECK(devices.ports[0].tty == "ttyUSB0");
  CHECK(devices.ports[1].path == "/dev/ttyAMA0");
}

TEST_CASE("Each missing kind of device has a line with advice") {
  const TemporaryFolder folder;
  const auto lines = describe(find_devices(folder.path()));
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].starts_with("GPIO: none. "));
  CHECK(lines[1].starts_with("Display: none. "));
  CHECK(lines[2].starts_with("Serial port: none. "));
}

TEST_CASE("Names of devices are made printable") {
  MachineDevices devices;
  devices.chips = {{"gpiochip0", "bad\x1b[2J", {{"", std::nullopt}, {"", "other"}}}};
  devices.outputs = {{"HDMI-A-1", true, {"1920x1080", "640x480"}}};
  devices.ports = {{"/dev/serial/by-id/\n", "ttyUSB0"}};
  const auto lines = describe(devices);
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "GPIO: gpiochip0 (bad?[2J), 2 lines, 1 of them in use");
  CHECK(lines[1] == "Display: HDMI-A-1, connected, 1920x1080 and 1 other sizes");
  for (const std::string& line : lines)
    CHECK(line.find_first_of("\x1b\n") == std::string::npos);
}

TEST_CASE("The header's chip is found by its label, whatever its number") {
  MachineDevices devices;
  CHECK(header_chip(devices) == nullptr);
  devices.chips = {{"gpiochip0", "gpio-brcmstb@107d508500", {}}, {"gpiochip4", "pinctrl-rp1", {}}};
  CHECK(header_chip(devices)->name == "gpiochip4");
  CHECK(find_chip(devices, "/dev/gpiochip4") == header_chip(devices));
  CHECK(find_chip(devices, "pinctrl-rp1") == header_chip(devices));
  CHECK(find_chip(devices, "gpiochip1") == nullptr);
  devices.chips.pop_back();
  CHECK(header_chip(devices)->name == "gpiochip0");
}
