#include "daemon/ctl/models/cure_page.hpp"

#include <fmt/format.h>

#include "core/image/preview.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/report/cured_part_html.hpp"
#include "daemon/report/cured_part_text.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/report/job_picture.hpp"

namespace contourd::ctl {
namespace {

constexpr std::string_view kCurePageStyle = R"(
body { max-width: 74rem; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 2.5rem; }
.plots svg text { font-size: 19px; } .part { width: min(100%, 34rem); margin-top: 1rem; }
.shot .ring.closed { stroke: #4db8ff; }
)";

std::string ring(const Preview& drawing, const char* kind, const CurePlace& place, const std::string& title) {
  const PixelPoint at = drawing.at({place.plate_mm.x, place.plate_mm.y, place.height_mm});
  return fmt::format(
      "<circle class=\"ring {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\"><title>{}</title></circle>\n", kind,
      at.x, at.y, title);
}

std::string marked_picture(const PrintSubject& subject, const CureFigures& found) {
  const Supports* const supports = subject.supports ? &*subject.supports : nullptr;
  const Preview drawing = draw_job(*subject.engine, supports);
  std::string rings;
  const auto mark = [&](const char* name, const SurfaceDistances& distances) {
    if (distances.places > 0)
      rings += ring(drawing, "worst", distances.worst,
                    fmt::format("worst {}: {:+.0f} um", name, distances.worst_um));
  };
  mark("underside", found.undersides);
  mark("top", found.tops);
  mark("wall", found.walls);
  if (found.closed_mm2 > 0)
    rings +=
        ring(drawing, "closed", found.closed, fmt::format("closed gap, {:.3f} mm", found.tallest_closed_mm));
  return picture_figure(encode_picture(drawing, supports), "The model as printed, shaded", rings);
}

}  // namespace

std::string cure_page(const std::string& name, const PrintSubject& subject, const CureResult& result) {
  const CuredPart& part = result.part;
  std::string rows =
      table_row("layers", layers_text(subject.layers)) + table_row("resin", subject.resin.value().name);
  for (const CureLine& line : cured_part_lines(part))
    rows += table_row(line.name, line.text);
  if (result.rise) {
    const CureLine rise = rise_light_line(*result.rise);
    rows += table_row(rise.name, rise.text);
  }
  for (const std::string& warning : result.warnings)
    rows += table_row("warning", warning);
  return page_start(escaped(name) + ": cured part",
                    std::string(kCuredPartStyle) + std::string(kCurePageStyle)) +
         fmt::format(
             "<h1>{}</h1>\n<div class=\"top\">\n{}<table class=\"cured-figures\">\n{}</table>\n</div>\n",
             escaped(name), marked_picture(subject, part.figures), rows) +
         cured_section(part.figures.section) + "<div class=\"plots\">\n" + distance_plots(part.figures) +
         "</div>\n</html>\n";
}

}  // namespace contourd::ctl
