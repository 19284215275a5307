// The working curve of a resin, and the projector's gamma, from thicknesses of resin that was cured on the
// bare film. Values and pure functions; thread-safe.
//
// Light of the dose E through the film solidifies the resin above it to the thickness Dp ln(E / Ec) (Jacobs
// 1992, thesis equation 2.1): a line over the dose's logarithm. A grey value g gives the share (g /
// 255)^gamma of the light, and so a line over the logarithm of g / 255, with the slope Dp gamma. Where the
// resin answers to t I^p instead of t I, that is gamma p, which is what masks need.
#pragma once

#include <cstdint>
#include <span>

#include "core/calibration/line_fit.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// The thickness of a window that was cured with a dose.
struct CuredWindow {
  MillijoulesPerCm2 dose;
  Micrometers thickness;
};

struct CurveFit {
  Estimate penetration_depth_um;  // Dp
  Estimate critical_dose_mj_cm2;  // Ec
  double correlation = 0;         // between both errors: a steeper line begins later
  LineFit line;                   // thickness in um over ln(dose in mJ/cm2)
  [[nodiscard]] Micrometers thickness_of(MillijoulesPerCm2 dose) const;
};

// Returns the working curve of at least five windows. `reading` is the standard uncertainty of a thickness by
// the rounding of its readings, the least that is assumed. Throws CalibrationRefused if there are fewer
// windows, a dose or thickness is not positive, the doses span less than a factor of four, the thickness
// falls with the dose, the scatter leaves Dp uncertain by more than a tenth, or no resin has such a curve.
[[nodiscard]] CurveFit fit_working_curve(std::span<const CuredWindow> windows, Micrometers reading = {});

// The thickness of a window that was lit with a grey value, all windows for the same time.
struct GreyWindow {
  std::uint8_t grey = 0;
  Micrometers thickness;
};

struct GammaFit {
  Estimate gamma;
  LineFit line;  // thickness in um over ln(grey / 255)
  [[nodiscard]] Micrometers thickness_of(std::uint8_t grey) const;
};

// Returns the gamma by which the resin, with this penetration depth, answers to grey values. Throws
// CalibrationRefused as fit_working_curve() does; the grey values must span at least from 255 to 180.
[[nodiscard]] GammaFit fit_gamma(std::span<const GreyWindow> windows, Estimate penetration_depth_um,
                                 Micrometers reading = {});

}  // namespace contourd
