#include "daemon/ctl/models/orient_page.hpp"

#include <fmt/format.h>

#include <limits>
#include <vector>

#include "core/image/preview.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/base64.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

constexpr Pixels kSide{360};

constexpr std::string_view kStyle = R"(
.ways { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: 1.5rem; margin-top: 1rem; }
figure { margin: 0; } figure img { width: 100%; border-radius: 6px; background: #000; }
figure.chosen img { outline: 3px solid var(--accent); }
)";

std::string figure(const OrientationFigures& figures, const Mask& picture, bool chosen) {
  const std::string up = text_of(figures.up);
  const bool drawn = figures.up == Direction{0, 0, 1};
  return fmt::format(
      "<figure{0}><img alt=\"The model with {1} up\" width=\"{2}\" height=\"{2}\" "
      "src=\"data:image/png;base64,{3}\">\n<figcaption><b>{1}</b>{4}<br>{5}; score "
      "{6:.2f}</figcaption></figure>\n",
      chosen ? " class=\"chosen\"" : "", up, kSide.count(), base64(encode_png(picture)),
      drawn ? ", as drawn" : "", describe(figures), figures.score);
}

}  // namespace

Mask picture_of(std::span<const Facet> facets, const Direction& up) {
  std::vector<Facet> turned(facets.begin(), facets.end());
  Orientation orientation;
  orientation.up = up;
  contourd::orient(turned, orientation);
  const Millimeters all{std::numeric_limits<double>::infinity()};
  return render_preview(turned, all, kSide, kSide);
}

std::string orientation_page(const std::string& name, const ModelOrientation& orientation,
                             std::span<const Mask> pictures) {
  std::string html =
      page_start(fmt::format("{}: orientations", escaped(name)), kStyle) +
      fmt::format("<h1>{}</h1>\n<p>{}</p>\n<div class=\"ways\">\n", escaped(name), describe(orientation));
  const std::span<const OrientationFigures> told = reported(orientation.choice);
  for (std::size_t i = 0; i < told.size(); ++i)
    html += figure(told[i], pictures[i], i == 0);
  return html + "</div>\n</html>\n";
}

}  // namespace contourd::ctl
