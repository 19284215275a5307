// libgpiod as far as contourd needs it, the same for its versions 1.6 (Debian 12; gpiod_1.cpp) and 2 (Debian
// 13; gpiod_2.cpp): the build takes the source that fits the installed library. Throws std::system_error with
// the kernel's errno and no words of its own; gpio_lines.hpp makes the sentences. One thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_line_config.hpp"

struct gpiod_chip;

namespace contourd {

struct GpiodLineInfo {
  std::string name;  // empty when it has none
  std::optional<std::string>
      consumer;  // who holds the line; nothing when it is free, "" when it does not say
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

// A line taken from its chip; given back when destroyed. Outlives the GpiodChip.
class GpiodLine {
 public:
  struct Request {
    std::filesystem::path device;  // of the chip
    unsigned offset = 0;
    bool active_low = false;
    std::string consumer;
  };

  [[nodiscard]] static GpiodLine output(const Request& request, bool active);
  // With events for both edges, stamped with CLOCK_MONOTONIC.
  [[nodiscard]] static GpiodLine input(const Request& request, LineBias bias);
  GpiodLine(GpiodLine&&) noexcept;
  ~GpiodLine();

  [[nodiscard]] bool set(bool active) noexcept;
  // Of an output, for line_descriptor.hpp; the line's. -1 where the library does not tell it and the kernel
  // has no /proc to look it up in.
  [[nodiscard]] int descriptor() const noexcept;
  // Nothing when the kernel refuses.
  [[nodiscard]] std::optional<bool> get() noexcept;
  // Of an input; not blocking.
  [[nodiscard]] int event_descriptor() const noexcept;
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept;

 private:
  struct Handle;
  explicit GpiodLine(std::unique_ptr<Handle> handle);
  std::unique_ptr<Handle> handle_;
};

}  // namespace contourd
