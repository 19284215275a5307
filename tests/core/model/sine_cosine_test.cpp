#include "core/model/sine_cosine.hpp"

#include "tests/catch.hpp"

namespace {

// Returns the error of `value` in units in the last place.
double ulps_from(double value, long double truth) {
  const double size = std::fabs(static_cast<double>(truth));
  const double ulp = std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
  return static_cast<double>(std::fabs(static_cast<long double>(value) - truth)) / ulp;
}

constexpr long double kRadians = std::numbers::pi_v<long double> / 180.0L;

}  // namespace

TEST_CASE("Sine and cosine are within two units in the last place") {
  double worst = 0, worst_sum = 0;
  for (int i = -200'000; i <= 200'000; ++i) {
    const double degrees = i * 0.00193;  // beyond a whole turn on both sides, and hardly ever a round angle
    const auto [sine, cosine] = sine_cosine(degrees);
    // Reduced exactly, so that the rounding of large angles in long double does not count.
    const long double rest = std::remainder(degrees, 360.0) * kRadians;
    const long double true_sine = std::sin(rest), true_cosine = std::cos(rest);
    // Near a quarter turn, long double's pi, rounded at its 64th bit, is not accurate enough for a result
    // near zero.
    if (std::fabs(true_sine) > 1e-2L) worst = std::fmax(worst, ulps_from(sine, true_sine));
    if (std::fabs(true_cosine) > 1e-2L) worst = std::fmax(worst, ulps_from(cosine, true_cosine));
    worst_sum = std::fmax(worst_sum, std::fabs(sine * sine + cosine * cosine - 1));
  }
  CHECK(worst <= 2.0);
  // Twice two units (2^-53 of at most 1, doubled by the square) and the rounding of the sum.
  CHECK(worst_sum <= 6 * std::numeric_limits<double>::epsilon());
}

TEST_CASE("Small angles keep their relative accuracy on both sides of every quarter turn") {
  for (const double tiny : {1e-3, 1e-9, 1e-300}) {
    const double radians = static_cast<double>(tiny * kRadians);
    const double sine = tiny < 1e-6 ? radians : static_cast<double>(std::sin(tiny * kRadians));
    CHECK(ulps_from(sine_cosine(tiny).sine, sine) <= 2.0);
    CHECK(sine_cosine(-tiny).sine == -sine_cosine(tiny).sine);
    CHECK(sine_cosine(-tiny).cosine == sine_cosine(tiny).cosine);
  }
  constexpr double kTiny = 1.0 / 1024;  // 90 + kTiny is exact
  CHECK(sine_cosine(90 + kTiny).cosine == -sine_cosine(kTiny).sine);
  CHECK(sine_cosine(180 + kTiny).sine == -sine_cosine(kTiny).sine);
  CHECK(sine_cosine(270 + kTiny).cosine == sine_cosine(kTiny).sine);
}

TEST_CASE("Quarter turns are exact for any number of turns") {
  for (const double turns : {0.0, 360.0, -360.0, 360.0 * 1e9, -360.0 * 4096}) {
    CAPTURE(turns);
    CHECK(sine_cosine(turns).sine == 0.0);
    CHECK(sine_cosine(turns).cosine == 1.0);
    CHECK(sine_cosine(turns + 90).sine == 1.0);
    CHECK(sine_cosine(turns + 90).cosine == 0.0);
    CHECK(sine_cosine(turns - 90).sine == -1.0);
    CHECK(sine_cosine(turns - 90).cosine == 0.0);
    CHECK(sine_cosine(turns + 180).sine == 0.0);
    CHECK(sine_cosine(turns + 180).cosine == -1.0);
  }
}

TEST_CASE("An eighth of a turn has equal sides") {
  const double root = std::sqrt(0.5);
  for (const double degrees : {45.0, 135.0, 225.0, 315.0, -45.0, -135.0}) {
    CAPTURE(degrees);
    const auto [sine, cosine] = sine_cosine(degrees);
    CHECK(ulps_from(std::fabs(sine), root) <= 2.0);
    CHECK(ulps_from(std::fabs(cosine), root) <= 2.0);
    CHECK((sine > 0) == (std::remainder(degrees, 360.0) > 0));
  }
}
