// A printer made of arithmetic: an axis with travel, a limit switch and steps, a display that writes its
// masks as PNG files, a projector with warm-up and replies that may come late or never. The default machine,
// so that the whole daemon runs anywhere. Not thread-safe.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hw/machine.hpp"

namespace contourd {

struct SimulatedAxisConfig {
  Nanometers travel{160'000'000};
  double microsteps_per_mm = 800.0;  // positions are whole steps
  MillimetersPerSecond homing_speed{5.0};
  MillimetersPerSecondSquared acceleration{25.0};
  Nanometers start_height{40'000'000};  // where the plate stands at power-up, unknown to the daemon

  enum class Switch { Works, StuckOpen, StuckClosed };
  Switch limit_switch = Switch::Works;
};

struct SimulatedDisplayConfig {
  Pixels width{1920};
  Pixels height{1080};
  Duration frame{16'666'667};  // one refresh: a mask is on the screen at the next multiple of it
  std::optional<std::filesystem::path> masks;  // each job's masks go to a folder of its own in here
  std::optional<int> lost_after_frames;        // it is unplugged, once, after that many masks
  std::optional<Duration> back_after;          // and plugged in again this much later
};

struct SimulatedProjectorConfig {
  Duration warm_up{std::chrono::seconds{5}};
  Duration reply{std::chrono::milliseconds{20}};
  Duration timeout{std::chrono::seconds{2}};  // after which a projector that does not answer is given up
  std::optional<int> silent_after_commands;   // it answers that many commands, then never again
};

struct SimulatedPrinterConfig {
  SimulatedAxisConfig axis;
  SimulatedDisplayConfig display;
  SimulatedProjectorConfig projector;
  std::optional<Duration> lid_opened_after_light;  // once, when the light has been on for that long in all
  Duration lid_open_for{std::chrono::seconds{10}};
};

class SimulatedPrinter final : public Machine {
 public:
  // The clock must outlive the printer.
  SimulatedPrinter(Clock& clock, const SimulatedPrinterConfig& config);
  ~SimulatedPrinter() override;

  [[nodiscard]] ZAxis& z_axis() override;
  [[nodiscard]] MaskDisplay& display() override;
  [[nodiscard]] Projector& projector() override;
  void on_disturbance(std::function<void(const Disturbance&)> call) override;
  [[nodiscard]] std::string hindrance() const override;
  std::optional<std::filesystem::path> begin_job(std::string_view name) override;

  // What a person does to the machine. Each disturbs it from within the call.
  void open_lid();
  void close_lid();
  void unplug_display();
  void plug_display();
  void press_emergency_stop();  // it is let go again at once

  // What a person looking at the machine would see.
  [[nodiscard]] bool light_is_on() const;
  [[nodiscard]] bool screen_is_black() const;
  // Masks shown since begin_job().
  [[nodiscard]] int masks_shown() const;

 private:
  class Screen;
  class Lamp;

  void disturb(Disturbance::Kind kind, const std::string& what, bool owner_decides = false);
  void light_switched(bool on);

  Clock& clock_;
  SimulatedPrinterConfig config_;
  std::function<void(const Disturbance&)> disturbed_;
  bool lid_open_ = false;
  std::optional<Duration> light_until_lid_opens_;
  TimePoint light_on_at_{};
  std::unique_ptr<Timer> lid_, plug_;
  std::unique_ptr<ZAxis> axis_;
  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Lamp> lamp_;
};

}  // namespace contourd
