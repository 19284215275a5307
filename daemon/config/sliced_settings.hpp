// The settings of a job whose file holds finished pictures of layers. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <string>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"

namespace contourd {

// Exposures that a file names: its lowest layers have the first one, and a fade leads to the normal one.
struct FileExposures {
  Duration normal{}, first{};
  int first_layers = 0, fading_layers = 0;
};

struct FileLayers {
  Nanometers thickness{};
  std::optional<FileExposures> exposures{};  // nullopt: the file names none
};

// Changes ticket and profile to those of pictures: the layer height is the file's, outlines are not
// compensated for the resin, undersides are plain and layers are printed one by one. With
// `exposure_from` the exposures are the file's, too, and are added to `overridden`. Returns a refusal, a
// sentence, if the ticket asks for what needs a model, or for exposures that the profile does not allow;
// empty if it does not. REQUIRES: irradiance > 0.
[[nodiscard]] std::string settle_for_pictures(const FileLayers& layers, double irradiance_mw_cm2,
                                              JobTicket& ticket, ResinProfile& resin,
                                              OverriddenSettings& overridden);

}  // namespace contourd
