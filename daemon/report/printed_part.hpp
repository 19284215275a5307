// The shaded picture of a part for the report of its print, drawn from the masks with which it was printed.
// It shows the part as printed: all models of a plate, repaired, with their supports. Thread-safe (no shared
// state).
#pragma once

#include <optional>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

// The largest width and height of the picture.
inline constexpr Pixels kPrintedPartSide{720};

// Draws the layers that had all their light, and the rest of the part faintly above them. Computes as many
// masks again as the picture can show: the same height and engine make the same mask. The picture is as large
// as the deadline allows; returns nullopt if there is not even time for a quarter of the full side. Supports
// have their own colour.
[[nodiscard]] std::optional<PartPreview> draw_printed_part(const PrintReport& report, ContourEngine& engine,
                                                           MaskBudget::Clock::time_point deadline);

}  // namespace contourd
