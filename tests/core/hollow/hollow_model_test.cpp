#include "core/hollow/hollow_model.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/hollow/cavity_drains.hpp"
#include "core/hollow/cavity_grid.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

using namespace contourd;
using testing::Approx;

constexpr Millimeters kCell{0.1};

HollowRequest request_for(models::Facets facets, const HollowSettings& settings, Elevation elevation = {}) {
  return {{testing::shared_index(std::move(facets)), elevation}, settings, {}, kCell};
}

// The cells of a print: masks by pixel centres, as high as wide.
class PrintedCells {
 public:
  PrintedCells(const StandingModel& model, std::shared_ptr<const SectionSource> removed, double cell_mm) {
    const Bounds& bounds = model.model->bounds();
    const auto cells = [&](double size) { return static_cast<std::int32_t>(std::ceil(size / cell_mm)) + 2; };
    display_ = {Pixels{cells(bounds.size_x())}, Pixels{cells(bounds.size_y())}, Micrometers{cell_mm * 1000}};
    PlateModel standing{{model.model}, {PixelMap::true_scale(display_, bounds.center())}, std::move(removed)};
    ContourEngine engine({std::move(standing)}, {.display = display_, .anti_aliasing = AntiAliasing::Off});
    for (std::int32_t slice = 0; slice < cells(bounds.size_z()) - 2; ++slice)
      slices_.push_back(engine.mask_at_z(Millimeters{bounds.min_z + (slice + 0.5) * cell_mm}));
  }

  [[nodiscard]] std::int32_t columns() const { return display_.width.count(); }
  [[nodiscard]] std::int32_t rows() const { return display_.height.count(); }
  [[nodiscard]] std::int32_t slices() const { return static_cast<std::int32_t>(slices_.size()); }
  [[nodiscard]] bool is_solid(std::int32_t column, std::int32_t row, std::int32_t slice) const {
    return 0 <= column && column < columns() && 0 <= row && row < rows() && 0 <= slice && slice < slices() &&
           slices_[static_cast<std::size_t>(slice)].row(row)[static_cast<std::size_t>(column)] > 0;
  }
  [[nodiscard]] std::int64_t solid_cells() const {
    std::int64_t cells = 0;
    for (const Mask& mask : slices_)
      cells += mask.lit_pixels();
    return cells;
  }
  // Returns the number of empty cells that a flood from outside does not reach.
  [[nodiscard]] std::int64_t trapped_cells() const {
    // With a border of a cell on all sides.
    const std::int32_t width = columns() + 2, height = rows() + 2, depth = slices() + 2;
    std::vector<char> reached(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                              static_cast<std::size_t>(depth));
    std::int64_t left = static_cast<std::int64_t>(reached.size()) - solid_cells();
    std::queue<std::array<std::int32_t, 3>> front;
    const auto reach = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
      if (x < 0 || x >= width || y < 0 || y >= height || z < 0 || z >= depth) return;
      if (is_solid(x - 1, y - 1, z - 1)) return;
      char& cell = reached[static_cast<std::size_t>((z * height + y) * width + x)];
      if (cell != 0) return;
      cell = 1;
      --left;
      front.push({x, y, z});
    };
    reach(0, 0, 0);
    while (!front.empty()) {
      const auto [x, y, z] = front.front();
      front.pop();
      reach(x - 1, y, z), reach(x + 1, y, z), reach(x, y - 1, z);
      reach(x, y + 1, z), reach(x, y, z - 1), reach(x, y, z + 1);
    }
    return left;
  }

 private:
  DisplayGeometry display_;
  std::vector<Mask> slices_;
};

models::Facets cup_and_ball() {
  // A block that a ball reaches into: solids that overlap.
  models::Facets ball = models::sphere(4, 24);
  for (Facet& facet : ball)
    for (Vertex& v : facet.vertices)
      v = {v.x + 3, v.y, v.z + 8};
  return models::together(models::box({-5, -4, 0}, {4, 4, 8}), ball);
}

}  // namespace

