#include "core/overhangs/surfaces_beneath.hpp"

#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"

TEST_CASE("A surface that faces down is found at its height above the plate, one that faces up is not") {
  const SupportRequest request = testing::held_request(models::box({-2, -2, 0}, {2, 2, 1}), 5);
  const std::vector<SurfacePlace> places{
      {{1, 1}, 4.9, 5.1, 0.2}, {{1, 1}, 5.9, 6.1, 0.2}, {{3, 1}, 4.9, 5.1, 0.2}, {{2.1, 1}, 4.9, 5.1, 0.2}};
  const auto surfaces = surfaces_beneath(request.models, request.display, places);
  REQUIRE(surfaces.size() == 4);
  REQUIRE(surfaces[0]);
  CHECK(surfaces[0]->z_mm == 5);
  CHECK(surfaces[0]->outward == Direction{0, 0, -1});
  CHECK_FALSE(surfaces[1]);
  CHECK_FALSE(surfaces[2]);
  CHECK(surfaces[3]);
}

TEST_CASE("Places searched together find the same surfaces as one by one, in every copy") {
  SupportRequest request = testing::held_request(models::sphere(5, 40), 5);
  request.models[0].copies.push_back(PixelMap::true_scale(request.display, {-14, 3}));
  std::vector<SurfacePlace> places;
  for (int i = 0; i < 400; ++i)
    places.push_back({{-5 + i % 20 * 1.2, -5 + i / 20 * 0.5}, 4, 10, 0.2});
  const auto together = surfaces_beneath(request.models, request.display, places);
  std::size_t found = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto alone = surfaces_beneath(request.models, request.display, std::span(places).subspan(i, 1));
    REQUIRE(together[i].has_value() == alone[0].has_value());
    if (!alone[0]) continue;
    ++found;
    CHECK(together[i]->z_mm == alone[0]->z_mm);
    CHECK(together[i]->outward == alone[0]->outward);
    const Point middle = places[i].at.x < 7 ? Point{0, 0} : Point{14, -3};
    const double off = std::hypot(places[i].at.x - middle.x, places[i].at.y - middle.y);
    if (off > 4.5) continue;
    // Facets of 0.25 mm are within 2 um of a sphere of 5 mm, and rise by 1 in 0.5 at 4.5 mm.
    CHECK(std::fabs(together[i]->z_mm - (10 - std::sqrt(25 - off * off))) < 0.01);
  }
  CHECK(found > 100);
}
