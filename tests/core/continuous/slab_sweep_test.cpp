#include "core/continuous/slab_sweep.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

constexpr Nanometers kSlab{250'000};

std::vector<RiseSlab> slabs_of(ContourEngine& engine, Nanometers top, Micrometers growth = {}) {
  StopCheck never;
  return sweep_slabs(engine, {kCoarseDisplay, top, kSlab, growth}, never);
}
std::vector<RiseSlab> slabs_of(models::Facets facets, Nanometers top) {
  ContourEngine engine = engine_for(std::move(facets), {kCoarseDisplay});
  return slabs_of(engine, top);
}

models::Facets column(float radius, float low, float high) {
  const std::vector<Point> profile{{0, low}, {radius, low}, {radius, high}, {0, high}};
  return models::lathe(profile, 64);
}

// Returns the widest distance of a lit pixel's middle from a dark pixel's, by trying all pairs.
double distance_by_pairs(const Mask& mask) {
  std::vector<Point> rim;
  const std::int32_t width = mask.width().count(), height = mask.height().count();
  const auto is_lit = [&](std::int32_t x, std::int32_t y) {
    return x >= 0 && y >= 0 && x < width && y < height && mask.row(y)[static_cast<std::size_t>(x)] > 0;
  };
  const auto is_rim = [&](std::int32_t x, std::int32_t y) {
    return !is_lit(x, y) && (is_lit(x - 1, y) || is_lit(x + 1, y) || is_lit(x, y - 1) || is_lit(x, y + 1));
  };
  for (std::int32_t y = -1; y <= height; ++y)
    for (std::int32_t x = -1; x <= width; ++x)
      if (is_rim(x, y)) rim.push_back({double(x), double(y)});
  double widest = 0;
  for (std::int32_t y = 0; y < height; y += 2) {
    for (std::int32_t x = 0; x < width; x += 2) {
      if (!is_lit(x, y)) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Point& dark : rim)
        nearest = std::min(nearest, std::hypot(dark.x - x, dark.y - y));
      widest = std::max(widest, nearest);
    }
  }
  return widest * to_millimeters(kCoarseDisplay.pixel_pitch).count();
}

const RiseSlab& slab_at(const std::vector<RiseSlab>& slabs, Nanometers height) {
  return *std::ranges::upper_bound(slabs, height, {}, &RiseSlab::top);
}

}  // namespace

