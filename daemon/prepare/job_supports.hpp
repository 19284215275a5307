// The supports of a job: its models lifted where they do not stand by themselves, arranged with room for what
// holds them, and what that is. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/routing/support_generation.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/plate_arrangement.hpp"

namespace contourd {

// Sets the models' elevations, whole numbers of these layers. Throws JobRefused where one is too high then.
void lift_models(std::vector<ModelToPlace>& models, const SupportSettings& settings, Nanometers layer,
                 const BuildVolume& volume);

struct HeldPlate {
  Arrangement arrangement;
  Supports supports;
};

// Models that need no supports lie as they lie without; otherwise there is room for feet between all of
// them. Nothing when `stop` was asked for meanwhile. Throws JobRefused: as arrange() and check_arrangement(),
// and JobTooLarge. Blocks: see make_supports().
class PlateHolding {
 public:
  // All must outlive it.
  PlateHolding(const std::vector<ModelToPlace>& models, const BuildVolume& volume,
               const SupportSettings& settings, const JobContent& content)
      : models_(models), volume_(volume), settings_(settings), content_(content) {}

  // `layer` is the thinnest: in such steps models are looked at for collisions.
  [[nodiscard]] std::optional<HeldPlate> hold(Nanometers layer, const std::stop_token& stop) const;

 private:
  [[nodiscard]] std::optional<Supports> supports_of(const Arrangement& arrangement,
                                                    const std::stop_token& stop) const;

  const std::vector<ModelToPlace>& models_;
  const BuildVolume& volume_;
  const SupportSettings& settings_;
  const JobContent& content_;
};

// As the engine takes them.
[[nodiscard]] std::vector<PlateModel> stand_on_plate(const std::vector<ModelToPlace>& models,
                                                     const Arrangement& arrangement,
                                                     const DisplayGeometry& display);

}  // namespace contourd
