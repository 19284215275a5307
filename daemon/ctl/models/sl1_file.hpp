// Writes a print as a sliced archive for printers of the type SL1: a ZIP file of PNG pictures by layer, with
// config.ini, prusaslicer.ini and two thumbnails, as PrusaSlicer's archive format SL1 has them.
#pragma once

#include <filesystem>
#include <vector>

#include "core/contour/layer_cracks.hpp"
#include "daemon/ctl/models/print_subject.hpp"

namespace contourd::ctl {

// Writes or replaces the archive. The pictures are the light that contourd gives the layers, before the
// threshold, the uniformity mask and the gamma of its projector, which contourd applies to the archive, too:
// printed with the same configuration, the archive gives the same masks. `model` is the file that the layers
// are named after. Draws the layers one after another, and keeps one of them in memory. Blocks. Throws
// UsageError if the layers have several thicknesses or are more than 99,999; OutputError if the file cannot
// be written: then there is no new file, and an earlier one is unchanged. Returns the cracks of each layer.
// REQUIRES: the print has a printer's configuration and a layer.
std::vector<LayerCracks> write_sl1(const std::filesystem::path& path, const std::filesystem::path& model,
                                   const PrintSubject& subject);

}  // namespace contourd::ctl
