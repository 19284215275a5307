// The style sheet of a print's report page, in addition to the style sheet of all of contourd's pages.
#pragma once

#include <string_view>

namespace contourd {

inline constexpr std::string_view kReportPageStyle = R"(
:root { --exposing: #6a3fb5; --moving: #2673ad; --waiting: #87909b; --preparing: #1f8a63; --stopped: #cf5a17; }
@media (prefers-color-scheme: dark) { :root { --exposing: #b08af5; --moving: #56a8e0; --waiting: #6d7886; --preparing: #3fbd8d; --stopped: #f0863f; } }
@media print { :root { --exposing: #6a3fb5; --moving: #2673ad; --waiting: #87909b; --preparing: #1f8a63; --stopped: #cf5a17; } }
.top table { flex: 1 1 22rem; } .top th { white-space: nowrap; } td { overflow-wrap: anywhere; }
.notes { margin: .3rem 0; padding-left: 1.2rem; } .notes li { margin: .3rem 0; overflow-wrap: anywhere; }
.notes a { white-space: nowrap; } .warnings li::marker { color: var(--bad); content: "! "; }
.layers { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 12.5rem), 1fr)); gap: 1rem; }
.exposing { fill: var(--exposing); background: var(--exposing); } .moving { fill: var(--moving); background: var(--moving); }
.waiting { fill: var(--waiting); background: var(--waiting); } .preparing { fill: var(--preparing); background: var(--preparing); }
.stopped, .pause { fill: var(--stopped); background: var(--stopped); } .interruption { fill: var(--bad); background: var(--bad); }
svg .tick { stroke: var(--ink); stroke-width: 1; } svg .most { fill: var(--accent); } svg .least { fill: var(--waiting); }
.swatch.most { background: var(--accent); } .swatch.least { background: var(--waiting); }
.figures td, .figures th { font-variant-numeric: tabular-nums; }
.figures td:nth-child(n+2), .figures th:nth-child(n+2) { text-align: right; }
@media (max-width: 40rem) { .layers { grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .5rem; } body { margin: 1rem auto; } }
@media print {
  body { max-width: none; margin: 0; font-size: 10pt; } svg, .swatch, .shot { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h2 { break-after: avoid; } svg, tr { break-inside: avoid; } .layers { grid-template-columns: repeat(4, 1fr); } .part { width: 14rem; }
}
)";

}  // namespace contourd
