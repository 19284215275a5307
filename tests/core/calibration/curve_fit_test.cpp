#include "core/calibration/curve_fit.hpp"

#include <cmath>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "core/cure/working_curve.hpp"
#include "tests/catch.hpp"
#include "tests/core/cure/published_resins.hpp"

namespace contourd {
namespace {

constexpr WorkingCurve kHidden{Micrometers{150}, MillijoulesPerCm2{8}};

// Returns windows as an owner measures them: over a factor of 16 of dose, with noise of 10 um.
std::vector<CuredWindow> measured_windows(unsigned seed, int count = 8, double span = 16,
                                          double noise_um = 10) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_um);
  std::vector<CuredWindow> windows;
  for (int i = 0; i < count; ++i) {
    const MillijoulesPerCm2 dose{16 * std::pow(span, i / (count - 1.0))};
    windows.push_back(
        {dose, Micrometers{kHidden.depth_of(dose).count() + (noise_um > 0 ? noise(random) : 0)}});
  }
  return windows;
}

TEST_CASE("A working curve is found from windows without noise to rounding") {
  const CurveFit fit = fit_working_curve(measured_windows(0, 8, 16, 0));
  CHECK(fit.penetration_depth_um.value == Approx(150));
  CHECK(fit.critical_dose_mj_cm2.value == Approx(8));
  CHECK(fit.line.scatter < 1e-9);
  CHECK(fit.thickness_of(MillijoulesPerCm2{8 * std::exp(2)}).count() == Approx(300));
}

TEST_CASE("The curves of published resins are found from thicknesses in whole micrometres") {
  for (const PublishedResin& resin : kPublishedResins) {
    CAPTURE(resin.name);
    std::vector<CuredWindow> windows;
    for (int window = 0; window < 9; ++window) {
      const double dose = 2 * resin.dose * std::pow(16, window / 8.0);
      windows.push_back(
          {MillijoulesPerCm2{dose}, Micrometers{std::round(resin.depth_um * std::log(dose / resin.dose))}});
    }
    const CurveFit fit = fit_working_curve(windows);
    // Readings are off by 0.29 um (one standard deviation); this is four times what that makes of the slope,
    // and of the dose at which the line begins.
    CHECK(fit.penetration_depth_um.value == Approx(resin.depth_um).margin(0.45));
    CHECK(fit.critical_dose_mj_cm2.value == Approx(resin.dose).epsilon(1.2 / resin.depth_um));
  }
}

// The scatter of the results of many calibrations, and the uncertainty that they state on average.
struct Scatter {
  double depth_um = 0, stated_depth_um = 0, log_dose = 0, stated_log_dose = 0;
};
Scatter scatter_of_results(double noise_um) {
  constexpr int kPrints = 2000;
  Scatter sums;
  for (unsigned seed = 0; seed < kPrints; ++seed) {
    const CurveFit fit = fit_working_curve(measured_windows(seed, 8, 16, noise_um));
    sums.depth_um += std::pow(fit.penetration_depth_um.value - 150, 2) / kPrints;
    sums.log_dose += std::pow(fit.critical_dose_mj_cm2.value / 8 - 1, 2) / kPrints;
    sums.stated_depth_um += fit.penetration_depth_um.uncertainty / kPrints;
    sums.stated_log_dose += fit.critical_dose_mj_cm2.uncertainty / 8 / kPrints;
  }
  sums.depth_um = std::sqrt(sums.depth_um);
  sums.log_dose = std::sqrt(sums.log_dose);
  return sums;
}

TEST_CASE("Eight windows give Dp and Ec within the uncertainty that is stated") {
  // Windows that were measured once have a noise of 10 um, the mean of three measurements has 5.8 um. Dp then
  // scatters by noise / sqrt(sum (ln E - mean)^2), which is 3.9 and 2.3 um.
  for (const auto& [noise_um, depth_um, log_dose] : {std::tuple(10.0, 3.9, 0.06), {5.8, 2.3, 0.035}}) {
    CAPTURE(noise_um);
    const Scatter scatter = scatter_of_results(noise_um);
    CHECK(scatter.depth_um == Approx(depth_um).epsilon(0.05));
    CHECK(scatter.log_dose < log_dose);
    // A standard deviation of six degrees of freedom is on average 4 percent low.
    CHECK(scatter.stated_depth_um == Approx(scatter.depth_um).epsilon(0.07));
    CHECK(scatter.stated_log_dose == Approx(scatter.log_dose).epsilon(0.07));
  }
}

