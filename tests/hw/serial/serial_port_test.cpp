#include "hw/serial/serial_port.hpp"

#include <functional>
#include <string>

#include "hw/hardware_error.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

// Build machines have no serial port to themselves, and libserialport refuses ptys: these tests only cover
// failures before a port is open. The tests in a virtual machine have a null-modem pair.
namespace {

class NoWatcher final : public DescriptorWatcher {
 public:
  std::unique_ptr<Watch> when_readable(int, std::function<void()>) override {
    return std::make_unique<Watch>();
  }
};

std::string refusal(const std::string& path) {
  NoWatcher watcher;
  try {
    const SerialPort port(path, 9600, watcher);
  } catch (const HardwareError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a serial port that does not exist is named, with those that do") {
  CHECK(refusal("/dev/ttyNone7") ==
        "the serial port /dev/ttyNone7 does not exist; " + serial_ports_there_are());
}

TEST_CASE("a file or a device that is not a serial port is distinguished from a missing one") {
  const testing::TemporaryFolder folder;
  const std::string file = folder.write("port", "");
  CHECK(refusal(file) == "the serial port " + file + " is not a serial port; " + serial_ports_there_are());
  CHECK(refusal("/dev/null") ==
        "the serial port /dev/null is not a usable serial port; " + serial_ports_there_are());
}
