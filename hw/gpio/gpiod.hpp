// A wrapper for the part of libgpiod that contourd needs, for versions 1.6 (Debian 12; gpiod_1.cpp) and 2
// (Debian 13; gpiod_2.cpp); the build selects the source for the installed library. Throws std::system_error
// with the kernel's errno and no text; gpio_lines.hpp makes the sentences. One thread at a time.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_axis_config.hpp"

struct gpiod_chip;

namespace contourd {

struct GpiodLineInfo {
  std::string name;  // empty if the line has none
  std::optional<std::string>
      consumer;  // the holder of the line; nullopt if the line is free, "" if the holder gives no name
  bool output = false;
};

// An open GPIO chip.
class GpiodChip {
 public:
  explicit GpiodChip(const std::filesystem::path& device);
  GpiodChip(const GpiodChip&) = delete;
  GpiodChip& operator=(const GpiodChip&) = delete;
  ~GpiodChip();

  [[nodiscard]] const std::string& name() const { return name_; }    // "gpiochip0"
  [[nodiscard]] const std::string& label() const { return label_; }  // "pinctrl-bcm2711"
  [[nodiscard]] unsigned line_count() const { return line_count_; }
  [[nodiscard]] GpiodLineInfo line_info(unsigned offset) const;

 private:
  friend class GpiodLine;
  gpiod_chip* chip_;
  std::string name_, label_;
  unsigned line_count_ = 0;
};

// A line requested from its chip; the destructor releases it. May outlive the GpiodChip.
class GpiodLine {
 public:
  struct Request {
    std::filesystem::path device;  // the chip's device
    unsigned offset = 0;
    bool active_low = false;
    std::string consumer;
  };

  [[nodiscard]] static GpiodLine output(const Request& request, bool active);
  // Requests an input with events for both edges, stamped with CLOCK_MONOTONIC.
  [[nodiscard]] static GpiodLine input(const Request& request, LineBias bias);
  GpiodLine(GpiodLine&&) noexcept;
  ~GpiodLine();

  [[nodiscard]] bool set(bool active) noexcept;
  // Returns an output's descriptor, for set_line_inactive(). The line owns it. -1 if the library has no call
  // for it and it is not found in /proc.
  [[nodiscard]] int descriptor() const noexcept;
  // Returns the level, or nullopt if the kernel refuses.
  [[nodiscard]] std::optional<bool> get() noexcept;
  // Returns an input's descriptor, which is non-blocking.
  [[nodiscard]] int event_descriptor() const noexcept;
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept;

 private:
  struct Handle;
  explicit GpiodLine(std::unique_ptr<Handle> handle);
  std::unique_ptr<Handle> handle_;
};

}  // namespace contourd
