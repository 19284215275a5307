#include "core/model/uneven_faces.hpp"

#include "core/layers/layers.hpp"
#include "core/model/placement.hpp"
#include "core/model/standing_model.hpp"
#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/random_shapes.hpp"

namespace {

// A place on the plane: a vertex of a grid, in cells.
struct GridPoint {
  int x, y;
};

constexpr int kCells = 6;
constexpr float kCellMm = 4;

// Returns a square slab of 24 x 24 mm whose faces are grids. top_at and bottom_at give their heights.
template <typename Height>
models::Facets slab(const Height& bottom_at, const Height& top_at) {
  models::Facets facets;
  const auto vertex = [](GridPoint at, const Height& height) {
    return Vertex{static_cast<float>(at.x) * kCellMm, static_cast<float>(at.y) * kCellMm, height(at)};
  };
  const auto add = [&](const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) {
    facets.push_back({{a, b, c}});
    facets.push_back({{a, c, d}});
  };
  for (int x = 0; x < kCells; ++x) {
    for (int y = 0; y < kCells; ++y) {
      const GridPoint a{x, y}, b{x + 1, y}, c{x + 1, y + 1}, d{x, y + 1};
      add(vertex(a, top_at), vertex(b, top_at), vertex(c, top_at), vertex(d, top_at));
      add(vertex(a, bottom_at), vertex(d, bottom_at), vertex(c, bottom_at), vertex(b, bottom_at));
    }
  }
  const auto add_wall = [&](GridPoint from, GridPoint to) {
    add(vertex(from, bottom_at), vertex(to, bottom_at), vertex(to, top_at), vertex(from, top_at));
  };
  for (int i = 0; i < kCells; ++i) {
    add_wall({i, 0}, {i + 1, 0});
    add_wall({kCells, i}, {kCells, i + 1});
    add_wall({i + 1, kCells}, {i, kCells});
    add_wall({0, i + 1}, {0, i});
  }
  return facets;
}

// Returns a height that differs by up to 2 nm from place to place.
std::function<float(GridPoint)> uneven(double z) {
  return [z](GridPoint at) { return static_cast<float>(z + 1e-6 * ((at.x * 7 + at.y * 5) % 5 - 2)); };
}

std::function<float(GridPoint)> level(float z) {
  return [z](GridPoint) { return z; };
}

double area_at(const models::Facets& facets, double z) {
  return testing::signed_area(testing::contours_of(facets, z));
}

constexpr double kFaceMm2 = 24 * 24;

bool is_nothing_or_all(double area_mm2) {
  // A hundredth of a square millimetre: the walls of a turned slab lean by some nanometres.
  return std::fabs(area_mm2) < 0.01 || std::fabs(area_mm2 - kFaceMm2) < 0.01;
}

}  // namespace

TEST_CASE("A cut that meets an uneven flat face takes it for below, the whole face at once") {
  const models::Facets slab_up = slab(level(0), uneven(2.025)), slab_down = slab(uneven(2.025), level(4));
  CHECK(area_at(slab_up, 2.025) == 0);
  CHECK(area_at(slab_down, 2.025) == Approx(kFaceMm2));
  for (int nm = -4; nm <= 4; ++nm) {
    CAPTURE(nm);
    CHECK(is_nothing_or_all(area_at(slab_up, 2.025 + 1e-6 * nm)));
    CHECK(is_nothing_or_all(area_at(slab_down, 2.025 + 1e-6 * nm)));
  }
  CHECK(area_at(slab_up, 2.0249) == Approx(kFaceMm2));
  CHECK(area_at(slab_down, 2.0249) == 0);
}

TEST_CASE("An uneven step is cut as a level one would be, and leaves what stands on it") {
  const models::Facets stairs =
      models::together(slab(level(0), uneven(2.025)), models::box({8, 8, 1}, {12, 12, 5}));
  CHECK(area_at(stairs, 2.025) == Approx(16));
}

