// The shaded picture of a job's models in their places, with their supports: for the report of its print,
// contourctl preview and contourctl analyze. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/image/preview.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Width and height of the picture.
inline constexpr Pixels kJobPictureSide{720};

// Derives the geometry of a display of this size from the pixel map of the first model's first copy.
[[nodiscard]] DisplayGeometry display_of(std::span<const PlateModel> models, Pixels width, Pixels height);

// Draws all models of the engine from their facets, without drain holes and compensations, and the supports
// if there are any. For a very large job, draws one copy of each model. Everything above the height `printed`
// is faint. Takes up to some seconds.
[[nodiscard]] Preview draw_job(const ContourEngine& engine, const Supports* supports,
                               Millimeters printed = Millimeters{std::numeric_limits<double>::infinity()});

// The picture as PNG, for a page.
struct JobPicture {
  Pixels side;
  std::vector<std::uint8_t> png;
  struct Contact {
    PixelPoint at{};  // in the picture's pixels
    ContactCause cause = ContactCause::Island;
  };
  std::vector<Contact> contacts;  // the supports' contacts
};

// Encodes a picture of draw_job(), with the supports in their own colour, and finds their contacts in it.
[[nodiscard]] JobPicture encode_picture(const Preview& drawing, const Supports* supports);

// Returns the picture as an HTML figure with a dot for each contact. `alt` describes it; `rings` are further
// SVG elements, in the picture's pixels. The style sheet of all pages formats it.
[[nodiscard]] std::string picture_figure(const JobPicture& picture, const std::string& alt,
                                         const std::string& rings = "");

}  // namespace contourd
