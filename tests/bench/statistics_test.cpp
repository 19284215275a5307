#include "tests/bench/statistics.hpp"

#include "tests/catch.hpp"

using namespace contourd::bench;

TEST_CASE("A percentile is the nearest rank's value, in any order of the values") {
  std::vector<double> values;
  for (int i = 1000; i >= 1; --i)
    values.push_back(i);
  CHECK(percentile(values, 99) == 990);
  CHECK(percentile(values, 50) == 500);
  CHECK(percentile(values, 100) == 1000);
  CHECK(percentile(values, 0.01) == 1);
  CHECK(percentile({3, 1, 2}, 50) == 2);
  CHECK(percentile({3, 1, 2}, 67) == 3);
  CHECK(percentile({7}, 99) == 7);
}

TEST_CASE("The median of an even number of values is the lower middle one") {
  CHECK(median({4, 1, 3, 2}) == 2);
}

TEST_CASE("A line through points that lie on one is that line") {
  const std::vector<double> x{1, 2, 10}, y{5, 7, 23};
  const Line line = fit_line(x, y);
  // Whole numbers this small have rounding errors only in the last of 16 digits.
  CHECK_THAT(line.slope, Catch::Matchers::WithinAbs(2, 1e-12));
  CHECK_THAT(line.at_zero, Catch::Matchers::WithinAbs(3, 1e-12));
  CHECK_THAT(line.worst_deviation, Catch::Matchers::WithinAbs(0, 1e-12));
}

TEST_CASE("The fit and the worst deviation are relative to the values") {
  // The line is flat, by symmetry. With weights of 1/1.5^2 twice and 1/3^2 once it is at (2/1.5 + 1/3) /
  // (2/2.25 + 1/9) = 5/3. The middle's 3 is off by 4/3, which is 0.8 of it.
  const Line line = fit_line(std::vector<double>{0, 1, 2}, std::vector<double>{1.5, 3, 1.5});
  CHECK_THAT(line.slope, Catch::Matchers::WithinAbs(0, 1e-12));
  CHECK_THAT(line.at_zero, Catch::Matchers::WithinAbs(5.0 / 3, 1e-12));
  CHECK_THAT(line.worst_deviation, Catch::Matchers::WithinAbs(0.8, 1e-12));
}
