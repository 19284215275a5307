// Tests the fit of shrinkage and growth with an owner who prints the ladder and measures it with an error.
#include "core/calibration/dimension_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/calibration/calibration_models.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/cure/pixel_light.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

using contourd::testing::mm;
using contourd::testing::shared_index;

constexpr std::int32_t kColumns = 1600, kRows = 1680;
constexpr double kPitchUm = 25;
constexpr DisplayGeometry kLadderDisplay{Pixels{kColumns}, Pixels{kRows}, Micrometers{kPitchUm}};

// A resin that spreads light, and then shrinks.
struct ShrinkingResin {
  double x_percent, y_percent;
  double overcure;  // dose of a layer over the dose that just cures it
  double sigma_pixels;
  double normal_quantile;  // of 1 - 1 / overcure: a straight wall grows by this many sigmas

  [[nodiscard]] double compensation_um() const { return -normal_quantile * sigma_pixels * kPitchUm; }
};

constexpr ShrinkingResin kSharp{0.8, 1.1, 3, 1.4, 0.4307}, kBlurred{-0.3, 0, 3.5, 2.4, 0.5659};

// Returns where a row of doses crosses 1 next to a place, in pixels.
double edge_near(const std::vector<double>& doses, double place) {
  double best = 1e9;
  for (std::size_t i = 0; i + 1 < doses.size(); ++i) {
    if ((doses[i] < 1) == (doses[i + 1] < 1)) continue;
    const double at = static_cast<double>(i) + 0.5 + (1 - doses[i]) / (doses[i + 1] - doses[i]);
    if (std::abs(at - place) < std::abs(best - place)) best = at;
  }
  return best;
}

// Prints the ladder with a profile's compensation, by its own mask in the middle of the blocks, and measures
// each length.
std::vector<MeasuredLength> printed_ladder(const ShrinkingResin& resin, const DimensionSettings& profile) {
  models::Facets facets = ladder_model();
  for (Facet& facet : facets)
    for (Vertex& vertex : facet.vertices) {
      vertex.x = static_cast<float>(vertex.x / (1 - profile.shrinkage_x_percent / 100));
      vertex.y = static_cast<float>(vertex.y / (1 - profile.shrinkage_y_percent / 100));
    }
  const Bounds bounds = bounds_of(facets);
  const PixelMap map = PixelMap::true_scale(kLadderDisplay, bounds.center());
  std::vector<PlateModel> models;
  models.push_back({{shared_index(std::move(facets))}, {map}});
  ContourEngine engine(std::move(models), {.display = kLadderDisplay,
                                           .compensation = {.growth = Micrometers{profile.growth_um}}});
  const Mask& mask = engine.mask_at(mm(4));
  std::vector<float> light;
  for (std::int32_t row = 0; row < mask.height().count(); ++row)
    for (const std::uint8_t grey : mask.row(row))
      light.push_back(static_cast<float>(grey) / 255);
  LightSpread({{{resin.sigma_pixels, 1}}}, kColumns, kRows).apply(light);
  // A straight wall ends where the dose is the one that just cures the layer.
  const auto dose = [&](std::int32_t column, std::int32_t row) {
    return resin.overcure * static_cast<double>(light[static_cast<std::size_t>(row * kColumns + column)]);
  };
  const double row_y = 2.5 / (1 - profile.shrinkage_y_percent / 100);
  const double column_x = 2.5 / (1 - profile.shrinkage_x_percent / 100);
  const PixelPoint right = map.to_pixels({column_x, row_y}),
                   back = map.to_pixels({column_x, 10 / (1 - profile.shrinkage_y_percent / 100)});
  std::vector<double> along_x, along_y;
  for (std::int32_t column = 0; column < kColumns; ++column)
    along_x.push_back(dose(column, static_cast<std::int32_t>(right.y)));
  for (std::int32_t row = 0; row < kRows; ++row)
    along_y.push_back(dose(static_cast<std::int32_t>(back.x), row));
  std::vector<MeasuredLength> lengths;
  for (const LadderLength& length : ladder_lengths()) {
    const auto in_x = [&](Millimeters at) {
      return edge_near(along_x,
                       map.to_pixels({at.count() / (1 - profile.shrinkage_x_percent / 100), row_y}).x);
    };
    const auto in_y = [&](Millimeters at) {
      return edge_near(
          along_y, map.to_pixels({column_x, (8 + at.count()) / (1 - profile.shrinkage_y_percent / 100)}).y);
    };
    const double x_mm =
        std::abs(in_x(length.to) - in_x(length.from)) * kPitchUm / 1000 * (1 - resin.x_percent / 100);
    const double y_mm =
        std::abs(in_y(length.to) - in_y(length.from)) * kPitchUm / 1000 * (1 - resin.y_percent / 100);
    lengths.push_back({PlateAxis::X, length.kind, Millimeters{length.drawn_mm}, Millimeters{x_mm}});
    lengths.push_back({PlateAxis::Y, length.kind, Millimeters{length.drawn_mm}, Millimeters{y_mm}});
  }
  return lengths;
}

