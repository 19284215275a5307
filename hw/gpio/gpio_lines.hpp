// The kernel's GPIO lines, found by the chip and line of the config. Errors are HardwareErrors whose sentence
// names the chip and the line, the program that holds the line, and the chips or lines that exist.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/gpiod.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {

// Makes an output line inactive by the kernel's descriptor alone, for callers that may not use the library's
// object for the line: another thread, or another process that has inherited the descriptor. Makes one or two
// kernel calls, which any thread or process may make at any time. Works
// for both kernel interfaces: libgpiod 1.6 uses the first, libgpiod 2 the second. True if the line is
// inactive now; false also if the descriptor is not a line. Neither allocates nor locks.
[[nodiscard]] bool set_line_inactive(int descriptor) noexcept;

// Holds a line as an output. One thread at a time, except cut(). The destructor makes the line inactive and
// releases it.
class GpioOutput final : public CuttableLine {
 public:
  // Requests the line and sets its level in one call of the kernel, so the line never has another level.
  // `use` is the name that other programs see for it ("step"). Throws HardwareError.
  GpioOutput(const GpioLineConfig& config, std::string_view use, bool active);
  ~GpioOutput() override { (void)line_.set(false); }

  [[nodiscard]] bool set(bool active) noexcept override { return line_.set(active); }
  [[nodiscard]] bool cut() noexcept override { return set_line_inactive(line_.descriptor()); }
  [[nodiscard]] int descriptor() const noexcept override { return line_.descriptor(); }

 private:
  GpiodLine line_;
};

// Holds a line as an input with events for both edges.
class GpioInput final : public InputLine {
 public:
  // Throws HardwareError.
  GpioInput(const GpioLineConfig& config, LineBias bias, std::string_view use);

  [[nodiscard]] int descriptor() const noexcept override { return line_.event_descriptor(); }
  [[nodiscard]] std::optional<bool> level() noexcept override { return line_.get(); }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept override {
    return line_.read_edges(edges);
  }

 private:
  GpiodLine line_;
};

struct GpioLineReport {
  std::string chip;   // "gpiochip0"
  std::string label;  // "pinctrl-bcm2711"
  unsigned offset = 0;
  std::string name;                     // empty if the line has none
  std::optional<std::string> consumer;  // the holder of the line; nullopt if the line is free
  bool output = false;
};

// Returns the kernel's description of a line without requesting or changing it. Throws HardwareError.
[[nodiscard]] GpioLineReport report_line(const GpioLineConfig& config,
                                         const std::filesystem::path& devices = "/dev");

// "line 17 (GPIO17) of gpiochip0 (pinctrl-bcm2711), an input, free"
[[nodiscard]] std::string describe(const GpioLineReport& report);

}  // namespace contourd
