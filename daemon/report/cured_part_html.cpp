#include "daemon/report/cured_part_html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "daemon/report/cured_part_text.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Stretch = CureSection::Stretch;

// A section with more stretches than this is drawn in some columns, so that the page stays small.
constexpr std::size_t kMostStretches = 10'000;

// A rectangle of the section, in millimetres.
struct Frame {
  double left, right, bottom, top;
};

double x_of(const CureSection& section, const Stretch& stretch) {
  return section.first_x_mm + stretch.column * section.step_mm;
}

std::vector<Stretch> within(const CureSection& section, std::span<const Stretch> stretches,
                            const Frame& frame) {
  std::vector<Stretch> inside;
  for (const Stretch& each : stretches) {
    const Stretch cut{each.column, std::max(each.from_mm, frame.bottom), std::min(each.to_mm, frame.top)};
    const double x = x_of(section, each);
    if (x >= frame.left && x <= frame.right && cut.to_mm > cut.from_mm) inside.push_back(cut);
  }
  return inside;
}

// Returns what two sets of stretches have in common.
std::vector<Stretch> common(std::span<const Stretch> one, std::span<const Stretch> other) {
  std::vector<Stretch> both;
  auto begin = other.begin();
  for (const Stretch& of_one : one) {
    while (begin != other.end() && begin->column < of_one.column)
      ++begin;
    for (auto each = begin; each != other.end() && each->column == of_one.column; ++each) {
      const Stretch part{of_one.column, std::max(of_one.from_mm, each->from_mm),
                         std::min(of_one.to_mm, each->to_mm)};
      if (part.to_mm > part.from_mm) both.push_back(part);
    }
  }
  return both;
}

// Draws every some-th column that many pixels wide.
std::string path_of(const CureSection& section, std::span<const Stretch> stretches, const char* kind,
                    std::uint32_t every) {
  const double width_mm = every * section.pixel_mm;
  std::string path = fmt::format("<path class=\"{}\" d=\"", kind);
  for (const Stretch& each : stretches) {
    if (each.column % every != 0) continue;
    fmt::format_to(std::back_inserter(path), "M{:.4f} {:.4f}h{:.4f}V{:.4f}h{:.4f}z",
                   x_of(section, each) - width_mm / 2, -each.from_mm, width_mm, -each.to_mm, -width_mm);
  }
  return path + "\"/>\n";
}

// Returns the section within a frame. `mark` is framed in it.
std::string drawing(const CureSection& section, const Frame& frame, const Frame* mark,
                    const std::string& title) {
  const std::vector<Stretch> model = within(section, section.model, frame),
                             cured = within(section, section.cured, frame);
  const auto every = static_cast<std::uint32_t>(1 + (model.size() + cured.size()) / kMostStretches);
  std::string svg = fmt::format(
      "<svg class=\"cured\" viewBox=\"{:.4f} {:.4f} {:.4f} {:.4f}\" role=\"img\" aria-label=\"{}\">\n",
      frame.left, -frame.top, frame.right - frame.left, frame.top - frame.bottom, title);
  svg += path_of(section, cured, "much", every) + path_of(section, model, "lacks", every) +
         path_of(section, common(model, cured), "solid", every);
  if (mark != nullptr)
    svg += fmt::format("<rect x=\"{:.4f}\" y=\"{:.4f}\" width=\"{:.4f}\" height=\"{:.4f}\"/>\n", mark->left,
                       -mark->top, mark->right - mark->left, mark->top - mark->bottom);
  return fmt::format("<figure>{}</svg>\n<figcaption>{}</figcaption></figure>\n", svg, title);
}

Frame frame_of(const CureSection& section) {
  Frame all{section.at.plate_mm.x, section.at.plate_mm.x, 0, section.at.height_mm};
  for (const std::vector<Stretch>* stretches : {&section.model, &section.cured}) {
    for (const Stretch& each : *stretches) {
      all.left = std::min(all.left, x_of(section, each) - section.pixel_mm);
      all.right = std::max(all.right, x_of(section, each) + section.pixel_mm);
      all.top = std::max(all.top, each.to_mm + section.pixel_mm);
    }
  }
  return all;
}

