#include "core/layers/layer_statistics.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

// Tolerance for a few roundings of sums of numbers below 1e4, each at most 1e-12.
constexpr double kSumRounding = 1e-11;

std::vector<LayerMeasurement> four_layers() {
  return {{Millimeters{0.1}, 1.0, 2.0, 10, 1},
          {Millimeters{0.2}, 2.0, 2.0, 20, 1},
          {Millimeters{0.3}, 3.0, 4.0, 30, 2},
          {Millimeters{0.4}, 4.0, 4.0, 40, 2}};
}

}  // namespace

TEST_CASE("A series gets its mean and the sample standard deviation") {
  const LayerStatistics statistics = statistics_of(four_layers());
  CHECK(statistics.slicing_ms.mean == 2.5);
  // Squares of 1.5, 0.5, 0.5, 1.5 are 5; over n - 1 = 3.
  CHECK(std::fabs(statistics.slicing_ms.deviation - std::sqrt(5.0 / 3.0)) <= kSumRounding);
  CHECK(statistics.contour_ms.mean == 3.0);
  CHECK(std::fabs(statistics.contour_ms.deviation - std::sqrt(4.0 / 3.0)) <= kSumRounding);
  CHECK(statistics.total_ms.mean == 5.5);
  CHECK(std::fabs(statistics.total_ms.deviation - std::sqrt(17.0 / 3.0)) <= kSumRounding);
  CHECK(statistics.intersecting_facets.mean == 25.0);
  CHECK(std::fabs(statistics.intersecting_facets.deviation - std::sqrt(500.0 / 3.0)) <= kSumRounding);
  CHECK(statistics.loop_count.mean == 1.5);
  CHECK(std::fabs(statistics.loop_count.deviation - std::sqrt(1.0 / 3.0)) <= kSumRounding);
}

TEST_CASE("Contour time is correlated with loops and with facets by equation 4.1") {
  const LayerStatistics statistics = statistics_of(four_layers());
  // Contour time is twice the loop count.
  CHECK(std::fabs(statistics.contour_time_vs_loop_count - 1.0) <= kSumRounding);
  // 20 + 40 + 120 + 160 = 340 over sqrt(40 * 3000).
  CHECK(std::fabs(statistics.contour_time_vs_intersecting_facets - 340.0 / std::sqrt(120'000.0)) <=
        kSumRounding);
}

TEST_CASE("No layers have no statistics and one layer no deviation") {
  const LayerStatistics none = statistics_of({});
  CHECK(none.slicing_ms.mean == 0.0);
  CHECK(none.slicing_ms.deviation == 0.0);
  CHECK(none.contour_time_vs_loop_count == 0.0);
  const LayerStatistics one = statistics_of(std::vector{four_layers().front()});
  CHECK(one.slicing_ms.mean == 1.0);
  CHECK(one.slicing_ms.deviation == 0.0);
}

TEST_CASE("A series of zeros correlates with nothing") {
  const std::array<double, 3> zeros{0, 0, 0}, ones{1, 1, 1};
  CHECK(normalized_correlation(zeros, ones) == 0.0);
  CHECK(normalized_correlation(ones, zeros) == 0.0);
  CHECK(normalized_correlation({}, {}) == 0.0);
}

TEST_CASE("A correlation lies between -1 and 1 and is the same both ways and at any scale") {
  CHECK(rc::check([] {
    std::vector<double> x(static_cast<std::size_t>(testing::draw(1, 20))), y(x.size()), scaled(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = testing::draw_real(-100, 100);
      y[i] = testing::draw_real(-100, 100);
      scaled[i] = x[i] * 4;
    }
    const double r = normalized_correlation(x, y);
    RC_ASSERT(std::fabs(r) <= 1.0 + kSumRounding);
    RC_ASSERT(r == normalized_correlation(y, x));
    RC_ASSERT(std::fabs(r - normalized_correlation(scaled, y)) <= kSumRounding);
  }));
}
