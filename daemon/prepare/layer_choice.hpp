// Chooses the layers of a print, equally thick or adaptive, within the limits of the resin. Thread-safe (no
// shared state).
#pragma once

#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/print/print_plan.hpp"

namespace contourd {

// Returns the thickness of the layers beneath a model that stands on supports.
[[nodiscard]] Nanometers layer_beneath(const JobTicket& ticket, const ResinProfile& resin);
// Returns the gap that the bottom layers close; of adaptive layers, the thinnest ones.
[[nodiscard]] Millimeters closed_gap(const JobTicket& ticket, const ResinProfile& resin);

// Returns the layers for the summary's resin and height, and notes their limits in the summary. Throws
// JobRefused if the resin does not allow them.
[[nodiscard]] PrintLayers choose_layers(const JobTicket& ticket, const PrinterConfig& printer,
                                        const std::vector<ModelToPlace>& models, JobSummary& summary);
// Computes all layers of the plan in advance, for the estimates. Throws JobRefused if there are none.
void count_layers(PrintPlan& plan, JobSummary& summary);

}  // namespace contourd
