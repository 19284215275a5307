// The light on a GPIO line. Event loop's thread only, except cut(), which bypasses the library's object for
// the line and calls the kernel.
#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hw/clock.hpp"
#include "hw/gpio/gpio_lines.hpp"
#include "hw/light_line.hpp"
#include "hw/machine.hpp"

namespace contourd {

class GpioLightLine final : public LightLine, public LightCutoff {
 public:
  // Takes the line with the light off. Throws HardwareError. The clock must outlive this object.
  GpioLightLine(const GpioLineConfig& config, Clock& clock);
  // Uses an existing line; `words` is its name in messages: "line 24 of gpiochip0".
  GpioLightLine(std::unique_ptr<CuttableLine> line, std::string words, Clock& clock);

  // Sets the callback for the fault that the line cannot be turned off. The fault is reported once; turning
  // off is retried until it works.
  void on_event(std::function<void(const MachineEvent&)> call) { on_event_ = std::move(call); }
  // Throws HardwareError also as long as the line cannot be turned off.
  void on() override;
  void off() noexcept override;
  void cut(TimePoint now) noexcept override;
  void release() noexcept override { cut_at_ = cut_by_ = kNotCut; }
  [[nodiscard]] std::optional<TimePoint> cut_at() const override { return time_of(cut_at_); }
  [[nodiscard]] std::optional<TimePoint> cut_by() const override { return time_of(cut_by_); }
  // Returns the descriptor for another process that is to turn the light off. The line owns it; -1 if it has
  // none.
  [[nodiscard]] int descriptor() const noexcept { return line_->descriptor(); }
  [[nodiscard]] std::string refusal() const override { return refuses_off_ ? cannot_be_set() : ""; }

 private:
  [[nodiscard]] std::string cannot_be_set() const {
    return "the light's " + words_ + " cannot be set: the kernel refuses";
  }
  [[noreturn]] void refuse_interlocked() const;
  void insist();

  std::string words_;
  Clock& clock_;
  std::unique_ptr<CuttableLine> line_;
  static constexpr Duration::rep kNotCut = std::numeric_limits<Duration::rep>::min();
  [[nodiscard]] static std::optional<TimePoint> time_of(Duration::rep time);
  std::atomic<Duration::rep> cut_at_{kNotCut}, cut_by_{kNotCut};
  std::function<void(const MachineEvent&)> on_event_;
  bool refuses_off_ = false;
  bool refusal_reported_ = false;
  std::unique_ptr<Timer> again_;
};

}  // namespace contourd
