// The outlines in a sliced archive of the format SL1SVG. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "core/contour/outline_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "daemon/formats/sliced_archive.hpp"

namespace contourd {

// Returns the outlines on this display's plate, seen from above: the slicer's mirrors and its quarter turn
// are undone, its plate's middle lies on this plate's, and all rings of a layer are united by the non-zero
// rule. If the file does not tell its mirrors, the outlines come out as the file has them on the display. A
// display with the sides exchanged gets them turned by a quarter. They may reach over the plate's edge.
// Blocks, for about 1 ms a thousand points. Throws ModelError if a layer is damaged or has another size than
// the first one, if no layer has outlines, or if they need more than `most_bytes` of memory. Returns a part
// of the layers if a stop was requested. REQUIRES: the archive has outlines.
[[nodiscard]] std::shared_ptr<const OutlineStack> read_outlines(const SlicedArchive& archive,
                                                                const DisplayGeometry& display,
                                                                std::uint64_t most_bytes,
                                                                const std::stop_token& stop);

}  // namespace contourd
