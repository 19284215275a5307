// A simulated printer: an axis with travel, a limit switch and steps, a display that saves its masks as PNG
// files, a projector with a warm-up and with replies that may come late or never. The default machine, so
// that the whole daemon runs anywhere. Not thread-safe.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "hw/machine.hpp"
#include "hw/simulated_printer_config.hpp"

namespace contourd {

class SimulatedAxis;

class SimulatedPrinter final : public Machine {
 public:
  // The clock must outlive the printer.
  SimulatedPrinter(Clock& clock, const SimulatedPrinterConfig& config);
  ~SimulatedPrinter() override;

  [[nodiscard]] ZAxis& z_axis() override;
  [[nodiscard]] MaskDisplay& display() override;
  [[nodiscard]] Projector& projector() override;
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  [[nodiscard]] std::string why_not_ready() const override;
  std::optional<std::filesystem::path> begin_job(std::string_view name) override;

  // Actions of a person at the machine. Each reports its machine event from within the call.
  void open_lid();
  void close_lid();
  void unplug_display();
  void plug_display();
  void press_emergency_stop();  // and released again at once

  // State that a person looking at the machine would see.
  [[nodiscard]] bool light_is_on() const;
  [[nodiscard]] bool screen_is_black() const;
  // Masks shown since begin_job().
  [[nodiscard]] int masks_shown() const;

 private:
  class Recording;
  class Screen;
  class Lamp;

  void report(MachineEvent::Kind kind, const std::string& what, bool needs_user = false) {
    if (on_event_) on_event_({kind, what, needs_user});
  }
  void light_switched(bool on);
  void cure();

  Clock& clock_;
  SimulatedPrinterConfig config_;
  std::function<void(const MachineEvent&)> on_event_;
  bool lid_open_ = false;
  std::optional<Duration> light_until_lid_opens_;
  TimePoint light_on_at_{};
  std::unique_ptr<Timer> lid_, plug_;
  std::unique_ptr<SimulatedAxis> axis_;
  std::unique_ptr<Recording> recording_;
  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Lamp> lamp_;
};

}  // namespace contourd
