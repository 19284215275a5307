#include "daemon/report/job_picture.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/support/support_mesh.hpp"
#include "daemon/system/base64.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

std::vector<PreviewPart> parts_of(const ContourEngine& engine) {
  constexpr std::size_t kMaxFacets = 5'000'000;  // drawing takes some seconds
  std::size_t facets = 0;
  for (const PlateModel& standing : engine.models())
    facets += standing.model->facets().size() * standing.copies.size();
  const DisplayGeometry display =
      display_of(engine.models(), engine.coverage().width(), engine.coverage().height());
  std::vector<PreviewPart> parts;
  for (const PlateModel& standing : engine.models()) {
    const HeightIndex& model = *standing.model;
    const Point middle = model.bounds().center();
    const double lift_mm = standing.elevation.lift(model.bounds()).count();
    const std::size_t copies = facets <= kMaxFacets ? standing.copies.size() : 1;
    for (const PixelMap& copy : std::span(standing.copies).first(copies)) {
      const Point center = on_plate(display, copy.to_pixels(middle));
      parts.push_back({model.facets(), {center.x - middle.x, center.y - middle.y, lift_mm}});
    }
  }
  return parts;
}

// Makes the pixels of parts that are not in `printed` faint, so that the printed parts stay visible. Keeps
// the lowest bit of each pixel, which marks supports (see Preview).
void fade(Mask& whole, const Mask& printed) {
  constexpr double kFaint = 0.3;
  for (std::int32_t y = 0; y < whole.height().count(); ++y) {
    const auto to = whole.row(y);
    const auto from = printed.row(y);
    for (std::size_t x = 0; x < to.size(); ++x) {
      if (to[x] == from[x]) continue;
      const auto grey = static_cast<unsigned>((1 - kFaint) * from[x] + kFaint * to[x]);
      to[x] = static_cast<std::uint8_t>((grey & ~1U) | (to[x] & 1U));
    }
  }
}

}  // namespace

DisplayGeometry display_of(std::span<const PlateModel> models, Pixels width, Pixels height) {
  const PixelMap& map = models.front().copies.front();
  const PixelPoint origin = map.to_pixels({0, 0}), beside = map.to_pixels({1, 1});
  DisplayGeometry display;
  display.width = width;
  display.height = height;
  display.pixel_pitch = Micrometers{1000 / map.pixels_per_mm()};
  display.mirror_x = beside.x < origin.x;
  display.mirror_y = beside.y > origin.y;
  return display;
}

Preview draw_job(const ContourEngine& engine, const Supports* supports, Millimeters printed) {
  std::vector<PreviewPart> parts = parts_of(engine);
  std::vector<Facet> mesh;
  if (supports != nullptr && supports->structure) {
    mesh = support_mesh(supports->structure->primitives());
    parts.push_back({mesh, {}, true});
  }
  constexpr Millimeters kAll{std::numeric_limits<double>::infinity()};
  Preview preview = render_preview(parts, kAll, kJobPictureSide, kJobPictureSide);
  if (printed <= Millimeters{}) {
    fade(preview.picture, Mask(kJobPictureSide, kJobPictureSide));
  } else if (printed < kAll) {
    fade(preview.picture, render_preview(parts, printed, kJobPictureSide, kJobPictureSide).picture);
  }
  return preview;
}

JobPicture encode_picture(const Preview& drawing, const Supports* supports) {
  if (supports == nullptr) return {drawing.picture.width(), encode_png(drawing.picture), {}};
  JobPicture picture{drawing.picture.width(), {}, {}};
  for (const SupportContact& contact : supports->contacts) {
    picture.contacts.push_back(
        {drawing.at({contact.place.x, contact.place.y, contact.place.z}), contact.cause});
  }
  if (!supports->structure) {
    picture.png = encode_png(drawing.picture);
    return picture;
  }
  Palette palette;
  for (std::size_t grey = 0; grey < palette.size(); ++grey) {
    const auto value = static_cast<std::uint8_t>(grey);
    const auto part_of = [value](double share) { return static_cast<std::uint8_t>(share * value); };
    palette[grey] = grey % 2 == 0 ? Rgb{value, value, value} : Rgb{part_of(0.72), part_of(0.6), value};
  }
  picture.png = encode_png(drawing.picture, &palette);
  return picture;
}

std::string picture_figure(const JobPicture& picture, const std::string& alt, const std::string& rings) {
  std::string html = fmt::format(
      "<figure class=\"part\"><div class=\"shot\"><img alt=\"{}\" src=\"data:image/png;base64,{}\">", alt,
      base64(picture.png));
  if (!rings.empty())
    html += fmt::format("<svg viewBox=\"0 0 {0} {0}\">{1}</svg>", picture.side.count(), rings);
  if (picture.contacts.empty()) return html + "</div></figure>\n";
  html += fmt::format(
      "<svg class=\"contacts\" viewBox=\"0 0 {0} {0}\" role=\"img\" aria-label=\"The supports' contacts\">",
      picture.side.count());
  const double radius = picture.side.count() / (picture.contacts.size() > 200 ? 240.0 : 160.0);
  for (const JobPicture::Contact& contact : picture.contacts) {
    html += fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                        name_of(contact.cause), contact.at.x, contact.at.y, radius);
  }
  html += "</svg></div><figcaption>The supports' contacts, in front and hidden:";
  for (const ContactCause cause : {ContactCause::Island, ContactCause::Overhang, ContactCause::Peel}) {
    const auto count = std::ranges::count(picture.contacts, cause, &JobPicture::Contact::cause);
    if (count > 0)
      html += fmt::format(" <span class=\"cause\"><span class=\"swatch {0}\"></span>{0} {1}</span>",
                          name_of(cause), count);
  }
  return html + "</figcaption></figure>\n";
}

}  // namespace contourd
