#include "hw/open_projector.hpp"

#include "hw/serial/serial_port.hpp"
#include "hw/serial/serial_projector.hpp"

namespace contourd {

std::unique_ptr<Projector> open_projector(const SerialProjectorConfig& config, Clock& clock,
                                          DescriptorWatcher& watcher) {
  return std::make_unique<SerialProjector>(
      std::make_unique<SerialPort>(config.port, config.table.baud, watcher), clock, config.table,
      config.brightness);
}

}  // namespace contourd