void misread(std::vector<MeasuredLength>& lengths, std::mt19937& random) {
  std::normal_distribution<double> error(0, 0.01);
  for (MeasuredLength& length : lengths)
    length.measured += Millimeters{error(random)};
}

std::string dimension_refusal(const std::vector<MeasuredLength>& lengths,
                              const DimensionSettings& printed = {}) {
  try {
    (void)fit_dimensions(printed, lengths);
  } catch (const CalibrationRefused& refused) {
    return refused.what();
  }
  return "";
}

// Returns the ladder's lengths by a scale and a growth.
std::vector<MeasuredLength> ladder_by(double scale, double growth_mm) {
  std::vector<MeasuredLength> lengths;
  for (const PlateAxis axis : {PlateAxis::X, PlateAxis::Y})
    for (const LadderLength& length : ladder_lengths())
      lengths.push_back(
          {axis, length.kind, Millimeters{length.drawn_mm},
           Millimeters{length.drawn_mm * scale + (length.kind == LengthKind::Outer ? 2 : -2) * growth_mm}});
  return lengths;
}

}  // namespace

TEST_CASE("Lengths by a scale and a growth give the compensation that undoes both") {
  const DimensionFit fit = fit_dimensions({}, ladder_by(0.99, 0.05));
  REQUIRE(fit.shrinkage_x_percent);
  REQUIRE(fit.shrinkage_y_percent);
  CHECK(fit.shrinkage_x_percent->value == Approx(1));
  CHECK(fit.shrinkage_y_percent->value == Approx(1));
  CHECK(fit.growth_um.value == Approx(-50 / 0.99));
  CHECK(fit.scatter_um < 1e-6);
}

TEST_CASE("Exact lengths leave the uncertainty of their readings") {
  const DimensionFit fit = fit_dimensions({}, ladder_by(0.99, 0.05), Millimeters{0.01 / std::sqrt(12)});
  CHECK(fit.scatter_um == Approx(10 / std::sqrt(12)));
  CHECK(fit.growth_um.uncertainty > 0.1);
  CHECK(fit.shrinkage_x_percent.value().uncertainty > 1e-3);
}

TEST_CASE("A part that measures as drawn keeps the profile's values") {
  const DimensionFit fit = fit_dimensions({1.5, -0.5, -37}, ladder_by(1, 0));
  CHECK(fit.shrinkage_x_percent.value().value == Approx(1.5));
  CHECK(fit.shrinkage_y_percent.value().value == Approx(-0.5));
  CHECK(fit.growth_um.value == Approx(-37));
}

TEST_CASE("Lengths along one axis leave the other's shrinkage alone") {
  std::vector<MeasuredLength> lengths = ladder_by(0.99, 0.05);
  std::erase_if(lengths, [](const MeasuredLength& length) { return length.axis == PlateAxis::Y; });
  const DimensionFit fit = fit_dimensions({}, lengths);
  CHECK(fit.shrinkage_x_percent.value().value == Approx(1));
  CHECK_FALSE(fit.shrinkage_y_percent);
}

