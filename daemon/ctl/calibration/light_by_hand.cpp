#include "daemon/ctl/calibration/light_by_hand.hpp"

#include <fmt/format.h>

#include "daemon/ctl/commands/manual_command.hpp"

namespace contourd::ctl {

int warm_up(const ClientOptions& client) {
  fmt::print("The projector warms up.\n");
  return control_by_hand(client, {"projector", {{"power", "on"}}}, WaitFor::Operation, Progress::Hidden);
}

int shine(const ClientOptions& client, const Mask& picture, const Light& light) {
  const ShownPicture shown(client, picture);
  Request request{"light_on", {{"seconds", light.seconds}}};
  if (light.in_resin) request.parameters["in_resin"] = true;
  return control_by_hand(client, request, WaitFor::Operation, Progress::Hidden);
}

}  // namespace contourd::ctl
