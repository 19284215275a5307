#include "hw/serial/serial_port.hpp"

#include <functional>
#include <string>

#include "hw/hardware_error.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

// A serial port of its own no build machine has, and libserialport refuses ptys: here is only what goes wrong
// before one is open. The tests in a virtual machine have a null-modem pair.
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

TEST_CASE("a file or a device that is no serial port is told from one that is missing") {
  const testing::TemporaryFolder folder;
  const std::string file = folder.write("port", "");
  CHECK(refusal(file) == "the serial port " + file + " is no serial port; " + serial_ports_there_are());
  CHECK(refusal("/dev/null") ==
        "the serial port /dev/null is no serial port that can be used; " + serial_ports_there_are());
}