TEST_CASE("A slab that is turned back upright has whole faces") {
  CHECK(rc::check([] {
    // Some layers and half a layer thick, tilted by the exporting program, and turned back by ours.
    models::Facets facets =
        slab(level(0), level(static_cast<float>(0.05 * static_cast<double>(draw(1, 200)) + 0.025)));
    const Direction up{draw_real(-1, 1), draw_real(-1, 1), draw_real(0.1, 1)};
    const auto [right, back, upwards] = axes_with_up(up);
    const float x = static_cast<float>(draw_real(-80, 80)), y = static_cast<float>(draw_real(-80, 80));
    models::translate(facets, x, y, 0);
    for (Facet& facet : facets) {
      for (auto& [a, b, c] : facet.vertices) {
        const double u = a, v = b, w = c;
        a = static_cast<float>(right.x * u + back.x * v + upwards.x * w);
        b = static_cast<float>(right.y * u + back.y * v + upwards.y * w);
        c = static_cast<float>(right.z * u + back.z * v + upwards.z * w);
      }
    }
    Orientation turn;
    turn.up = up;
    orient(facets, turn);
    const HeightIndex index(facets);
    const Bounds& bounds = index.bounds();
    for (int i = 0; i <= 20; ++i) {
      for (const double face : {bounds.min_z, bounds.max_z - 40e-6}) {
        const double z = face + 2e-6 * i;
        RC_ASSERT(is_nothing_or_all(area_at(facets, z)));
      }
    }
  }));
}

TEST_CASE("Pins of one height end in the same layer, if rounding lets their heights differ or not") {
  const float higher = std::nextafter(2.025F, 3.0F);
  const models::Facets pins =
      models::together(models::box({0, 0, 0}, {1, 1, 2.025F}), models::box({20, 0, 0}, {21, 1, higher}));
  for (const double z : {2.0249, double{2.025F} - 1e-10, double{2.025F}, 2.02500005, double{higher}}) {
    CAPTURE(z);
    const double area = area_at(pins, z);
    CHECK((area == 0 || area == Approx(2)));
  }
}

TEST_CASE("Cuts of a model without uneven faces are where they are asked for") {
  const models::Facets slope =
      slab(level(0), std::function([](GridPoint at) { return 2.0F + 0.0001F * static_cast<float>(at.x); }));
  for (const models::Facets& facets :
       {models::box({0, 0, 0}, {30, 20, 10}), models::sphere(7, 14), models::globe(5, 200, 64), slope,
        models::together(models::box({0, 0, 0}, {9, 9, 1}), models::box({3, 3, 1.0001F}, {6, 6, 3}))}) {
    const HeightIndex index(facets);
    CHECK(index.end_z() == index.bounds().max_z);
    for (const Facet& facet : facets) {
      for (const Vertex& vertex : facet.vertices) {
        for (const double z : {std::nextafter(double{vertex.z}, -1e3), double{vertex.z}, vertex.z + 1e-9})
          REQUIRE(index.cut_at(z) == z);
      }
    }
  }
}

TEST_CASE("A wall lower than the rounding of coordinates is no flat face") {
  // The wall of a plate of 10 nm, 100 mm from the origin; the plate's faces are farther apart than that.
  models::Facets wall;
  wall.push_back({{Vertex{100, 0, 0}, Vertex{100, 0.00001F, 0}, Vertex{100, 0, 0.00001F}}});
  const HeightIndex index(wall);
  CHECK(index.cut_at(0.000005) == 0.000005);
}

TEST_CASE("Far from the origin, no more than half a micrometre counts as rounding") {
  models::Facets slope =
      slab(level(0), std::function([](GridPoint at) { return 2.0F + 0.001F * static_cast<float>(at.x); }));
  models::translate(slope, 4e6F, 0, 0);
  const HeightIndex index(slope);
  CHECK(index.cut_at(2.0005) == 2.0005);
}

TEST_CASE("A model whose uneven top lies at the height of a cut has no layer there") {
  const StandingModel model{std::make_shared<const HeightIndex>(slab(level(0), uneven(2.025)))};
  const LayerStack layers = layers_for(model.top(), Nanometers{50'000});
  CHECK(layers.count == 40);
  const StandingModel nothing{std::make_shared<const HeightIndex>(models::Facets{})};
  CHECK(nothing.top() == Millimeters{});
  const StandingModel higher{std::make_shared<const HeightIndex>(slab(level(0), uneven(2.0251)))};
  CHECK(layers_for(higher.top(), Nanometers{50'000}).count == 41);
}
