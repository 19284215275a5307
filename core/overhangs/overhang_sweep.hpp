// What has to be held: one sweep of sections from the plate up, at a step and with pixels of its own,
// whatever the print's layers. Islands, overhangs, and what peel pulls at. Thread-safe (no shared state).
// Deterministic: the same models and settings give the same contacts on every machine.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_request.hpp"

namespace contourd {

// Who looks on as the sweep goes up. What it throws ends the sweep.
class LayerObserver {
 public:
  LayerObserver() = default;
  LayerObserver(const LayerObserver&) = delete;
  LayerObserver& operator=(const LayerObserver&) = delete;
  virtual ~LayerObserver() = default;

  // Once, before all layers: the display that they are on (without mirrors, its centre is the plate's, no
  // smaller than the build area) and how thick they are.
  virtual void begin(const DisplayGeometry& sweep_display, Nanometers step) = 0;
  // Layer after layer, dark ones too, up to the models' top: what is lit, at least by half, at the middle of
  // the layer, which is that high above the plate. `lit` is valid during the call.
  virtual void layer(Nanometers height, const MaskRuns& lit) = 0;
};

// The sweep's layers have numbers of 16 bits.
inline constexpr Millimeters kHighestSweep{3000.0};

struct HeldPlaces {
  std::vector<SupportContact> contacts;  // from the plate up
};

// Blocks, for a second for a million facets. Nothing when `stop` was asked for meanwhile; it is looked at
// before every layer and every contact. REQUIRES: no null pointers, pixel_pitch > 0, nothing higher than
// kHighestSweep.
[[nodiscard]] std::optional<HeldPlaces> find_overhangs(const SupportRequest& request, LayerObserver& observer,
                                                       const std::stop_token& stop = {});

}  // namespace contourd
