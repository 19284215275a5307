// Common parts of contourd's HTML pages: the style sheet, text that is safe in HTML, and plots as SVG.
// Thread-safe (no shared state).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace contourd {

inline constexpr std::string_view kPageStyle = R"(
:root { color-scheme: light dark; --ink: #1d2733; --paper: #fbfbfa; --line: #c9ced6; --accent: #6a3fb5; --good: #1b7a40; --bad: #b83227; }
@media (prefers-color-scheme: dark) { :root { --ink: #dfe4ea; --paper: #14181d; --line: #3a4450; --accent: #b99af0; --good: #58c98b; --bad: #f1786b; } }
@media print { :root { color-scheme: light; --ink: #000; --paper: #fff; --line: #999; --accent: #6a3fb5; --good: #1b7a40; --bad: #b83227; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; overflow-wrap: anywhere; } h2 { font-size: 1.05rem; margin: 1.8rem 0 .4rem; }
.outcome { font-weight: 600; } .done { color: var(--good); } .failed, .cancelled { color: var(--bad); } a { color: var(--accent); }
.top { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: flex-start; margin-top: 1rem; }
table { border-collapse: collapse; } td, th { text-align: left; padding: .15rem 1.2rem .15rem 0; vertical-align: top; }
th { font-weight: 400; opacity: .7; } svg { width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: var(--ink); } svg .grid { stroke: var(--line); stroke-width: 1; }
@media (max-width: 40rem) { svg text { font-size: 24px; } }
svg .curve { fill: none; stroke: var(--accent); stroke-width: 1.5; stroke-linejoin: round; vector-effect: non-scaling-stroke; }
figure { margin: 0; padding: .3rem; border-radius: 6px; scroll-margin-top: 1rem; break-inside: avoid; }
figure:target { outline: 3px solid var(--accent); }
.shot { position: relative; background: #000; border-radius: 4px; overflow: hidden; box-shadow: 0 0 0 1px var(--line); }
.shot img { display: block; width: 100%; height: auto; image-rendering: pixelated; }
.shot svg { position: absolute; inset: 0; width: 100%; height: 100%; }
.shot .voids circle { stroke: #4db8ff; }
.shot circle { fill: none; stroke: #ff5a4d; stroke-width: 2; vector-effect: non-scaling-stroke; }
.part { padding: 0; width: 22rem; max-width: 100%; } .part img { image-rendering: auto; }
.part .contacts circle { stroke: #000; stroke-width: 1; } .cause { white-space: nowrap; } .contacts .island, .swatch.island { fill: #ff4d8d; background: #ff4d8d; }
.contacts .overhang, .swatch.overhang { fill: #ffd166; background: #ffd166; } .contacts .peel, .swatch.peel { fill: #5ad1ff; background: #5ad1ff; }
figcaption { font-size: .87rem; line-height: 1.35; margin-top: .3rem; }
.swatch { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .5em; }
)";

// Returns the beginning of a page up to its body. `title` is HTML; `style` follows the style sheet of all
// pages. The page's policy keeps a browser from fetching or running anything, whatever a name contains.
[[nodiscard]] std::string page_start(const std::string& title, std::string_view style);

// Returns text, for instance from a file name or an error message, in a form that is safe inside HTML.
[[nodiscard]] std::string escaped(const std::string& text);

// Returns a row of a table. `name` is HTML, `value` is text.
[[nodiscard]] std::string table_row(const std::string& name, const std::string& value);

struct PlotPoint {
  double height_mm, value;
};

// Returns a heading and below it a curve over the height as SVG. `title` is HTML. REQUIRES: rising heights.
[[nodiscard]] std::string svg_plot(const std::string& title, std::span<const PlotPoint> all);

}  // namespace contourd
