// One printer's devices behind their interfaces: what the daemon prints with, real or simulated.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "hw/machine_event.hpp"
#include "hw/mask_display.hpp"
#include "hw/projector.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class Machine {
 public:
  Machine() = default;
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;
  virtual ~Machine() = default;

  // Owned by the machine.
  [[nodiscard]] virtual ZAxis& z_axis() = 0;
  [[nodiscard]] virtual MaskDisplay& display() = 0;
  [[nodiscard]] virtual Projector& projector() = 0;

  // `call` runs from the event loop for every machine event from now on. The machine has done what cannot
  // wait by then (after an emergency stop the motor is still), the light is the caller's to turn off.
  virtual void on_event(std::function<void(const MachineEvent&)> call) = 0;

  // Why it is not ready to print, a sentence each, joined by "; ": a device that is not there, an open lid, a
  // pressed emergency stop. Empty when it can print.
  [[nodiscard]] virtual std::string why_not_ready() const = 0;

  // A print of this name begins. Returns the folder in which the machine keeps what it shows, where it keeps
  // that. Throws std::filesystem::filesystem_error when that folder cannot be made.
  virtual std::optional<std::filesystem::path> begin_job(std::string_view name) = 0;
};

// Light off, screen black, motor still: the state in which a machine may be left alone.
inline void make_safe(Machine& machine) noexcept {
  machine.projector().light_off();
  machine.display().black_now();
  machine.z_axis().abort();
}

}  // namespace contourd
