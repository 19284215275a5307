// The machine of real devices: a stepped axis, a display output, and a projector, a light line or both. Opens
// the devices that it finds and searches for the missing ones every few seconds. A missing device keeps the
// machine from printing (why_not_ready()), but does not keep the others from being made safe: the light is
// opened first, and is the first to be turned off at the end.
//
// Light off, screen black and motor still from the construction on, and after the destruction. A projector
// that is found switched on is turned off. Event loop's thread only.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hw/absent_devices.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/gpio_light_line.hpp"
#include "hw/machine.hpp"
#include "hw/real_machine_config.hpp"
#include "hw/watchdog/light_watchdog.hpp"
#include "hw/watchdog/watched_projector.hpp"

namespace contourd {

class RealMachine final : public Machine {
 public:
  // The clock (of CLOCK_MONOTONIC), the watcher and the light watchdog must outlive the machine. Blocks for
  // as long as the devices take to open, usually a second. A missing device is not an error: see
  // why_not_ready().
  RealMachine(Clock& clock, DescriptorWatcher& watcher, LightWatchdog& watchdog,
              const RealMachineConfig& config);
  // Functions that open the devices; an empty one opens the device of the configuration.
  struct Openers {
    std::function<std::unique_ptr<ZAxis>()> axis = {};
    std::function<std::unique_ptr<GpioLightLine>()> light = {};
    std::function<std::unique_ptr<Projector>()> projector = {};
    std::function<std::unique_ptr<MaskDisplay>()> display = {};
  };
  RealMachine(Clock& clock, DescriptorWatcher& watcher, LightWatchdog& watchdog, RealMachineConfig config,
              Openers openers);
  ~RealMachine() override;

  [[nodiscard]] ZAxis& z_axis() override;
  [[nodiscard]] MaskDisplay& display() override;
  [[nodiscard]] Projector& projector() override { return watched_; }
  // Also reports each missing device that is found (as a Recovery that names the device).
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  [[nodiscard]] std::string why_not_ready() const override;
  // Saves no masks.
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  // Return a sentence for each device that is present, and for each problem that a user should know of
  // although the machine works.
  [[nodiscard]] std::vector<std::string> description() const;
  [[nodiscard]] std::vector<std::string> warnings() const;

  static constexpr Duration kSearchInterval{std::chrono::seconds{5}};
  // The pause before the first search after a serial line or a light line was lost.
  static constexpr Duration kFirstSearch{std::chrono::milliseconds{500}};

 private:
  // A sentence for each missing device; empty if the device is present, or not configured.
  struct Missing {
    std::string light, projector, display, axis;
    [[nodiscard]] bool any() const {
      return !light.empty() || !projector.empty() || !display.empty() || !axis.empty();
    }
  };

  struct Found {
    std::string device;
    std::vector<std::string> warnings;
  };

  void add_openers();
  // Opens the missing devices, and returns those that were found.
  std::vector<Found> open_missing();
  bool open_light();
  bool find_projector();
  // Hands the light watchdog the descriptors with which the light can be turned off.
  void offer_light_paths();
  void combine_projector();
  [[nodiscard]] bool display_lost() const { return display_ && !display_->why_not_ready().empty(); }
  void search_after(Duration pause) {
    search_ = clock_.call_after(pause, [this] { search(); });
  }
  void search();
  void tell(const MachineEvent& event);
  void note_losses(const std::string& what);
  [[nodiscard]] std::string light_description() const {
    return "light: line " + config_.light->line + " of " + config_.light->chip;
  }

  Clock& clock_;
  DescriptorWatcher& watcher_;
  LightWatchdog& watchdog_;
  RealMachineConfig config_;
  Openers openers_;
  std::function<void(const MachineEvent&)> on_event_;
  Missing missing_;
  std::unique_ptr<Timer> search_;

  AbsentLightLine no_light_;
  AbsentProjector no_projector_;
  AbsentDisplay no_display_;
  AbsentAxis no_axis_;
  // Destroyed in reverse order: light, picture, motor.
  std::unique_ptr<ZAxis> axis_;
  std::unique_ptr<MaskDisplay> display_;
  std::unique_ptr<GpioLightLine> light_;
  std::unique_ptr<Projector> projector_;
  std::unique_ptr<Projector> combined_;  // the light line, with the projector if there is one
  WatchedProjector watched_;
};

}  // namespace contourd
