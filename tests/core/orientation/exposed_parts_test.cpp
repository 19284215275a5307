#include "core/orientation/exposed_parts.hpp"

#include <algorithm>
#include <cmath>

#include "core/orientation/rated_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

// Returns the area that counts of the facets that face this direction.
double exposed_mm2(const models::Facets& facets, const Direction& direction) {
  const std::vector<double> parts = exposed_parts(facets);
  double sum = 0;
  for (std::size_t f = 0; f < facets.size(); ++f)
    sum += std::max(0.0, dot(area_of(facets[f]), direction)) * (parts.empty() ? 1 : parts[f]);
  return sum;
}

constexpr Direction kUp{0, 0, 1}, kDown{0, 0, -1};

}  // namespace

TEST_CASE("All of a single body counts, and of bodies that are apart") {
  CHECK(exposed_parts(models::box({0, 0, 0}, {10, 10, 10})).empty());
  CHECK(exposed_parts(together(models::box({0, 0, 0}, {10, 10, 10}), models::box({11, 0, 0}, {20, 10, 10})))
            .empty());
}

TEST_CASE("Faces at which bodies touch do not count") {
  const models::Facets stacked =
      together(models::box({0, 0, 0}, {20, 20, 5}), models::box({5, 5, 5}, {15, 15, 9}));
  CHECK(exposed_mm2(stacked, kDown) == 400);
  CHECK(std::abs(exposed_mm2(stacked, kUp) - 400) < 20);  // of 50 points on each facet
}

TEST_CASE("Faces within another body do not count") {
  CHECK(exposed_mm2(together(models::box({0, 0, 0}, {20, 20, 5}), models::box({5, 5, 3}, {15, 15, 9})),
                    kDown) == 400);
  const models::Facets nested =
      together(models::box({0, 0, 0}, {20, 20, 20}), models::box({5, 5, 5}, {15, 15, 15}));
  CHECK(exposed_mm2(nested, kUp) == 400);
  CHECK(exposed_mm2(nested, {1, 0, 0}) == 400);
}

TEST_CASE("Faces that lie on each other count once") {
  const models::Facets crossing =
      together({models::box({0, 8, 0}, {20, 12, 4}), models::box({8, 0, 0}, {12, 20, 4})});
  CHECK(std::abs(exposed_mm2(crossing, kUp) - 144) < 8);  // of 10 points on each facet
  CHECK(std::abs(exposed_mm2(crossing, kDown) - 144) < 8);
}

TEST_CASE("The walls of a cavity count") {
  const models::Facets hollow =
      together(models::box({0, 0, 0}, {20, 20, 20}), models::inverted(models::box({5, 5, 5}, {15, 15, 15})));
  CHECK(exposed_mm2(hollow, kUp) == 500);
}

TEST_CASE("A facet of a soup takes a bounded time") {
  models::Facets soup;
  for (int i = 0; i < 60'000; ++i) {
    const float x = static_cast<float>(i % 300) / 10, y = static_cast<float>(i / 300) / 10;
    soup.push_back({{{{x, y, 0}, {x + 5, y, 20}, {x, y + 5, 50}}}});
  }
  CHECK(exposed_parts(soup).size() == soup.size());
}