TEST_CASE("The errors of Dp and Ec are correlated as stated") {
  constexpr int kPrints = 2000;
  double both = 0, depth = 0, log_dose = 0, stated = 0;
  for (unsigned seed = 0; seed < kPrints; ++seed) {
    const CurveFit fit = fit_working_curve(measured_windows(seed));
    const double of_depth = fit.penetration_depth_um.value - 150;
    const double of_dose = std::log(fit.critical_dose_mj_cm2.value / 8);
    both += of_depth * of_dose;
    depth += of_depth * of_depth;
    log_dose += of_dose * of_dose;
    stated += fit.correlation / kPrints;
  }
  CHECK(both / std::sqrt(depth * log_dose) == Approx(stated).margin(0.02));
}

TEST_CASE("Windows that do not determine a curve are refused with their figures") {
  const std::vector<CuredWindow> sound = measured_windows(1);
  CHECK_THROWS_WITH(fit_working_curve({sound.data(), 4}),
                    "4 windows do not determine a curve: measure at least 5, better eight");
  CHECK_THROWS_WITH(fit_working_curve({sound.data(), 1}),
                    "1 window does not determine a curve: measure at least 5, better eight");
  std::vector<CuredWindow> huge = sound;
  for (CuredWindow& window : huge)
    window.thickness = Micrometers{1e308};
  CHECK_THROWS_WITH(fit_working_curve(huge),
                    "a window of 1e+308 um: cured resin is at most 100000 um thick; type thicknesses in um");
  CHECK_THROWS_WITH(fit_working_curve(measured_windows(1, 8, 3.9)),
                    Catch::Matchers::StartsWith("the doses span a factor of 3.9: they must span at least 4"));
  std::vector<CuredWindow> falling = sound;
  for (std::size_t i = 0; i < sound.size(); ++i)
    falling[i].thickness = sound[sound.size() - 1 - i].thickness;
  CHECK_THROWS_WITH(fit_working_curve(falling),
                    Catch::Matchers::StartsWith("the thickness does not grow with the dose"));
  std::vector<CuredWindow> uncured = sound;
  uncured[0].thickness = Micrometers{0};
  CHECK_THROWS_WITH(fit_working_curve(uncured), Catch::Matchers::StartsWith("a window of 0 um at 16 mJ/cm2"));
  CHECK_THROWS_WITH(fit_working_curve(measured_windows(3, 8, 16, 100)),
                    Catch::Matchers::StartsWith("the thicknesses scatter by "));
}

std::vector<GreyWindow> measured_greys(unsigned seed, double gamma, double noise_um) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<GreyWindow> windows;
  for (const int grey : {255, 230, 207, 186, 168, 151, 136, 122, 110}) {
    const MillijoulesPerCm2 dose{128 * std::pow(grey / 255.0, gamma)};
    windows.push_back({static_cast<std::uint8_t>(grey),
                       Micrometers{kHidden.depth_of(dose).count() + noise_um * noise(random)}});
  }
  return windows;
}

