// Makes the models of a job from its files: orients them, turns and scales them as their tickets say, and
// indexes them by height. Thread-safe (no shared state).
#pragma once

#include <stop_token>
#include <vector>

#include "daemon/placement/job_settings.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/job_summary.hpp"

namespace contourd {

// Makes the models and adds their figures to the summary; fewer if `stop` was requested. Takes the facets
// from `content`. Throws JobRefused. Blocks for a few hundred milliseconds per million facets.
[[nodiscard]] std::vector<ModelToPlace> make_models(JobContent& content, const JobSettings& settings,
                                                    const BuildVolume& volume, JobSummary& summary,
                                                    const std::stop_token& stop);

}  // namespace contourd
