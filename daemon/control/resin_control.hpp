// The method with which clients list the resin profiles. Independent of the transport. Event loop's thread
// only.
#pragma once

#include <cstddef>

#include "daemon/config/printer_config.hpp"
#include "daemon/control/control_method.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class ResinControl {
 public:
  using Json = ControlMethod::Json;
  // Maximum numbers in a reply: profiles, and calibrations of each.
  static constexpr std::size_t kMostResins = 100, kMostCalibrations = 5;

  // Both must outlive the control. The files are read on the spool's thread.
  ResinControl(const PrinterConfig& config, Spool& spool) : config_(config), spool_(spool) {}

  // Returns the method by its name. The control must outlive it.
  [[nodiscard]] ControlMethods methods();

 private:
  const PrinterConfig& config_;
  Spool& spool_;
};

// Returns the resin profiles of the printer's folder as a reply. Blocks. Thread-safe.
[[nodiscard]] nlohmann::ordered_json resins_json(const PrinterConfig& printer);

}  // namespace contourd
