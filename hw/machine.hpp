// One printer's devices, real or simulated, as the interfaces with which the daemon prints.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "hw/device.hpp"
#include "hw/interface.hpp"
#include "hw/mask_display.hpp"
#include "hw/projector.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class Machine : public Interface {
 public:
  // Owned by the machine.
  [[nodiscard]] virtual ZAxis& z_axis() = 0;
  [[nodiscard]] virtual MaskDisplay& display() = 0;
  [[nodiscard]] virtual Projector& projector() = 0;

  // Runs `call` from the event loop for every machine event from now on. By then the machine has done what
  // cannot wait (after an emergency stop the motor is still); the caller has to turn the light off.
  virtual void on_event(std::function<void(const MachineEvent&)> call) = 0;

  // Returns why the machine is not ready to print, as sentences joined by "; ": a missing device, an open
  // lid, a pressed emergency stop. Empty if it can print.
  [[nodiscard]] virtual std::string why_not_ready() const = 0;

  // Begins a print of this name. Returns the folder in which the machine saves the masks that it shows, or
  // nullopt if it saves none. Throws std::filesystem::filesystem_error if the folder cannot be made.
  virtual std::optional<std::filesystem::path> begin_job(std::string_view name) = 0;
};

// Returns why no print may begin although the machine is ready: the force line is active while nothing moves.
// Empty if nothing is in the way.
[[nodiscard]] inline std::string force_at_rest(Machine& machine) {
  const ZAxis& axis = machine.z_axis();
  if (axis.moving() || axis.force() != true) return "";
  std::string line;
  for (const AxisInputState& input : axis.inputs())
    if (input.name == kForceInput) line = " (" + input.line + ")";
  return "the force line" + line +
         " is active although the plate is at rest: free the plate, or check the line's threshold and wiring";
}

// Turns the light off, blanks the screen and stops the motor, so that the machine may be left alone.
inline void make_safe(Machine& machine) noexcept {
  machine.projector().light_off();
  machine.display().black_now();
  machine.z_axis().abort();
}

}  // namespace contourd
