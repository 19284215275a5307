// Finds the places that have to be held (islands, overhangs and where peel pulls too hard) in one sweep of
// sections from the plate up. A layer with no more than SupportSettings::closed_gap beneath it rests on the
// plate wherever its material begins. The sweep has the print's layers and compensation, if they are known,
// and pixels of its own. Thread-safe (no shared state). Deterministic: the same models and settings give the
// same contacts on every machine.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// An observer of the sweep's layers. An exception from it ends the sweep.
class LayerObserver {
 public:
  LayerObserver() = default;
  LayerObserver(const LayerObserver&) = delete;
  LayerObserver& operator=(const LayerObserver&) = delete;
  virtual ~LayerObserver() = default;

  // Called once, before all layers, with the sweep's display (without mirrors; centred on the plate; no
  // smaller than the build area) and the step between heights.
  virtual void begin(const DisplayGeometry& sweep_display, Nanometers step) = 0;
  // Called for the middle of each step above the plate, up to the last layer's top. `lit` holds the lit
  // pixels of the print's layer there, which may be none, and is valid during the call.
  virtual void layer(Nanometers height, const MaskRuns& lit) = 0;
};

// The maximum height of a sweep, since its layers have 16-bit numbers.
inline constexpr Millimeters kHighestSweep{3000.0};

struct HeldPlaces {
  std::vector<SupportContact> contacts;  // from the plate up
};

// Finds the contacts that the request's models need. Blocks: about a second per million facets. Returns
// nullopt if `stop` is requested, which is checked before every layer and every contact. REQUIRES: no null
// pointers, pixel_pitch > 0, no model higher than kHighestSweep.
[[nodiscard]] std::optional<HeldPlaces> find_overhangs(const SupportRequest& request, LayerObserver& observer,
                                                       const std::stop_token& stop = {});

}  // namespace contourd
