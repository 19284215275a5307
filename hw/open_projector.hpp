// The kinds of projectors that there are: the one place that knows which.
#pragma once

#include <memory>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/projector.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Sends nothing yet. Throws HardwareError when it is not there. Clock and watcher must outlive it.
[[nodiscard]] std::unique_ptr<Projector> open_projector(const SerialProjectorConfig& config, Clock& clock,
                                                        DescriptorWatcher& watcher);

}  // namespace contourd
