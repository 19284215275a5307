// The cured part on a page: its section at the worst place, and plots of its distances from the model.
// Thread-safe (no shared state).
#pragma once

#include <string>
#include <string_view>

#include "core/cure/cured_part.hpp"

namespace contourd {

// Follows the style sheet of all pages.
inline constexpr std::string_view kCuredPartStyle = R"(
.cured { display: block; max-height: 32rem; background: #fff; border-radius: 4px; box-shadow: 0 0 0 1px var(--line); }
.cured .solid { fill: #aab2bd; } .cured .much, .swatch.much { fill: #d33f30; background: #d33f30; } .cured .lacks, .swatch.lacks { fill: #2673ad; background: #2673ad; }
.cured-figures th { white-space: nowrap; } .swatch.solid { background: #aab2bd; } .cured rect { fill: none; stroke: #000; stroke-width: 1.5; vector-effect: non-scaling-stroke; }
.bars rect { fill: var(--accent); } .sections { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 22rem), 1fr)); gap: 1rem; }
)";

// Returns the sections as SVG: all of the row, and the surroundings of the worst place. Empty if there is no
// such place.
[[nodiscard]] std::string cured_section(const CureSection& section);

// Returns headings and histograms of the distances of undersides, tops and walls, as far as there are any.
[[nodiscard]] std::string distance_plots(const CureFigures& figures);

}  // namespace contourd
