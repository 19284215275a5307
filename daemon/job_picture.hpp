// The shaded picture of a job's models where they stand, for a person. Thread-safe (no shared state).
#pragma once

#include "core/engine/contour_engine.hpp"
#include "core/image/preview.hpp"
#include "daemon/job_summary.hpp"

namespace contourd {

// As wide and as high.
inline constexpr Pixels kJobPictureSide{720};

// Whether copies of a model are drawn beside it.
enum class DrawnCopies { None, All };

// What was printed of them up to that height above the plate. Takes up to some seconds: of a very large job,
// one of each model. `engine` is that of the job of which `summary` tells.
[[nodiscard]] Mask draw_job_picture(const JobSummary& summary, const ContourEngine& engine, Millimeters top,
                                    DrawnCopies copies);

}  // namespace contourd
