// GPIO lines by the kernel, found as their owner names them. What goes wrong is a HardwareError whose
// sentence names the chip and the line, who holds it, and what there is instead.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_line_config.hpp"
#include "hw/gpio/gpiod.hpp"
#include "hw/gpio/line_descriptor.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {

// Holds a line as an output. Any one thread at a time, but for cut(); destroying it makes the line inactive
// and gives it back.
class GpioOutput final : public CuttableLine {
 public:
  // Takes the line and sets its level in one act of the kernel: there is no moment at another level. `use` is
  // the word that others are shown for it ("step"). Throws HardwareError.
  GpioOutput(const GpioLineConfig& config, std::string_view use, bool active);
  ~GpioOutput() override;

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
  std::string name;                     // empty when it has none
  std::optional<std::string> consumer;  // who holds the line; nothing when it is free
  bool output = false;
};

// What the kernel says of a line; does not take it, changes nothing. Throws HardwareError.
[[nodiscard]] GpioLineReport report_line(const GpioLineConfig& config,
                                         const std::filesystem::path& devices = "/dev");

// "line 17 (GPIO17) of gpiochip0 (pinctrl-bcm2711), an input, free"
[[nodiscard]] std::string describe(const GpioLineReport& report);

}  // namespace contourd
