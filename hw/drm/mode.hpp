// A display mode: which one an owner means, and whether it can show masks. Pure functions on what the kernel
// lists; thread-safe.
#pragma once

#include <xf86drmMode.h>

#include <optional>
#include <span>
#include <string>

#include "hw/drm/drm_display_config.hpp"

namespace contourd {

using Mode = drmModeModeInfo;

// Pictures a second, from the pixel clock: 59.94 is not 60, which the kernel's rounded vrefresh cannot say.
[[nodiscard]] double refresh_hz(const Mode& mode);

// "1920x1080 at 59.94 Hz", with what is odd about it: "1920x1080 at 60.00 Hz, interlaced".
[[nodiscard]] std::string describe(const Mode& mode);
// "1280x720 at 60.00 Hz, 1920x1080 at 60.00 Hz", each once; "none".
[[nodiscard]] std::string describe(std::span<const Mode> modes);

// Whether both are the same to a display, whatever they are called.
[[nodiscard]] bool same_timing(const Mode& a, const Mode& b);

// Of the whole picture, as EDID has it. 0 where it is unknown, as with projectors as a rule.
struct PictureSize {
  int width_mm = 0, height_mm = 0;
};

// Why masks cannot be shown with this mode, if they cannot: it sends half pictures, lines or pixels twice, a
// picture for each eye, or its pixels are not square. They are square when
//  - the picture's aspect ratio that the mode names (CEA-861), and
//  - the picture's size, if both sides are known, for some size that rounds to it (EDID has centimetres),
// give pixels that are as wide as high to 1 %.
[[nodiscard]] std::optional<std::string> why_unsuitable(const Mode& mode, PictureSize size);

// The mode that the config asks for: its very size; the refresh nearest to the wanted one, within half a
// hertz; of equally near ones that which the display prefers. Throws HardwareError, which names `output`
// ("HDMI-A-1 of /dev/dri/card0 (vc4)") and what modes there are.
[[nodiscard]] Mode choose_mode(std::span<const Mode> modes, PictureSize size, const DrmDisplayConfig& config,
                               const std::string& output);

}  // namespace contourd
