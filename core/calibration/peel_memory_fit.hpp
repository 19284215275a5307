// The share of its dose that liquid resin keeps at a peel, from the thicknesses of bridges. Values and pure
// functions; thread-safe.
//
// The light of every layer of a bridge also reaches the resin beneath the first one. The more of that dose
// the resin remembers from peel to peel, the further down the bridge solidifies (see CuredLayers): one layer
// cures as deep as its own light does, sixteen layers as deep as a thick part.
#pragma once

#include <span>

#include "core/calibration/line_fit.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// The light of a bridge.
struct BridgePrint {
  CureSettings resin{};  // peel_memory is not used
  Nanometers layer_height{};
  MillijoulesPerCm2 dose{};  // for each layer
};

// A bridge that was measured.
struct BridgeThickness {
  int layers = 0;
  Micrometers thickness{};
};

inline constexpr int kMostBridgeLayers = 100;

// Returns the thickness of a bridge above enough dark layers, for a peel memory. REQUIRES: positive layer
// height; 1 to kMostBridgeLayers layers; settings as CuredLayers requires them.
[[nodiscard]] Micrometers bridge_thickness(const BridgePrint& print, double memory, int layers);

// The standard uncertainty of the curve in BridgePrint::resin; 0 where it is not known.
struct CurveUncertainty {
  Micrometers penetration_depth{};
  MillijoulesPerCm2 critical_dose{};
  double correlation = 0;  // between both errors, -1 to 1
};

// Standard uncertainties of a memory, by their causes.
struct MemoryShares {
  double scatter = 0;                               // standard deviation of the thicknesses
  double penetration_depth = 0, critical_dose = 0;  // signed: what one standard deviation more changes
};

struct PeelMemoryFit {
  Estimate memory;
  MemoryShares shares;      // parts of its uncertainty
  double scatter_um = 0;    // the thicknesses about those by the memory
  double underside_um = 0;  // standard uncertainty of a thick part's underside, by the scatter
};

// Returns the memory with the least squares of the thicknesses' differences. `reading` is the standard
// uncertainty of a thickness by the rounding of its readings, the least that is assumed. Throws
// CalibrationRefused if fewer than four bridges of several layers were measured, a figure is no bridge's, the
// thicknesses scatter by more than 40 um, leave an underside uncertain by more than 15 um, or lie beyond
// those of any memory, or if the curve is uncertain by more than a quarter. REQUIRES: positive layer height;
// settings as CuredLayers requires them.
[[nodiscard]] PeelMemoryFit fit_peel_memory(const BridgePrint& print,
                                            std::span<const BridgeThickness> measured,
                                            const CurveUncertainty& curve = {}, Micrometers reading = {});

}  // namespace contourd
