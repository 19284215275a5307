// The reactions of an axis to changes of its inputs: emergency stop, lid, power-fail signal, switches that
// close in the wrong place, force, inputs that cannot be read. Each is reported once, with its line. Event
// loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hw/device.hpp"
#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {

class AxisInterlocks {
 public:
  struct Wiring {
    std::function<void(const AxisFault&)> fail;
    std::function<void(const MachineEvent&)> report;
    std::function<void()> slow_down;                   // slows the motor until the emergency stop has settled
    std::function<void(const AxisFault&)> halted_for;  // sets the fault of a halted run
    // Called when the limit switch has halted the steps. True if homing or a nudge expected that.
    std::function<bool(const InputChange&)> takes_contact;
    std::function<std::string()> where;                     // " at 12.345 mm", or empty
    std::function<void(const InputChange&)> force_changed;  // also if the force has halted the run
  };

  // Config, engine and inputs must outlive this object.
  AxisInterlocks(const GpioAxisConfig& config, const StepEngine& engine, AxisInputs& inputs, Wiring wiring);

  // To be called when the inputs' changes() is readable.
  void take_changes();
  // Reports the fault for which the steps are inhibited: the emergency stop, or that the inputs are lost.
  void blocked();

  // Returns a sentence for each safety input that is not safe.
  [[nodiscard]] std::vector<std::string> why_not_ready() const;

 private:
  void take_change(const InputChange& change);
  void take_emergency_stop(const InputChange& change);
  // The sentences about an input that interrupts the print: `unsafe` from its first edge on, `safe` again.
  struct InterlockTexts {
    const char *unsafe, *unreadable, *safe;
  };
  void take_interlock(const InputChange& change, const GpioInputConfig& input, const InterlockTexts& texts);
  void take_limit_switch(const InputChange& change);
  [[nodiscard]] std::string loss() const;

  const GpioAxisConfig& config_;
  const StepEngine& engine_;
  AxisInputs& inputs_;
  const Wiring wiring_;
  bool emergency_reported_ = false, loss_reported_ = false;
};

}  // namespace contourd
