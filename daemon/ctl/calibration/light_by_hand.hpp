// Light by manual control for calibrations: contourd's limits for it hold, and it ends with the connection.
// Blocks. Not thread-safe.
#pragma once

#include "core/mask/mask.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Powers the projector on and waits until it is warm. Returns the exit code.
int warm_up(const ClientOptions& client);

struct Light {
  double seconds = 0;
  bool in_resin = false;  // allowed while the plate may be in the resin
};
// Shows the picture, turns the light on, and waits until it is off. Returns the exit code. Throws DaemonError
// as ShownPicture does.
int shine(const ClientOptions& client, const Mask& picture, const Light& light);

}  // namespace contourd::ctl