TEST_CASE("Gamma is found from windows of grey values") {
  CHECK(fit_gamma(measured_greys(0, 2.2, 0), {150, 0}).gamma.value == Approx(2.2));
  double squares = 0, stated = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const GammaFit fit = fit_gamma(measured_greys(seed, 2.2, 10), {150, 0});
    squares += std::pow(fit.gamma.value - 2.2, 2) / 1000;
    stated += fit.gamma.uncertainty / 1000;
  }
  CHECK(stated == Approx(std::sqrt(squares)).epsilon(0.07));
  // An uncertain Dp makes gamma as uncertain.
  CHECK(fit_gamma(measured_greys(0, 2.2, 0), {150, 15}).gamma.uncertainty == Approx(0.22));
  std::vector<GreyWindow> narrow;
  for (int i = 0; i < 5; ++i)
    narrow.push_back({static_cast<std::uint8_t>(255 - 15 * i), Micrometers{500.0 - 50 * i}});
  CHECK_THROWS_WITH(fit_gamma(narrow, {150, 0}),
                    Catch::Matchers::StartsWith("the grey values 195 to 255 span a factor of 1.308"));
  narrow.back() = {181, Micrometers{200}};
  CHECK_THROWS_WITH(
      fit_gamma(narrow, {150, 0}),
      Catch::Matchers::StartsWith("the grey values 181 to 255 span a factor of 1.409: they must "
                                  "span at least 1.417"));
  narrow.back() = {180, Micrometers{231}};
  CHECK_NOTHROW(fit_gamma(narrow, {150, 0}));
}

TEST_CASE("Doses that just span a factor of four determine a curve") {
  for (const double least : {15.0, 0.3, 7.7, 33.3}) {
    std::vector<CuredWindow> windows;
    for (const double factor : {1.0, 1.5, 2.0, 3.0, 4.0})
      windows.push_back({MillijoulesPerCm2{least * factor}, Micrometers{100 + 150 * std::log(factor)}});
    CHECK_NOTHROW(fit_working_curve(windows));
  }
}

// Returns windows of the hidden curve in which all depths are multiplied by a factor.
std::vector<CuredWindow> scaled_windows(double depth_factor, double dose_factor) {
  std::vector<CuredWindow> windows = measured_windows(0, 8, 16, 0);
  for (auto& [dose, thickness] : windows) {
    thickness = thickness * depth_factor;
    dose = dose * dose_factor;
  }
  return windows;
}

TEST_CASE("A curve that no resin has is refused with what was typed and the reason") {
  CHECK_THROWS_WITH(fit_working_curve(scaled_windows(1e-3, 1)),
                    "0.104 to 0.5199 um at 16 to 256 mJ/cm2 give a penetration depth of 0.15 um and a "
                    "critical dose of 8 mJ/cm2, but resins have 15 to 2000 um and 0.05 to 500 mJ/cm2: type "
                    "thicknesses in um (0.104 mm as 104) and doses in mJ/cm2, and check "
                    "projector.irradiance_mw_cm2");
  for (const auto& [depth_factor, dose_factor] :
       {std::pair(9.9 / 150, 1.0), {14430.0 / 150, 1.0}, {1.0, 0.0076 / 8}, {1.0, 1000.0}})
    CHECK_THROWS_WITH(fit_working_curve(scaled_windows(depth_factor, dose_factor)),
                      Catch::Matchers::Contains(", but resins have "));
  for (const auto& [depth_factor, dose_factor] :
       {std::pair(0.12, 1.0), {13.0, 1.0}, {1.0, 0.01}, {1.0, 60.0}})
    CHECK_NOTHROW(fit_working_curve(scaled_windows(depth_factor, dose_factor)));
}

TEST_CASE("Figures of exact thicknesses are as uncertain as the rounding of the readings makes them") {
  // Eight doses over a factor of 16 have a sum of squares of ln E of 6.59 (see above: 10 um give 3.9 um).
  const double reading_um = 1 / std::sqrt(12);
  const CurveFit fit = fit_working_curve(measured_windows(0, 8, 16, 0), Micrometers{reading_um});
  CHECK(fit.penetration_depth_um.uncertainty == Approx(reading_um * 0.39).epsilon(0.01));
  CHECK(fit.critical_dose_mj_cm2.uncertainty > 0.01);
  CHECK(fit_gamma(measured_greys(0, 2.2, 0), {150, 0}, Micrometers{reading_um}).gamma.uncertainty > 1e-3);
  // Windows that scatter more are as uncertain as they scatter.
  CHECK(fit_working_curve(measured_windows(1), Micrometers{reading_um}).line.scatter ==
        fit_working_curve(measured_windows(1)).line.scatter);
}

}  // namespace
}  // namespace contourd
