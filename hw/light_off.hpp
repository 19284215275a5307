// Turns off the light that a crashed process may have left on, by the light line and by the projector's
// serial line. Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/gpio_light_line.hpp"
#include "hw/projector.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

class LightOff {
 public:
  // Receives why the light may still be on, a sentence for each device; empty if it is off.
  using Done = std::function<void(const std::vector<std::string>& problems)>;

  // The clock and the watcher must outlive this object.
  LightOff(Clock& clock, DescriptorWatcher& watcher, LightConfig config);

  // Turns the light off. Blocks for as long as the devices take to open. Calls `done` from the event loop
  // once the projector has confirmed that its light is off, or has failed to for kPatience (it may be warming
  // up).
  void run(Done done);

  static constexpr Duration kPatience{std::chrono::seconds{20}};

 private:
  void turn_line_off();
  void tell_projector();
  void give_up();
  void end();

  Clock& clock_;
  DescriptorWatcher& watcher_;
  LightConfig config_;
  Done done_;
  std::vector<std::string> problems_;
  std::unique_ptr<GpioLightLine> line_;
  std::unique_ptr<Projector> projector_;
  std::unique_ptr<Timer> again_, patience_;
  std::unique_ptr<Timer> end_;
};

}  // namespace contourd