constexpr double kBarsWidth = 860, kBarsHeight = 170, kBarsLeft = 84, kBarsRight = 10, kBarsTop = 22,
                 kBarsBottom = 34;

std::string histogram(const char* name, const SurfaceDistances& distances) {
  if (distances.places == 0) return "";
  const DistanceBins& bins = distances.bins;
  const std::uint64_t most = *std::ranges::max_element(bins.places);
  const double step = (kBarsWidth - kBarsLeft - kBarsRight) / static_cast<double>(bins.places.size());
  const double base = kBarsHeight - kBarsBottom, full = base - kBarsTop;
  std::string svg = fmt::format(
      "<h2>{0}, places by distance, um</h2>\n<svg class=\"bars\" viewBox=\"0 0 {1} {2}\" role=\"img\" "
      "aria-label=\"{0} by "
      "their "
      "distance, um\">\n<line class=\"grid\" x1=\"{3}\" x2=\"{4}\" y1=\"{5}\" y2=\"{5}\"/>"
      "<text x=\"{6}\" y=\"{7}\" text-anchor=\"end\">{8}</text>"
      "<text x=\"{6}\" y=\"{5}\" text-anchor=\"end\">0</text>\n",
      name, kBarsWidth, kBarsHeight, kBarsLeft, kBarsWidth - kBarsRight, base, kBarsLeft - 8, kBarsTop + 8,
      most);
  const std::size_t labels = (bins.places.size() + 6) / 7;  // about seven
  for (std::size_t bin = 0; bin < bins.places.size(); ++bin) {
    const double x = kBarsLeft + static_cast<double>(bin) * step;
    const double middle_um = bins.first_um + static_cast<double>(bin) * bins.width_um;
    if (bins.places[bin] > 0) {
      const double height =
          std::max(1.0, full * static_cast<double>(bins.places[bin]) / static_cast<double>(most));
      svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"><title>{} places: {:+.4g} "
          "um</title></rect>\n",
          x + step * 0.1, base - height, std::min(step * 0.8, 60.0), height, bins.places[bin], middle_um);
    }
    if (bin % labels == labels / 2)
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:+.4g}</text>\n",
                         x + step / 2, base + 22, std::round(middle_um * 10) / 10);
  }
  return "<div>" + svg + "</svg></div>\n";
}

}  // namespace

std::string cured_section(const CureSection& section) {
  if (section.pixel_mm == 0) return "";
  constexpr double kLeastMm = 0.5, kLeastPixels = 10, kWidthsOfWorst = 3;
  const double around = std::max(
      {kLeastMm, kLeastPixels * section.pixel_mm, kWidthsOfWorst * std::abs(section.worst_um) / 1000});
  const CurePlace& at = section.at;
  const Frame near{at.plate_mm.x - around, at.plate_mm.x + around, at.height_mm - around,
                   at.height_mm + around};
  const std::string pictures =
      drawing(section, frame_of(section), &near,
              fmt::format("The section along x at y = {} mm", coordinates({at.plate_mm.y}))) +
      drawing(section, near, nullptr,
              fmt::format("The worst place, {:+.0f} um, {}", section.worst_um, place_text(at)));
  return "<h2>Section through the worst place</h2>\n<div class=\"sections\">\n" + pictures +
         "</div>\n<p><span class=\"swatch solid\"></span>cured as drawn, <span class=\"swatch "
         "much\"></span>cured beside the model, <span class=\"swatch lacks\"></span>missing</p>\n";
}

std::string distance_plots(const CureFigures& figures) {
  return histogram("Undersides", figures.undersides) + histogram("Tops", figures.tops) +
         histogram("Walls", figures.walls);
}

}  // namespace contourd