TEST_CASE("An owner with calipers finds shrinkage and growth within their uncertainties") {
  const DimensionSettings profile{0.4, 0, -20};
  for (const ShrinkingResin& resin : {kSharp, kBlurred}) {
    const std::vector<MeasuredLength> ladder = printed_ladder(resin, profile);
    const double growth_um = resin.compensation_um();
    // Greys at the pixels' edges move a wall by 2 um at most.
    CHECK(fit_dimensions(profile, ladder).growth_um.value == Approx(growth_um).margin(2));
    int within_two = 0;
    constexpr int kOwners = 100;
    for (unsigned seed = 0; seed < kOwners; ++seed) {
      std::mt19937 random(seed);
      std::vector<MeasuredLength> lengths = ladder;
      misread(lengths, random);
      const DimensionFit fit = fit_dimensions(profile, lengths);
      CAPTURE(seed, fit.growth_um.value, growth_um);
      CHECK(fit.shrinkage_x_percent.value().value == Approx(resin.x_percent).margin(0.1));
      CHECK(fit.shrinkage_y_percent.value().value == Approx(resin.y_percent).margin(0.1));
      CHECK(fit.growth_um.value == Approx(growth_um).margin(8));
      const auto within = [](const Estimate& found, double truth) {
        return std::abs(found.value - truth) <= 2 * found.uncertainty ? 1 : 0;
      };
      within_two += within(*fit.shrinkage_x_percent, resin.x_percent) +
                    within(*fit.shrinkage_y_percent, resin.y_percent) + within(fit.growth_um, growth_um);
    }
    CHECK(within_two >= 3 * kOwners * 85 / 100);  // 93 of 100 by Student's distribution
  }
}

TEST_CASE("A second ladder, printed with the fitted values, measures as drawn") {
  for (const ShrinkingResin& resin : {kSharp, kBlurred}) {
    DimensionSettings profile{0.4, 0, -20};
    const DimensionFit fit = fit_dimensions(profile, printed_ladder(resin, profile));
    profile = {fit.shrinkage_x_percent.value().value, fit.shrinkage_y_percent.value().value,
               fit.growth_um.value};
    for (const MeasuredLength& length : printed_ladder(resin, profile)) {
      CAPTURE(length.drawn.count());
      // An edge within a pixel's grey moves by up to a fifth of the pixel of 25 um.
      CHECK(length.measured.count() == Approx(length.drawn.count()).margin(0.005));
    }
  }
}

TEST_CASE("Lengths that do not determine the figures are refused, with what was found") {
  const std::vector<MeasuredLength> good = ladder_by(0.99, 0.05);
  REQUIRE(dimension_refusal(good).empty());
  CHECK(lacking(dimension_refusal({}), {"0 lengths do not determine 2 figures: measure at least 6"}).empty());
  CHECK(lacking(dimension_refusal({good.begin() + 4, good.begin() + 12}),
                {"8 lengths do not determine 3 figures"})
            .empty());
  std::vector<MeasuredLength> odd = good;
  odd[3].measured = Millimeters{29.7};
  CHECK(lacking(dimension_refusal(odd), {"a length of 3 mm that measures 29.7 mm"}).empty());
  odd[3].measured = Millimeters{std::nan("")};
  CHECK(lacking(dimension_refusal(odd), {"a length of 3 mm that measures nan mm"}).empty());
  CHECK(lacking(dimension_refusal(std::vector<MeasuredLength>(9, good[0])), {"the lengths are too similar"})
            .empty());
  odd = good;
  odd[0].measured += Millimeters{0.5};
  CHECK(lacking(dimension_refusal(odd), {"the lengths scatter by"}).empty());
  odd.clear();
  for (const double error : {0.05, -0.05, 0.05})
    for (const LadderLength& length : ladder_lengths())
      if (length.drawn_mm < 4)
        odd.push_back({PlateAxis::X, length.kind, Millimeters{length.drawn_mm},
                       Millimeters{length.drawn_mm + error * (length.drawn_mm < 3 ? 1 : -1)}});
  CHECK(lacking(dimension_refusal(odd), {"in x is uncertain by"}).empty());
}

TEST_CASE("Figures outside of a profile's limits are refused") {
  CHECK(lacking(dimension_refusal(ladder_by(0.9, 0.05), {15, 15, 0}), {"a shrinkage of 23.5 % in x, outside"})
            .empty());
  CHECK(lacking(dimension_refusal(ladder_by(1.15, 0.01)), {"a shrinkage of -15 % in x, outside"}).empty());
  CHECK(
      lacking(dimension_refusal(ladder_by(1, 0.3), {0, 0, -300}), {"a growth of -600 um, outside"}).empty());
}
