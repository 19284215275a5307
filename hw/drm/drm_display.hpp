// A projector on one of the kernel's display outputs, through libdrm: the MaskDisplay that open_device() in
// real_machine_config.hpp opens. The output shows only the masks that it is given: black from construction
// on, black and then no signal at destruction, no console, no cursor.
//
// A display is lost if it is unplugged, its mode disappears, another program takes its card, or the kernel
// does not confirm a page flip in time (flip_deadline()). Then a pending `done` gets nullopt and a
// MachineEvent says why, within 20 ms while a mask is on the screen. The display is restored, black, when the
// kernel announces it again or at probe_again(). While it is lost, show() and black() call their `done` with
// nullopt.
//
// Calls that block (reading a display's EDID, setting and ending its mode) run on a thread of their own, so
// the event loop is not delayed by them, during an exposure or at any other time. The exception is the
// constructor: a machine calls it while it has no display, and so no job and no light.
//
// A presented time is that of the vblank at whose end the screen began to show the picture (CLOCK_MONOTONIC,
// in whole microseconds); the picture's last row follows a refresh later. Drivers without vblanks
// (virtio-gpu, bochs) report when they had processed the flip instead, and do not wait for the refresh.
//
// Event loop's thread only.
#pragma once

#include <string>

#include "hw/drm/drm_display_config.hpp"

namespace contourd {

struct DrmReport {
  // One line: card, connector, mode, whether the driver's calls are atomic, pixel formats, and the facts that
  // a user should know.
  std::string description;
  bool in_use = false;  // by another program, so the driver was not asked
};

// Finds the output that a display with this config would use and asks the driver whether it would accept the
// mode. Changes nothing on any screen. Throws HardwareError if the output cannot be used, and also if no
// display is connected. Blocks for some milliseconds, with some displays 300 or more.
[[nodiscard]] DrmReport check_drm_display(const DrmDisplayConfig& config);

}  // namespace contourd
