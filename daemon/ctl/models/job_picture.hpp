// The shaded picture of a job's models where they stand, for a person. Thread-safe (no shared state).
#pragma once

#include "core/engine/contour_engine.hpp"
#include "core/image/preview.hpp"
#include "daemon/prepare/job_summary.hpp"

namespace contourd {

// As wide and as high.
inline constexpr Pixels kJobPictureSide{720};

// All of them, from their facets. Takes up to some seconds: of a very large job, one of each model. `engine`
// is that of the job of which `summary` tells.
[[nodiscard]] Mask draw_job_picture(const JobSummary& summary, const ContourEngine& engine);

}  // namespace contourd
