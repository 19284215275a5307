// A layer's outlines in an SVG file, as PrusaSlicer writes them into archives of the format SL1SVG: a size in
// millimetres, and paths of straight sides. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <string>

#include "core/contour/contour_loops.hpp"
#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// The largest number of points in a layer: that of a layer of 200 figures, each with ten times the detail
// that a display of 8 million pixels shows.
inline constexpr std::size_t kMostSvgPoints = 1'000'000;

// The size that an SVG file names.
struct SvgSize {
  Millimeters width{}, height{};
  bool operator==(const SvgSize&) const = default;
};

struct SvgLayer {
  SvgSize size{};
  // The rings, each closed: millimetres from the middle of the picture, x to the right and y up.
  Contours rings{};
};

// Reads a layer, which replaces `layer`. Blocks for a time in proportion to the file. `name` begins messages.
// Throws ModelError for anything but well-formed XML with a size in millimetres, a viewBox and closed paths
// of straight sides, within or near the viewBox; for more than kMostSvgPoints points; and what the stream
// throws.
void read_svg_layer(ByteStream& stream, const std::string& name, SvgLayer& layer);

}  // namespace contourd
