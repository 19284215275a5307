// The settings of a job whose file holds finished layers: pictures or outlines. Thread-safe (no shared
// state).
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
  bool outlines = false;                     // the layers are no pictures
};

// Returns a refusal, a sentence, if the ticket asks for what finished layers cannot have; empty if it does
// not.
[[nodiscard]] std::string refusal_for_layers(const JobTicket& ticket);

// Changes ticket and profile to those of finished layers: the layer height is the file's, the part does not
// shrink, pictures are not compensated for the resin, undersides are plain and layers are printed one by one.
// With `exposure_from` the exposures are the file's, too, and are added to `overridden`. Returns a refusal, a
// sentence, if the ticket asks for what needs a model, or for exposures that the profile does not allow;
// empty if it does not. REQUIRES: irradiance > 0.
[[nodiscard]] std::string settle_for_layers(const FileLayers& layers, double irradiance_mw_cm2,
                                            JobTicket& ticket, ResinProfile& resin,
                                            OverriddenSettings& overridden);

}  // namespace contourd