TEST_CASE("A cavity is as far from all sides of a block as its wall is thick") {
  const HollowRequest request =
      request_for(models::box({-6, -5, 1}, {6, 5, 9}), {.wall = Millimeters{2}, .hole = Millimeters{0}});
  const HollowedModel hollowed = hollow_model(request).value();
  CHECK(hollowed.cavities == 1);
  CHECK(hollowed.volume_mm3 == Approx(8 * 6 * 4).epsilon(1e-9));
  CHECK(hollowed.cell == kCell);
  Contours section;
  for (const double z : {1.05, 2.95, 7.05, 8.95, 20.0, -20.0}) {
    hollowed.removed->section_at(*to_nanometers(Millimeters{z}), section);
    CHECK(section.loops.empty());
  }
  hollowed.removed->section_at(*to_nanometers(Millimeters{6.95}), section);
  REQUIRE(section.loops.size() == 60);
  for (const Point& point : section.points) {
    CHECK(std::fabs(point.x) == Approx(4));
    CHECK(std::fabs(point.y) < 3 + 1e-9);
  }
}

TEST_CASE("Cavities are the cells farther from the outside than the wall, by all distances") {
  struct Row {
    models::Facets facets;
    double wall_mm, cell_mm;
  };
  const std::vector<Row> rows = {
      {models::sphere(4, 24), 1.0, 0.25},
      {models::cone(5, 8, 24), 1.13, 0.25},
      {cup_and_ball(), 1.5, 0.3},
      {models::gyroid_sphere(6, 9, 24), 0.6, 0.25},
      {models::lathe(std::vector<Point>{{0, 0}, {4, 0}, {4, 1}, {2, 3}, {4, 5}, {0, 9}}, 20), 0.5, 0.25}};
  for (const Row& row : rows) {
    HollowRequest request =
        request_for(row.facets, {.wall = Millimeters{row.wall_mm}, .hole = Millimeters{0}});
    request.finest = Millimeters{row.cell_mm};
    const HollowedModel hollowed = hollow_model(request).value();
    const PrintedCells whole(request.model, nullptr, row.cell_mm),
        hollow(request.model, hollowed.removed, row.cell_mm);
    const double limit = std::pow(row.wall_mm / row.cell_mm + 0.5, 2);
    const auto reach = static_cast<std::int32_t>(std::ceil(std::sqrt(limit)));
    std::int64_t expected = 0, wrong = 0, removed = 0;
    for (std::int32_t z = 0; z < whole.slices(); ++z)
      for (std::int32_t y = 0; y < whole.rows(); ++y)
        for (std::int32_t x = 0; x < whole.columns(); ++x) {
          if (!whole.is_solid(x, y, z)) continue;
          bool deep = true;
          for (std::int32_t c = -reach; c <= reach && deep; ++c)
            for (std::int32_t b = -reach; b <= reach && deep; ++b)
              for (std::int32_t a = -reach; a <= reach && deep; ++a)
                if (a * a + b * b + c * c < limit && !whole.is_solid(x + a, y + b, z + c)) deep = false;
          expected += deep;
          const bool gone = !hollow.is_solid(x, y, z);
          removed += gone;
          wrong += gone && !deep;
        }
    CHECK(wrong == 0);
    // Cells that are missing are in cavities too small to be made.
    if (static_cast<double>(expected) * std::pow(row.cell_mm, 3) > 2 * kLeastCavityMm3)
      CHECK(removed == expected);
    CHECK(static_cast<double>(removed) * std::pow(row.cell_mm, 3) == Approx(hollowed.volume_mm3));
  }
}

TEST_CASE("A hole at its lowest point opens every cavity", "[long]") {
  struct Row {
    models::Facets facets;
    Elevation elevation;
    std::size_t cavities;
  };
  const std::vector<Row> rows = {
      {models::box({0, 0, 0}, {12, 9, 9}), {}, 1},
      {models::box({0, 0, 0}, {12, 9, 9}), Elevation(testing::mm(5)), 1},
      {models::sphere(6, 30), Elevation(testing::mm(5)), 1},
      {models::sphere(6, 30), {}, 1},
      {models::together(models::box({0, 0, 0}, {9, 9, 9}), models::box({14, 0, 0}, {23, 9, 9})), {}, 2},
      {cup_and_ball(), {}, 1},
      {models::cone(8, 14, 40), Elevation(testing::mm(5)), 1},
  };
  for (const Row& row : rows) {
    const HollowRequest request =
        request_for(row.facets, {.wall = Millimeters{1.5}, .hole = Millimeters{2}}, row.elevation);
    const HollowedModel hollowed = hollow_model(request).value();
    CHECK(hollowed.cavities == row.cavities);
    REQUIRE(hollowed.holes.size() == row.cavities);
    CHECK(hollowed.closed == 0);
    CHECK(PrintedCells(request.model, hollowed.removed, 0.1).trapped_cells() == 0);
    const bool stands = row.elevation.above_plate() == Nanometers{};
    for (const Frustum& hole : hollowed.holes) {
      // The plate closes no hole of a model that stands on it.
      if (stands) {
        CHECK(hole.lower.z == hole.upper.z);
        CHECK(hole.lower.z - hole.lower_radius_mm > request.model.model->bounds().min_z + 1);
      }
    }
    HollowRequest closed = request;
    closed.settings.hole = Millimeters{0};
    const HollowedModel without = hollow_model(closed).value();
    CHECK(without.closed == row.cavities);
    CHECK(PrintedCells(request.model, without.removed, 0.1).trapped_cells() > 0);
  }
}

