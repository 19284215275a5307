// What an axis makes of its inputs' changes: the emergency stop and the lid, the switches where they should
// not close, inputs that cannot be read. Tells each once, with its line. Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/machine_event.hpp"

namespace contourd {

class AxisInterlocks {
 public:
  struct Wiring {
    std::function<void(const AxisFault&)> fail;
    std::function<void(const MachineEvent&)> report;
    std::function<void()> slow_down;                   // what moves, until the emergency stop has settled
    std::function<void(const AxisFault&)> halted_for;  // what moved; the fault when it rests
    // The limit switch has halted the steps: whether homing wants to know.
    std::function<bool(const InputChange&)> takes_contact;
    std::function<std::string()> where;  // " at 12.345 mm", or nothing
  };

  // Config, engine and inputs must outlive it.
  AxisInterlocks(const GpioAxisConfig& config, const StepEngine& engine, AxisInputs& inputs, Wiring wiring);

  // The inputs' changes() is readable.
  void take_changes();
  // The steps are inhibited, by the emergency stop or because the inputs are lost: the fault.
  void blocked();

  // The emergency stop, the lid; a sentence each.
  [[nodiscard]] std::vector<std::string> why_not_ready() const;

 private:
  void take_change(const InputChange& change);
  void take_emergency_stop(const InputChange& change);
  void take_lid(const InputChange& change);
  void take_limit_switch(const InputChange& change);
  [[nodiscard]] std::string loss() const;

  const GpioAxisConfig& config_;
  const StepEngine& engine_;
  AxisInputs& inputs_;
  const Wiring wiring_;
  bool emergency_told_ = false, loss_told_ = false;
};

}  // namespace contourd
