#include "daemon/placement/plate_arrangement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/plate/plate_collision.hpp"
#include "core/plate/plate_packing.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// A thousandth of a millimetre: the rounding of float coordinates, far below a pixel.
constexpr double kRoundingMm = 1e-3;

// Returns the centres of the copies in a grid around the position, as near to a square as the plate allows.
std::vector<Point> grid_of_copies(const ModelToPlace& model, const BuildVolume& volume, double gap_mm) {
  const Bounds& bounds = model.model->bounds();
  const double pitch_x = bounds.size_x() + gap_mm, pitch_y = bounds.size_y() + gap_mm;
  const double columns_that_fit = std::fmax(1, std::floor((volume.width_mm() + gap_mm) / pitch_x));
  const double rows_that_fit = std::fmax(1, std::floor((volume.depth_mm() + gap_mm) / pitch_y));
  if (model.copies > columns_that_fit * rows_that_fit) {
    throw JobRefused(
        fmt::format("{} copies of {:.2f} x {:.2f} mm do not fit on the plate ({:.2f} x {:.2f} mm); there is "
                    "room for {:.0f}",
                    model.copies, bounds.size_x(), bounds.size_y(), volume.width_mm(), volume.depth_mm(),
                    columns_that_fit * rows_that_fit));
  }
  const double square = std::ceil(std::sqrt(model.copies * pitch_y / pitch_x));
  const double fewest_columns = std::ceil(model.copies / rows_that_fit);
  const double columns =
      std::fmin(std::fmin(columns_that_fit, model.copies), std::fmax(fewest_columns, square));
  const double rows = std::ceil(model.copies / columns);
  std::vector<Point> centers;
  for (int copy = 0; copy < model.copies; ++copy) {
    const double column = std::fmod(copy, columns), row = std::floor(copy / columns);
    centers.push_back({model.position->x.count() + (column - (columns - 1) / 2) * pitch_x,
                       model.position->y.count() + ((rows - 1) / 2 - row) * pitch_y});
  }
  return centers;
}

// Finds room for the models without a position.
class RoomFinder {
 public:
  RoomFinder(const std::vector<ModelToPlace>& models, const BuildVolume& volume, double gap_mm)
      : models_(models),
        volume_(volume),
        packing_(volume.display.width, volume.display.height,
                 Pixels{static_cast<std::int32_t>(std::ceil(gap_mm / volume.pitch_mm()))}) {}

  void place(Arrangement& arrangement) {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      if (!models_[i].position) {
        free.push_back(i);
        continue;
      }
      for (const Point& center : arrangement[i])
        occupy(models_[i], center);
    }
    // Places the deepest models first, since the others fit beside them.
    std::stable_sort(free.begin(), free.end(), [this](std::size_t a, std::size_t b) {
      return models_[a].model->bounds().size_y() > models_[b].model->bounds().size_y();
    });
    for (const std::size_t i : free) {
      for (int copy = 0; copy < models_[i].copies; ++copy)
        places_.push_back({i, find_room(i, copy)});
    }
    const bool alone = free.size() == models_.size();
    const auto [right, back] = alone ? slack_beside_all() : std::tuple<std::int64_t, std::int64_t>(0, 0);
    for (const auto& [i, place] : places_) {
      const Bounds& bounds = models_[i].model->bounds();
      arrangement[i].push_back(
          {from_middle(place.left + right / 2, volume_.display.width) + bounds.size_x() / 2,
           from_middle(place.front + back / 2, volume_.display.height) + bounds.size_y() / 2});
    }
  }

 private:
  struct Place {
    std::size_t model;
    PlateRectangle rectangle;
  };

  // Returns the number of pixels that cover the length, not counting an excess from the rounding of floats.
  [[nodiscard]] std::int64_t pixels_for(double length_mm) const {
    return std::max<std::int64_t>(
        1, static_cast<std::int64_t>(std::ceil((length_mm - kRoundingMm) / volume_.pitch_mm())));
  }
  [[nodiscard]] double from_middle(std::int64_t line, Pixels size) const {
    return (static_cast<double>(line) - size.count() / 2.0) * volume_.pitch_mm();
  }

  void occupy(const ModelToPlace& model, const Point& center) {
    const auto line = [this](double from_middle_mm, Pixels size) {
      return static_cast<std::int64_t>(std::floor(from_middle_mm / volume_.pitch_mm() + size.count() / 2.0));
    };
    const Bounds& bounds = model.model->bounds();
    // One more pixel each way, since an edge may lie within a pixel.
    packing_.occupy({line(center.x - bounds.size_x() / 2, volume_.display.width),
                     line(center.y - bounds.size_y() / 2, volume_.display.height),
                     pixels_for(bounds.size_x()) + 1, pixels_for(bounds.size_y()) + 1});
  }

  PlateRectangle find_room(std::size_t number, int copy) {
    const ModelToPlace& model = models_[number];
    const Bounds& bounds = model.model->bounds();
    const auto place = packing_.find_room(pixels_for(bounds.size_x()), pixels_for(bounds.size_y()));
    if (place) return *place;
    throw NoRoomOnPlate(
        fmt::format("there is no room on the plate ({:.2f} x {:.2f} mm) for {}{} ({:.2f} x {:.2f} mm) beside "
                    "the others",
                    volume_.width_mm(), volume_.depth_mm(), model.name,
                    model.copies > 1 ? fmt::format(", copy {} of {}", copy + 1, model.copies) : "",
                    bounds.size_x(), bounds.size_y()),
        number);
  }

  // Returns the number of pixels that stay free to the right of all models, and at the back of the plate.
  [[nodiscard]] std::tuple<std::int64_t, std::int64_t> slack_beside_all() const {
    std::int64_t right = 0, back = 0;
    for (const auto& [i, place] : places_) {
      right = std::max(right, place.left + place.width);
      back = std::max(back, place.front + place.depth);
    }
    return {volume_.display.width.count() - right, volume_.display.height.count() - back};
  }

  const std::vector<ModelToPlace>& models_;
  const BuildVolume& volume_;
  PlatePacking packing_;
  std::vector<Place> places_;
};

