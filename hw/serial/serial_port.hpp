// A serial port (libserialport): 8 data bits, no parity, 1 stop bit, no flow control, for this program alone.
// Event loop's thread only. Closing it leaves the line as it is.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hw/descriptor_watcher.hpp"
#include "hw/serial/byte_channel.hpp"

struct sp_port;

namespace contourd {

class SerialPort final : public ByteChannel {
 public:
  // Opens `path`, a device ("/dev/ttyUSB0") or a link to one ("/dev/serial/by-id/..."). Throws HardwareError
  // if there is no such port, it cannot be opened or set up, or another program uses it. The watcher must
  // outlive the port.
  SerialPort(const std::string& path, int baud, DescriptorWatcher& watcher);
  ~SerialPort() override;

  [[nodiscard]] const std::string& name() const override { return name_; }
  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] bool write(std::string_view bytes) noexcept override;
  // Returns the port's descriptor; -1 if the port is lost.
  [[nodiscard]] int descriptor() const noexcept override { return descriptor_; }
  void write_and_wait(std::string_view bytes, Duration pause) noexcept override;

 private:
  struct Closer {
    void operator()(sp_port* port) const;
  };

  void claim(const std::string& device);
  void set_up(int baud);
  void read();
  void lose(const std::string& why);

  std::string name_;
  std::unique_ptr<sp_port, Closer> port_;
  int descriptor_ = -1;
  Listener listener_;
  std::unique_ptr<DescriptorWatcher::Watch> watch_;
};

// Lists the serial ports for messages: "existing serial ports: /dev/ttyS0, /dev/ttyUSB0", or "no serial port
// exists".
[[nodiscard]] std::string serial_ports_there_are();

}  // namespace contourd