TEST_CASE("Both legs of an arch get a hole, and a bump in the floor none") {
  // Legs of 9 x 9 mm under a beam, the right one 2 mm shorter.
  const models::Facets arch =
      models::together({models::box({0, 0, 0}, {9, 9, 12}), models::box({16, 0, 2}, {25, 9, 12}),
                        models::box({0, 0, 11}, {25, 9, 20})});
  HollowRequest request = request_for(arch, {.wall = Millimeters{1.5}, .hole = Millimeters{2}});
  const HollowedModel hollowed = hollow_model(request).value();
  CHECK(hollowed.cavities == 1);
  REQUIRE(hollowed.holes.size() == 2);
  CHECK(hollowed.holes[0].lower.z == Approx(1.5 + 0.8).margin(0.11));
  CHECK(hollowed.holes[1].lower.z == Approx(3.5 + 0.8).margin(0.11));
  CHECK(hollowed.holes[0].lower.x < 9.5);
  CHECK(hollowed.holes[1].lower.x > 14.5);
  // The right leg begins 1.5 mm below the beam's floor: its share holds less than a cavity must.
  const models::Facets bump =
      models::together(models::box({0, 0, 9}, {25, 9, 20}), models::box({16, 0, 7.5F}, {25, 9, 12}));
  request = request_for(bump, {.wall = Millimeters{1.5}, .hole = Millimeters{2}});
  CHECK(hollow_model(request).value().holes.size() == 1);
}

TEST_CASE("A cavity that a hole of the job's opens gets no other") {
  HollowRequest request = request_for(models::box({0, 0, 0}, {12, 9, 9}), {.wall = Millimeters{1.5}});
  const std::vector<Frustum> through{{{6, 4, -1}, {6, 4, 3}, 1, 1}}, skin{{{6, 4, -1}, {6, 4, 1}, 1, 1}};
  request.holes = through;
  const HollowedModel opened = hollow_model(request).value();
  CHECK(opened.holes.empty());
  CHECK(opened.closed == 0);
  CHECK(PrintedCells(request.model, opened.removed, 0.1).trapped_cells() == 0);
  request.holes = skin;
  CHECK(hollow_model(request).value().holes.size() == 1);
}

TEST_CASE("Struts fill a cavity and leave it open from end to end", "[long]") {
  HollowRequest request = request_for(models::box({0, 0, 0}, {20, 20, 20}), {.wall = Millimeters{1.5}});
  const double empty = hollow_model(request).value().volume_mm3;
  request.settings.infill = InfillLattice{Millimeters{6}, Millimeters{1}};
  const HollowedModel filled = hollow_model(request).value();
  CHECK(filled.cavities == 1);
  CHECK(PrintedCells(request.model, filled.removed, 0.1).trapped_cells() == 0);
  // Four struts of a cube's diagonal each, less what they share where they meet.
  const double share = 4 * std::sqrt(3.0) * 6 * 3.14159 / 4 / (6 * 6 * 6);
  CHECK(1 - filled.volume_mm3 / empty == Approx(share).epsilon(0.15));
  // No strut begins in the air: every run of struts lies over solid, but for a cell at its rim.
  const PrintedCells cells(request.model, filled.removed, 0.1);
  std::int64_t islands = 0;
  for (std::int32_t z = 1; z < cells.slices() - 20; ++z)
    for (std::int32_t y = 20; y < cells.rows() - 20; ++y)
      for (std::int32_t x = 20; x < cells.columns() - 20; ++x) {
        if (!cells.is_solid(x, y, z)) continue;
        bool carried = false;
        for (std::int32_t b = -2; b <= 2; ++b)
          for (std::int32_t a = -2; a <= 2; ++a)
            carried = carried || cells.is_solid(x + a, y + b, z - 1);
        islands += !carried;
      }
  CHECK(islands == 0);
}

