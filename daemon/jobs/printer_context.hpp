// References to the objects that the components of the printer share, and that outlive these components. A
// value.
#pragma once

#include "daemon/config/printer_config.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/supervisor.hpp"
#include "hw/clock.hpp"
#include "hw/machine.hpp"

namespace contourd {

struct PrinterContext {
  const PrinterConfig& config;
  EventLoop& loop;
  Clock& clock;
  Machine& machine;
  const Log& log;
  Supervisor& supervisor;
};

}  // namespace contourd
