// The shaded picture of a part for the report of its print, from the masks with which it was printed: as the
// resin has it, all models of a plate, mended, and what stands beside them. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

// As wide and as high, at most.
inline constexpr Pixels kPrintedPartSide{720};

// The layers that had all their light; what the print was still to make of the models is drawn faint over
// them. Computes the masks once more, as many as the picture can show: the same height and engine make the
// same mask. As large as there is time for by the deadline; nothing when there is not even that for a quarter
// of the side. Supports have a colour of their own.
[[nodiscard]] std::optional<PartPreview> draw_printed_part(const PrintReport& report, ContourEngine& engine,
                                                           MaskBudget::Clock::time_point deadline);

}  // namespace contourd
