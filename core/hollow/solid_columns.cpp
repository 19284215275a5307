#include "core/hollow/solid_columns.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/engine/contour_engine.hpp"

namespace contourd {
namespace {

// A place where a column's solid begins or ends.
struct ColumnEnd {
  std::uint32_t column;
  std::uint16_t slice;
};

// Collects the places where two slices differ, row by row.
class ColumnEnds {
 public:
  explicit ColumnEnds(const CavityGrid& grid) : before_(Pixels{grid.columns}, Pixels{grid.rows}) {}

  void add(const Mask& mask, std::int32_t slice) {
    const auto width = static_cast<std::size_t>(mask.width().count());
    for (std::int32_t row = 0; row < mask.height().count(); ++row) {
      const std::span<const std::uint8_t> now = mask.row(row);
      const std::span<std::uint8_t> before = before_.row(row);
      auto [a, b] = std::ranges::mismatch(now, before);
      while (a != now.end()) {
        const auto column = static_cast<std::size_t>(a - now.begin());
        ends_.push_back({static_cast<std::uint32_t>(static_cast<std::size_t>(row) * width + column),
                         static_cast<std::uint16_t>(slice)});
        *b = *a;
        std::tie(a, b) = std::mismatch(a + 1, now.end(), b + 1);
      }
    }
  }
  [[nodiscard]] std::span<const ColumnEnd> all() const { return ends_; }

 private:
  Mask before_;
  std::vector<ColumnEnd> ends_;
};

}  // namespace

SolidColumns::Failure SolidColumns::sample(std::shared_ptr<const HeightIndex> model, const CavityGrid& grid,
                                           std::size_t most_ends, const std::stop_token& stop) {
  const DisplayGeometry display = grid.display();
  PlateModel standing{{std::move(model)}, {PixelMap::true_scale(display, grid.center)}};
  std::vector<PlateModel> models;
  models.push_back(std::move(standing));
  ContourEngine engine(std::move(models), {.display = display, .anti_aliasing = AntiAliasing::Off});
  ColumnEnds found(grid);
  solid_cells_.clear();
  for (std::int32_t slice = 0; slice < grid.slices; ++slice) {
    if (stop.stop_requested()) return Failure::Stopped;
    const Mask& mask = engine.mask_at_z(Millimeters{grid.bottom_of(slice) + grid.cell_mm / 2});
    found.add(mask, slice);
    solid_cells_.push_back(static_cast<std::uint32_t>(mask.lit_pixels()));
    if (found.all().size() > most_ends) return Failure::TooIntricate;
  }
  found.add(Mask(display.width, display.height), grid.slices);

  // Sort by column; the ends of a column stay in order.
  starts_.assign(grid.cells_in_slice() + 2, 0);
  for (const ColumnEnd& end : found.all())
    ++starts_[end.column + 2];
  for (std::size_t i = 2; i < starts_.size(); ++i)
    starts_[i] += starts_[i - 1];
  ends_.resize(found.all().size());
  for (const ColumnEnd& end : found.all())
    ends_[starts_[end.column + 1]++] = end.slice;
  starts_.pop_back();
  return Failure::None;
}

}  // namespace contourd
