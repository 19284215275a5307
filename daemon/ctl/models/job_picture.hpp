// The shaded picture of a job's models in their places. Thread-safe (no shared state).
#pragma once

#include "core/engine/contour_engine.hpp"
#include "core/image/preview.hpp"
#include "daemon/prepare/job_summary.hpp"

namespace contourd {

// Width and height of the picture.
inline constexpr Pixels kJobPictureSide{720};

// Draws all models from their facets; for a very large job, one copy of each. Takes up to some seconds.
// `summary` and `engine` are of the same job.
[[nodiscard]] Mask draw_job_picture(const JobSummary& summary, const ContourEngine& engine);

}  // namespace contourd