std::string copy_name(const ModelToPlace& model, std::size_t copy) {
  return model.copies > 1 ? fmt::format("{} (copy {})", model.name, copy + 1) : model.name;
}

void check_inside(const ModelToPlace& model, std::size_t copy, const Point& center,
                  const BuildVolume& volume) {
  const Bounds& bounds = model.model->bounds();
  std::string edges;
  const auto check = [&](double over_mm, const char* edge) {
    if (over_mm <= kRoundingMm) return;
    edges += fmt::format("{}{:.2f} mm over the {} edge", edges.empty() ? "" : " and ", over_mm, edge);
  };
  const double half_x = bounds.size_x() / 2, half_y = bounds.size_y() / 2;
  check(half_x - center.x - volume.width_mm() / 2, "left");
  check(half_x + center.x - volume.width_mm() / 2, "right");
  check(half_y - center.y - volume.depth_mm() / 2, "front");
  check(half_y + center.y - volume.depth_mm() / 2, "back");
  if (edges.empty()) return;
  throw JobRefused(
      fmt::format("{} ({:.2f} x {:.2f} mm, its centre {} mm from the plate's) reaches {} of the "
                  "build area ({:.2f} x {:.2f} mm)",
                  copy_name(model, copy), bounds.size_x(), bounds.size_y(), coordinates({center.x, center.y}),
                  edges, volume.width_mm(), volume.depth_mm()));
}

}  // namespace

Arrangement arrange(const std::vector<ModelToPlace>& models, const BuildVolume& volume, Millimeters gap) {
  Arrangement arrangement(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (models[i].position) arrangement[i] = grid_of_copies(models[i], volume, gap.count());
  }
  RoomFinder(models, volume, gap.count()).place(arrangement);
  return arrangement;
}

void check_arrangement(const std::vector<ModelToPlace>& models, const Arrangement& arrangement,
                       const BuildVolume& volume, Nanometers layer) {
  struct Copy {
    const ModelToPlace& model;
    std::size_t number;
    PlacedModel placed;
  };
  std::vector<Copy> copies;
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (std::size_t copy = 0; copy < arrangement[i].size(); ++copy) {
      check_inside(models[i], copy, arrangement[i][copy], volume);
      copies.push_back({models[i], copy, {models[i].standing(), arrangement[i][copy]}});
    }
  }
  for (std::size_t b = 0; b < copies.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto collision = find_collision(copies[a].placed, copies[b].placed, volume.display, layer);
      if (!collision) continue;
      throw JobRefused(fmt::format(
          "{} and {} collide: at a height of {:.3f} mm both are at {} mm from the plate's centre",
          copy_name(copies[a].model, copies[a].number), copy_name(copies[b].model, copies[b].number),
          to_millimeters(collision->height).count(), coordinates({collision->place.x, collision->place.y})));
    }
  }
}

std::string growth_warning(const std::vector<ModelToPlace>& models, const Arrangement& arrangement,
                           const BuildVolume& volume, Micrometers growth) {
  const double growth_mm = to_millimeters(growth).count();
  double beyond = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Bounds& bounds = models[i].model->bounds();
    for (const Point& center : arrangement[i]) {
      const double reach_x = std::fabs(center.x) + bounds.size_x() / 2;
      const double reach_y = std::fabs(center.y) + bounds.size_y() / 2;
      beyond = std::max(
          {beyond, reach_x + growth_mm - volume.width_mm() / 2, reach_y + growth_mm - volume.depth_mm() / 2});
    }
  }
  if (growth_mm <= 0 || beyond <= kRoundingMm) return "";
  return fmt::format(
      "the resin's growth_um moves contours {:.0f} um beyond the display, where they are cut off",
      beyond * 1000);
}

}  // namespace contourd
