#include "hw/serial/serial_port.hpp"

#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
  throw HardwareError("the serial port " + name + " " + why);
}

std::string text_of(int error) {
  return std::generic_category().message(error);
}

// Returns another process that has the device open, as far as the system lets us see: "agetty (process 612)".
std::optional<std::string> other_user_of(const fs::path& device) {
  std::error_code error;
  const std::string self = std::to_string(::getpid());
  for (fs::directory_iterator process("/proc", error), end; !error && process != end;
       process.increment(error)) {
    const std::string id = process->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos || id == self) continue;
    std::error_code hidden;  // the process is another user's, or has just ended
    for (fs::directory_iterator fd(process->path() / "fd", hidden), last; !hidden && fd != last;
         fd.increment(hidden)) {
      std::error_code gone;
      if (fs::read_symlink(fd->path(), gone) != device) continue;
      std::string command;
      std::getline(std::ifstream(process->path() / "comm"), command);
      return command.append(" (process ").append(id).append(")");
    }
  }
  return std::nullopt;
}

std::string in_use(const fs::path& device) {
  const auto user = other_user_of(device);
  return "is in use by " + user.value_or("another program") + "; a projector's line cannot be shared";
}

// Returns why sp_open() failed, by errno.
std::string open_failure(int error, const fs::path& device) {
  if (error == EACCES || error == EPERM)
    return "may not be opened: permission denied; add the user to the group \"dialout\" and log in again";
  if (error == EBUSY) return in_use(device);
  if (error == EIO || error == ENXIO || error == ENODEV)
    return "has no device connected: " + text_of(error) + "; " + serial_ports_there_are();
  return "cannot be opened: " + text_of(error);
}

fs::path device_of(const std::string& path) {
  std::error_code error;
  fs::path device = fs::canonical(path, error);
  if (error == std::errc::no_such_file_or_directory)
    refuse(path, "does not exist; " + serial_ports_there_are());
  if (error) refuse(path, "cannot be opened: " + error.message());
  if (!fs::is_character_file(device, error))
    refuse(path, "is not a serial port; " + serial_ports_there_are());
  return device;
}

}  // namespace

std::string serial_ports_there_are() {
  sp_port** ports = nullptr;
  if (sp_list_ports(&ports) != SP_OK) return "the existing serial ports cannot be listed";
  std::string text;
  for (sp_port** port = ports; *port != nullptr; ++port)
    text += (text.empty() ? "existing serial ports: " : ", ") + std::string(sp_get_port_name(*port));
  sp_free_port_list(ports);
  return text.empty() ? "no serial port exists" : text;
}

void SerialPort::Closer::operator()(sp_port* port) const {
  sp_close(port);
  sp_free_port(port);
}

SerialPort::SerialPort(const std::string& path, int baud, DescriptorWatcher& watcher) : name_(path) {
  const fs::path device = device_of(path);
  sp_port* port = nullptr;
  if (sp_get_port_by_name(device.c_str(), &port) != SP_OK)
    refuse(name_, "is not a usable serial port; " + serial_ports_there_are());
  port_.reset(port);
  errno = 0;
  if (sp_open(port, SP_MODE_READ_WRITE) != SP_OK) refuse(name_, open_failure(errno, device));
  if (sp_get_port_handle(port, &descriptor_) != SP_OK) refuse(name_, "has no descriptor");
  claim(device);
  set_up(baud);
  watch_ = watcher.when_readable(descriptor_, [this] { read(); });
}

SerialPort::~SerialPort() = default;

// Claims the port for this process. TIOCEXCL keeps later programs out, but not root's; the lock keeps out
// programs that check it (and a second contourd). A program that opened the port earlier is affected by
// neither, so it is searched for.
void SerialPort::claim(const std::string& device) {
  if (const auto user = other_user_of(device)) refuse(name_, in_use(device));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) refuse(name_, in_use(device));
    refuse(name_, "cannot be locked: " + text_of(errno));
  }
  if (::ioctl(descriptor_, TIOCEXCL) != 0) refuse(name_, "cannot be opened exclusively: " + text_of(errno));
}

void SerialPort::set_up(int baud) {
  sp_port* port = port_.get();
  errno = 0;
  if (sp_set_bits(port, 8) != SP_OK || sp_set_parity(port, SP_PARITY_NONE) != SP_OK ||
      sp_set_stopbits(port, 1) != SP_OK || sp_set_flowcontrol(port, SP_FLOWCONTROL_NONE) != SP_OK)
    refuse(name_, "cannot be set to 8 data bits, no parity, 1 stop bit: " + text_of(errno));
  if (sp_set_baudrate(port, baud) != SP_OK)
    refuse(name_, "cannot be set to " + std::to_string(baud) + " baud: " + text_of(errno));
  sp_flush(port, SP_BUF_BOTH);  // discards bytes that an earlier user left unread
}

bool SerialPort::write(std::string_view bytes) noexcept {
  if (descriptor_ < 0) return false;
  // The kernel's buffer holds 4096 bytes: if the bytes do not fit in at once, none are leaving the port.
  return sp_nonblocking_write(port_.get(), bytes.data(), bytes.size()) == static_cast<int>(bytes.size());
}

void SerialPort::write_and_wait(std::string_view bytes, Duration pause) noexcept {
  if (!write(bytes)) return;
  constexpr auto kStep = std::chrono::milliseconds{5};
  for (auto waited = Duration{0}; waited < std::chrono::seconds{1} && sp_output_waiting(port_.get()) > 0;
       waited += kStep)
    std::this_thread::sleep_for(kStep);
  std::this_thread::sleep_for(pause);
}

void SerialPort::read() {
  std::array<char, 256> bytes;
  const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
  if (count > 0) {
    if (listener_.bytes) listener_.bytes(std::string_view(bytes.data(), static_cast<std::size_t>(count)));
    return;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count < 0) return lose(text_of(errno));
  // A read of no bytes means just that (termios(3), MIN and TIME 0), or that the tty was hung up because its
  // adapter was unplugged.
  pollfd state{descriptor_, POLLIN, 0};
  if (::poll(&state, 1, 0) == 1 && (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0)
    lose("it was unplugged or hung up");
}

void SerialPort::lose(const std::string& why) {
  watch_.reset();
  descriptor_ = -1;
  if (listener_.lost) listener_.lost("the serial port " + name_ + " was lost: " + why);
}

}  // namespace contourd
