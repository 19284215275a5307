// A factory of projectors, and the only place that knows which kinds exist.
#pragma once

#include <memory>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/projector.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Opens the projector without sending anything. Throws HardwareError if it is not there. The clock and the
// watcher must outlive the projector.
[[nodiscard]] std::unique_ptr<Projector> open_projector(const SerialProjectorConfig& config, Clock& clock,
                                                        DescriptorWatcher& watcher);

}  // namespace contourd
