// The machine of real devices: a stepped axis, a display output, and a projector of its own kind or behind a
// light line. Opens what it can; what is not there is looked for every few seconds, and until then stands in
// the way (why_not_ready()) without keeping the rest from being safe: the light comes first and goes last.
//
// Light off, black and motor still from the construction on and when it goes. A projector that is found on is
// turned off. Event loop's thread only.
//
// It has more members than most: each device, and what stands in for it.
#pragma once

#include <memory>
#include <string>
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
  // Clock (of CLOCK_MONOTONIC), watcher and light watchdog must outlive the machine. Blocks for as long as
  // the devices take, a second as a rule. A device that is not there is no error: see why_not_ready().
  RealMachine(Clock& clock, DescriptorWatcher& watcher, LightWatchdog& watchdog,
              const RealMachineConfig& config);
  // Ways to open devices; without one, that of the configuration.
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
  [[nodiscard]] Projector& projector() override;
  // Also when a device that was missing has come (Recovery, with what was found).
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  [[nodiscard]] std::string why_not_ready() const override;
  // Keeps nothing of what it shows.
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  // A sentence for each device that is there, and for what an owner should know though it works.
  [[nodiscard]] std::vector<std::string> description() const;
  [[nodiscard]] std::vector<std::string> warnings() const;

  static constexpr Duration kSearchInterval{std::chrono::seconds{5}};
  // After a serial line was lost, or a light line.
  static constexpr Duration kFirstSearch{std::chrono::milliseconds{500}};

 private:
  // A sentence for each device that is not there; empty where it is, or is not wanted.
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
  // What it has found now that was missing before.
  std::vector<Found> open_missing();
  bool open_light();
  bool find_projector();
  // To the light watchdog, what the light can be turned off by.
  void offer_light_paths();
  void combine_projector();
  [[nodiscard]] bool display_lost() const { return display_ && !display_->why_not_ready().empty(); }
  void search_after(Duration pause);
  void search();
  void tell(const MachineEvent& event);
  void note_losses(const std::string& what);
  [[nodiscard]] std::string light_words() const;

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
  // Destroyed from the last to the first: light, picture, motor.
  std::unique_ptr<ZAxis> axis_;
  std::unique_ptr<MaskDisplay> display_;
  std::unique_ptr<GpioLightLine> light_;
  std::unique_ptr<Projector> projector_;
  std::unique_ptr<Projector> combined_;  // of the light line, and of the projector where there is one
  WatchedProjector watched_;
};

}  // namespace contourd