TEST_CASE(
    "Slabs are as thick as the gel gap, a hundred micrometres and a thousandth of the print, in layers") {
  const Nanometers layer{30'000};
  CHECK(slab_thickness(mm(10), layer, Micrometers{50}) == Nanometers{120'000});
  CHECK(slab_thickness(mm(10), layer, Micrometers{134.2}) == Nanometers{150'000});
  CHECK(slab_thickness(mm(200), layer, Micrometers{50}) == Nanometers{210'000});
}

TEST_CASE("Slabs of a cylinder reach its top and have its distance") {
  const std::vector<RiseSlab> slabs = slabs_of(column(6, 0, 5.1F), Nanometers{5'100'000});
  REQUIRE(slabs.size() == 20);
  CHECK(slabs.back().top == Nanometers{5'100'000});
  for (const RiseSlab& slab : slabs) {
    CHECK(slab.distance.count() >= 6 / std::numbers::sqrt2 * 0.99);
    CHECK(slab.distance.count() <= 6 / std::numbers::sqrt2 + 0.6);
  }
}

TEST_CASE("A plate thinner than a slab, between two cuts, counts in its slab only") {
  const std::vector<RiseSlab> slabs =
      slabs_of(models::together(column(2, 0, 5), column(8, 2.6F, 2.62F)), mm(5));
  for (const RiseSlab& slab : slabs) {
    CAPTURE(slab.top.count());
    CHECK(slab.distance.count() > (slab.top == Nanometers{2'750'000} ? 5 : 1.4));
    CHECK(slab.distance.count() < (slab.top == Nanometers{2'750'000} ? 6.3 : 2));
  }
}

TEST_CASE("The distance of a slab is never below that of a mask between its cuts") {
  const double sine = std::sin(0.5), cosine = std::cos(0.5);
  const std::vector<Point> hourglass{{0, 0}, {9, 0}, {2, 4}, {8, 8}, {0, 8}};
  models::Facets leaning = models::box({-7, -3, -2}, {7, 3, 2});
  for (Facet& facet : leaning)
    for (Vertex& vertex : facet.vertices)
      vertex = {static_cast<float>(vertex.x * cosine - vertex.z * sine), vertex.y,
                static_cast<float>(vertex.x * sine + vertex.z * cosine)};
  for (const models::Facets& facets : {models::lathe(hourglass, 48), models::cone(9, 8, 48), leaning,
                                       models::gyroid_sphere(5, 5, 40), models::globe(6, 12, 24)}) {
    ContourEngine engine = engine_for(facets, {kCoarseDisplay});
    const Nanometers top = *to_nanometers(Millimeters{engine.model().bounds().size_z()});
    const std::vector<RiseSlab> slabs = slabs_of(engine, top);
    for (int part = 1; part < 20; ++part) {
      const Nanometers height = top * part / 20 + Nanometers{77'777};
      if (height >= top) continue;
      const RiseSlab& slab = slab_at(slabs, height);
      CAPTURE(facets.size(), height.count());
      (void)engine.mask_at(height);
      // The circle around an area may be narrower than its distance by pixels.
      CHECK(slab.distance.count() * std::numbers::sqrt2 + 0.2 >= distance_by_pairs(engine.coverage()));
    }
  }
}

TEST_CASE("A cup fills like a disc, whether the plate or its floor closes it") {
  const auto tube = [](float low, float high) {
    const std::vector<Point> inside{{0, low}, {6, low}, {6, high}, {0, high}};
    return models::together(column(9, 0, 5), models::inverted(models::lathe(inside, 64)));
  };
  const std::vector<RiseSlab> on_plate = slabs_of(tube(0, 4), mm(5)), on_floor = slabs_of(tube(1, 5), mm(5));
  CHECK(on_plate[8].distance.count() > 6);
  CHECK(on_floor[8].distance.count() > 6);
}

TEST_CASE("A frame on a leg, around a hole that leads outside beneath, fills from both rims") {
  const models::Facets frame =
      models::together({models::box({-9, -9, 2}, {9, -6, 5}), models::box({-9, 6, 2}, {9, 9, 5}),
                        models::box({-9, -9, 2}, {-6, 9, 5}), models::box({6, -9, 2}, {9, 9, 5})});
  const std::vector<RiseSlab> slabs =
      slabs_of(models::together(frame, models::box({-9, -0.5F, 0}, {-6, 0.5F, 2.5F})), mm(5));
  // The corners of the frame are wider than its sides.
  CHECK(slabs[15].distance.count() < 3);
  CHECK(slabs[15].distance.count() >= 1.5);
  // On the plate it fills from outside only.
  for (const RiseSlab& slab : slabs_of(models::together(frame, models::box({-9, -9, 0}, {9, 9, 2})), mm(5)))
    CHECK(slab.distance.count() > 8);
}

TEST_CASE("A slab whose mask takes too long is not known") {
  ContourEngine engine = engine_for(column(6, 0, 2), {kCoarseDisplay});
  StopCheck never;
  for (const RiseSlab& slab :
       sweep_slabs(engine, {kCoarseDisplay, mm(2), kSlab, {}, std::chrono::nanoseconds{0}}, never))
    CHECK(std::isinf(slab.distance.count()));
}

TEST_CASE("A sweep of slabs can be stopped") {
  ContourEngine engine = engine_for(column(6, 0, 5), {kCoarseDisplay});
  int asked = 0;
  StopCheck stop([&] { return ++asked == 3; });
  CHECK_THROWS_AS(sweep_slabs(engine, {kCoarseDisplay, mm(5), kSlab, {}}, stop), ComputationStopped);
  CHECK(asked == 3);
}