TEST_CASE("A model without room for a cavity keeps its holes") {
  HollowRequest request = request_for(models::box({0, 0, 0}, {9, 9, 3}), {.wall = Millimeters{1.5}});
  CHECK(hollow_model(request).value().cavities == 0);
  CHECK(hollow_model(request).value().removed == nullptr);
  const std::vector<Frustum> hole{{{4, 4, -1}, {4, 4, 2}, 1, 1}};
  request.holes = hole;
  Contours section;
  hollow_model(request).value().removed->section_at(testing::mm(1), section);
  CHECK(section.loops.size() == 1);
}

TEST_CASE("The grid around a model of any size is found at once") {
  for (const float size : {1e3F, 1e6F, 1e13F, 1e20F, 1e37F}) {
    const models::Facets plate = models::box({0, 0, 0}, {size, size, 5});
    const Bounds bounds = testing::shared_index(plate)->bounds();
    const CavityGrid grid = CavityGrid::around(bounds, kCell, kCell, kMostCavityCells);
    CHECK(static_cast<double>(grid.cells_in_slice()) * grid.slices <= kMostCavityCells);
    CHECK(grid.columns * grid.cell_mm >= static_cast<double>(size));
  }
}

TEST_CASE("Thin walls carry little of what is peeled off above them") {
  HollowRequest request = request_for(models::box({0, 0, 0}, {20, 20, 20}), {.wall = Millimeters{0.5}});
  // The walls' section is 20 * 20 - 19 * 19 mm2, that of the roof 20 * 20.
  CHECK(hollow_model(request).value().least_carrying == Approx(39.0 / 400).epsilon(0.02));
}

TEST_CASE("A search for cavities stops when asked, and refuses walls and holes thinner than two cells") {
  const HollowRequest request = request_for(models::sphere(6, 20), {.wall = Millimeters{1}});
  std::stop_source stop;
  stop.request_stop();
  CHECK(hollow_model(request, stop.get_token()) == std::nullopt);
  HollowRequest thin = request;
  thin.settings.wall = Millimeters{0.15};
  CHECK_THROWS_AS(hollow_model(thin), std::range_error);
  HollowRequest narrow = request;
  narrow.settings.hole = kCell * 1.9;
  CHECK_THROWS_AS(hollow_model(narrow), std::range_error);
}

TEST_CASE("A search for holes stops when asked") {
  // A cube of 8 cells in the grid's middle, in a solid that leaves the grid's border empty.
  const HollowRequest request = request_for(models::box({0, 0, 0}, {2, 2, 2}), {});
  const CavityGrid grid = CavityGrid::around(request.model.model->bounds(), kCell, kCell, kMostCavityCells);
  SolidColumns solid;
  REQUIRE(solid.sample(request.model.model, grid, kMostCavityEnds, {}) == SolidColumns::Failure::None);
  CavityBodies bodies(1);
  for (std::int32_t slice = 0; slice < grid.slices; ++slice) {
    std::vector<CavityRun> runs;
    for (std::uint16_t row = 7; row < 15 && 6 <= slice && slice < 14; ++row)
      runs.push_back({row, 7, 15});
    bodies.add_slice(runs);
  }
  bodies.finish();
  const auto find = [&](const std::stop_token& stop) {
    return find_drains(solid, bodies, bodies.basins(), grid, Millimeters{0.5}, true, stop);
  };
  CHECK(find({}).value().size() == 1);
  std::stop_source stop;
  stop.request_stop();
  CHECK_FALSE(find(stop.get_token()));
}

TEST_CASE("Cells grow until a thick wall and a large model fit", "[long]") {
  HollowRequest request = request_for(models::box({0, 0, 0}, {90, 90, 90}), {.wall = Millimeters{30}});
  const HollowedModel hollowed = hollow_model(request).value();
  CHECK(hollowed.cell.count() >= 30 / 250.0);
  CHECK(hollowed.volume_mm3 == Approx(30 * 30 * 30).epsilon(0.02));
  HollowRequest flat = request_for(models::box({0, 0, 0}, {1e-6F, 1e-6F, 1e-6F}), {.wall = Millimeters{30}});
  CHECK(hollow_model(flat).value().cavities == 0);
}
