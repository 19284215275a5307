// Looks at a real machine's devices and tells what it finds. Moves nothing, lights nothing, sets no mode; a
// projector is asked how it is. Event loop's thread only.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/gpio_lines.hpp"
#include "hw/gpio/wake_up_latency.hpp"
#include "hw/projector.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

struct HardwareFinding {
  std::string device;  // "limit switch"
  bool good = false;
  std::string what;      // one sentence
  bool warning = false;  // good, but the owner should know
};

class HardwareCheck {
 public:
  using Found = std::function<void(const HardwareFinding&)>;

  // How late a thread of that priority wakes, so many times a second.
  using MeasureWakeUpLatency = std::function<WakeUpLatency(double rate, int priority)>;

  // Clock and watcher must outlive it.
  HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config);
  HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config,
                MeasureWakeUpLatency measure);

  // Calls `found` for every device, `done` after the last. Blocks for some milliseconds a device, and for a
  // second and a half to measure how late threads wake; the projector's answer comes later, from the event
  // loop.
  void run(Found found, std::function<void()> done);

 private:
  void check_line(const std::string& device, const GpioLineConfig& line);
  void check_input(const std::string& device, const GpioInputConfig& input, const char* active,
                   const char* inactive);
  void check_axis();
  void check_speed();
  void check_display();
  void check_projector();
  void report(const std::string& device, bool good, const std::string& what, bool warning = false) {
    found_({device, good, what, warning});
  }

  Clock& clock_;
  DescriptorWatcher& watcher_;
  RealMachineConfig config_;
  MeasureWakeUpLatency measure_;
  Found found_;
  std::function<void()> done_;
  std::map<std::pair<std::string, unsigned>, std::string> users_;  // of lines: chip and number, device
  std::unique_ptr<Projector> projector_;
  std::unique_ptr<Timer> end_;
};

}  // namespace contourd
