// Checks a real machine's devices and reports what it finds. Moves nothing, lights nothing, sets no display
// mode; a projector is asked for its status. Event loop's thread only.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

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
  bool warning = false;  // good, but the user should know
};

class HardwareCheck {
 public:
  using Found = std::function<void(const HardwareFinding&)>;

  // Measures how late a thread of `priority` wakes when it sleeps `rate` times a second.
  using MeasureWakeUpLatency = std::function<WakeUpLatency(double rate, int priority)>;

  // The clock and the watcher must outlive the check.
  HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config);
  HardwareCheck(Clock& clock, DescriptorWatcher& watcher, RealMachineConfig config,
                MeasureWakeUpLatency measure);

  // Calls `found` for every device, then `done`. Blocks for some milliseconds per device, and for 1.5 s to
  // measure how late threads wake; the projector's result comes later, from the event loop.
  void run(Found found, std::function<void()> done);

 private:
  void check_line(const std::string& device, const GpioLineConfig& line,
                  const std::function<std::string()>& level = {});
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
  std::map<std::pair<std::string, unsigned>, std::string> users_;  // a line's chip and number -> device
  std::unique_ptr<Projector> projector_;
  std::unique_ptr<Timer> end_;
};

}  // namespace contourd
