#include "core/geometry/vertex_numbers.hpp"

#include "tests/catch.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

TEST_CASE("Equal vertices have equal numbers, different ones different numbers, without gaps") {
  CHECK(number_vertices({}).empty());
  const Facet facet{{Vertex{0, 1, 2}, Vertex{3, 4, 5}, Vertex{-0.0F, 1, 2}}};
  CHECK(number_vertices(std::vector<Facet>{facet}) == std::vector<Corners>{{0, 1, 0}});
  CHECK(is_degenerate({0, 1, 0}));
  CHECK_FALSE(is_degenerate({0, 1, 2}));
  std::uint32_t most = 0;
  for (const Corners& corners : number_vertices(models::box({0, 0, 0}, {1, 2, 3})))
    most = std::max({most, corners[0], corners[1], corners[2]});
  CHECK(most == 7);
}

TEST_CASE("A soup of facets has as many vertices as corners") {
  models::Dice dice(1);
  const models::Facets soup = models::soup(5000, 10, dice);
  const std::vector<Corners> corners = number_vertices(soup);
  for (std::uint32_t i = 0; i < soup.size(); ++i)
    REQUIRE(corners[i] == Corners{3 * i, 3 * i + 1, 3 * i + 2});
}
