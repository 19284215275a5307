#include "core/clearance/clearance_field.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Lower bound for the side of a cell. A cell's height is its side times kSlant, so that a diagonal step to
// the level beneath is no flatter than 45 degrees.
constexpr double kLeastCell_mm = 0.3;
constexpr double kSlant = 1.4143;
constexpr double kUnit = ClearanceField::kUnit_mm;
// The squared distance that means kGreatest_mm or more, in squared units; the sum of two of them fits into 16
// bits.
constexpr std::uint16_t kFar = 22500;
static_assert(kFar * kUnit * kUnit >= ClearanceField::kGreatest_mm * ClearanceField::kGreatest_mm - 1e-9);

// Returns the squared gap between a cell's middle and the box of a cell, indexed by how many cells away that
// is.
std::vector<std::uint16_t> gap_squares(double cell_mm) {
  std::vector<std::uint16_t> squares{0};
  for (double away = 1;; ++away) {
    const double gap = (away - 0.5) * cell_mm / kUnit;
    if (gap * gap >= kFar) return squares;
    squares.push_back(static_cast<std::uint16_t>(gap * gap));
  }
}

// Returns the square roots of all numbers up to kFar, rounded down.
const std::vector<std::uint8_t>& roots() {
  static const std::vector<std::uint8_t> all = [] {
    std::vector<std::uint8_t> made(kFar + 1);
    for (std::uint32_t square = 0, root = 0; square <= kFar; ++square) {
      if ((root + 1) * (root + 1) == square) ++root;
      made[square] = static_cast<std::uint8_t>(root);
    }
    return made;
  }();
  return all;
}

void lower_squares(std::uint16_t* into, const std::uint16_t* from, std::uint16_t more, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto sum = static_cast<std::uint16_t>(from[i] + more);
    into[i] = sum < into[i] ? sum : into[i];
  }
}

}  // namespace

ClearanceField::ClearanceField(const LitLayers& layers, const Region& region, const Settings& settings,
                               const std::stop_token& stop)
    : layers_(layers),
      clearance_mm_(settings.clearance_mm),
      half_area_mm_{settings.build_area.width_mm() / 2, settings.build_area.height_mm() / 2} {
  const double pitch = layers_.pitch_mm(), step = layers_.step_mm();
  beyond_mm_ = std::sqrt(2 * pitch * pitch + step * step) / 2 + clearance_mm_;
  choose_cells(region);
  edges_ = edges();
  const auto reach = static_cast<std::int32_t>(gap_squares(level_mm_).size()) - 1;
  std::deque<Squares> squares;
  std::vector<const Squares*> near;
  std::int32_t first_near = 0;
  for (std::int32_t level = 0; level < levels_ && !stop.stop_requested(); ++level) {
    while (first_near + static_cast<std::int32_t>(squares.size()) <= std::min(level + reach, levels_ - 1))
      squares.push_back(squares_in(first_near + static_cast<std::int32_t>(squares.size())));
    for (; first_near < level - reach; ++first_near)
      squares.pop_front();
    near.clear();
    for (const Squares& each : squares)
      near.push_back(&each);
    measure(level, near, first_near);
    keep_to_region(level);
  }
}

void ClearanceField::choose_cells(const Region& region) {
  const double pitch = layers_.pitch_mm(), step = layers_.step_mm();
  const auto pixel_of = [&](double mm, std::int32_t pixels) { return mm / pitch + pixels / 2.0; };
  const double left =
      std::max(std::floor(pixel_of(std::max(region.left, -half_area_mm_.x), layers_.columns())), 0.0);
  const double right = std::ceil(pixel_of(std::min(region.right, half_area_mm_.x), layers_.columns()));
  const double back =
      std::max(std::floor(pixel_of(std::max(-region.back, -half_area_mm_.y), layers_.rows())), 0.0);
  const double front = std::ceil(pixel_of(std::min(-region.front, half_area_mm_.y), layers_.rows()));
  first_pixel_ = static_cast<std::int32_t>(left);
  first_pixel_row_ = static_cast<std::int32_t>(back);
  for (pixels_ = std::max(1, static_cast<std::int32_t>(std::ceil(kLeastCell_mm / pitch - 1e-9)));;
       ++pixels_) {
    cell_mm_ = pixels_ * pitch;
    steps_ = static_cast<std::int32_t>(std::ceil(cell_mm_ * kSlant / step));
    level_mm_ = steps_ * step;
    const double columns = std::max(std::ceil((right - left) / pixels_), 1.0);
    const double rows = std::max(std::ceil((front - back) / pixels_), 1.0);
    const double levels = std::max(std::ceil(region.top / level_mm_), 1.0);
    if (columns * rows * levels > static_cast<double>(kMostCells)) continue;
    columns_ = static_cast<std::int32_t>(columns);
    rows_ = static_cast<std::int32_t>(rows);
    levels_ = static_cast<std::int32_t>(levels);
    break;
  }
  distances_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) *
                        static_cast<std::size_t>(levels_),
                    0);
}

ClearanceField::Squares ClearanceField::squares_in(std::int32_t level) const {
  Squares squares(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), kFar);
  mark_solids(level, squares);
  spread_in_rows(squares);
  return spread_across_rows(squares);
}

void ClearanceField::mark_solids(std::int32_t level, Squares& squares) const {
  const std::int32_t end_row = std::min(layers_.rows(), first_pixel_row_ + rows_ * pixels_);
  const std::int32_t end_column = first_pixel_ + columns_ * pixels_;
  for (std::int32_t layer = level * steps_; layer < (level + 1) * steps_; ++layer) {
    for (std::int32_t row = first_pixel_row_; row < end_row; ++row) {
      std::uint16_t* const cells =
          squares.data() +
          static_cast<std::size_t>((row - first_pixel_row_) / pixels_) * static_cast<std::size_t>(columns_);
      for (const LitLayers::Run& run : layers_.runs_in(layer, row)) {
        const std::int32_t first = std::max<std::int32_t>(run.first, first_pixel_);
        const std::int32_t last = std::min<std::int32_t>(run.end, end_column) - 1;
        if (first > last) continue;
        std::fill(cells + (first - first_pixel_) / pixels_, cells + (last - first_pixel_) / pixels_ + 1,
                  std::uint16_t{0});
      }
    }
  }
}

void ClearanceField::spread_in_rows(Squares& squares) const {
  const std::vector<std::uint16_t> gaps = gap_squares(cell_mm_);
  const auto width = static_cast<std::size_t>(columns_);
  const auto pass = [&](std::uint16_t* row, auto index) {
    std::size_t away = gaps.size();
    for (std::size_t i = 0; i < width; ++i) {
      std::uint16_t& square = row[index(i)];
      away = square == 0 ? 0 : away + 1;
      if (away < gaps.size()) square = std::min(square, gaps[away]);
    }
  };
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows_); ++row) {
    std::uint16_t* const cells = squares.data() + row * width;
    if (std::find(cells, cells + width, std::uint16_t{0}) == cells + width) continue;
    pass(cells, [](std::size_t i) { return i; });
    pass(cells, [width](std::size_t i) { return width - 1 - i; });
  }
}

ClearanceField::Squares ClearanceField::spread_across_rows(const Squares& squares) const {
  const std::vector<std::uint16_t> gaps = gap_squares(cell_mm_);
  const auto reach = static_cast<std::int32_t>(gaps.size()) - 1;
  const auto width = static_cast<std::size_t>(columns_);
  Squares spread = squares;
  for (std::int32_t row = 0; row < rows_; ++row) {
    const std::uint16_t* const from = squares.data() + static_cast<std::size_t>(row) * width;
    if (std::all_of(from, from + width, [](std::uint16_t each) { return each == kFar; })) continue;
    for (std::int32_t other = std::max(row - reach, 0); other <= std::min(row + reach, rows_ - 1); ++other) {
      lower_squares(spread.data() + static_cast<std::size_t>(other) * width, from,
                    gaps[static_cast<std::size_t>(std::abs(other - row))], width);
    }
  }
  return spread;
}

// Converts the squared gaps around a level to distances. A solid is somewhere in its cell, and up to half a
// pixel and half a layer beyond.
void ClearanceField::measure(std::int32_t level, std::span<const Squares* const> near,
                             std::int32_t first_near) {
  const std::vector<std::uint16_t> gaps = gap_squares(level_mm_);
  const auto less = static_cast<std::uint8_t>(std::min(std::ceil(beyond_mm_ / kUnit), 255.0));
  Squares nearest(near.front()->size(), kFar);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const auto away = static_cast<std::size_t>(std::abs(first_near + static_cast<std::int32_t>(i) - level));
    if (away < gaps.size()) lower_squares(nearest.data(), near[i]->data(), gaps[away], nearest.size());
  }
  std::uint8_t* const out = distances_.data() + static_cast<std::size_t>(level) * nearest.size();
  const std::vector<std::uint8_t>& root_of = roots();
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint8_t root = root_of[nearest[i]];
    out[i] = root > less ? static_cast<std::uint8_t>(root - less) : std::uint8_t{0};
  }
}

void ClearanceField::keep_to_region(std::int32_t level) {
  std::uint8_t* cells = distances_.data() + static_cast<std::size_t>(level) *
                                                static_cast<std::size_t>(columns_) *
                                                static_cast<std::size_t>(rows_);
  for (std::size_t i = 0; i < edges_.size(); ++i)
    cells[i] = std::min(cells[i], edges_[i]);
}

std::vector<std::uint8_t> ClearanceField::edges() const {
  std::vector<std::uint8_t> all;
  for (std::int32_t row = 0; row < rows_; ++row) {
    for (std::int32_t column = 0; column < columns_; ++column) {
      const PlatePoint middle = middle_of(column, row, 0);
      const double room = std::min(edge_distance(middle), region_distance(middle) - clearance_mm_);
      const double edge = std::clamp(room, 0.0, kGreatest_mm);
      all.push_back(static_cast<std::uint8_t>(edge / kUnit));
    }
  }
  return all;
}

double ClearanceField::edge_distance(const PlatePoint& point) const {
  return std::min(half_area_mm_.x - std::fabs(point.x), half_area_mm_.y - std::fabs(point.y));
}

// Returns the distance to the grid's edges that lie within the build area: beyond them there may be anything.
double ClearanceField::region_distance(const PlatePoint& point) const {
  const PlatePoint first = middle_of(0, 0, 0), last = middle_of(columns_ - 1, rows_ - 1, 0);
  const double half = cell_mm_ / 2;
  double nearest = 2 * kGreatest_mm;
  if (first.x - half > -half_area_mm_.x) nearest = std::min(nearest, point.x - first.x + half);
  if (last.x + half < half_area_mm_.x) nearest = std::min(nearest, last.x + half - point.x);
  if (first.y + half < half_area_mm_.y) nearest = std::min(nearest, first.y + half - point.y);
  if (last.y - half > -half_area_mm_.y) nearest = std::min(nearest, point.y - last.y + half);
  return nearest;
}

PlatePoint ClearanceField::moved_inside(const PlatePoint& center, double radius_mm) const {
  const auto within = [radius_mm](double value, double half) {
    const double most = std::max(half - radius_mm, 0.0);
    return std::clamp(value, -most, most);
  };
  return {within(center.x, half_area_mm_.x), within(center.y, half_area_mm_.y), center.z};
}

std::span<const std::uint8_t> ClearanceField::level(std::int32_t level) const {
  expects(0 <= level && level < levels_, "the level is one of the field's");
  const std::size_t cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  return std::span(distances_).subspan(static_cast<std::size_t>(level) * cells, cells);
}

PlatePoint ClearanceField::middle_of(std::int32_t column, std::int32_t row, std::int32_t level) const {
  const double pitch = layers_.pitch_mm();
  return {(first_pixel_ + (column + 0.5) * pixels_ - layers_.columns() / 2.0) * pitch,
          (layers_.rows() / 2.0 - first_pixel_row_ - (row + 0.5) * pixels_) * pitch,
          (level + 0.5) * level_mm_};
}

ClearanceField::Cell ClearanceField::cell_of(const PlatePoint& point) const {
  const double pitch = layers_.pitch_mm();
  const double column = (point.x / pitch + layers_.columns() / 2.0 - first_pixel_) / pixels_;
  const double row = (layers_.rows() / 2.0 - point.y / pitch - first_pixel_row_) / pixels_;
  const auto whole = [](double value) {
    return static_cast<std::int32_t>(std::floor(std::clamp(value, -1.0, 1e6)));
  };
  return {whole(column), whole(row), whole(point.z / level_mm_)};
}

ClearanceField::Slack ClearanceField::slack_at(const PlatePoint& center, double radius_mm) const {
  Cell cell = cell_of(center);
  if (cell.column < 0 || cell.column >= columns_ || cell.row < 0 || cell.row >= rows_ ||
      cell.level >= levels_)
    return {-1, -1};
  cell.level = std::max(cell.level, 0);
  const std::size_t index = static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(cell.column);
  const std::uint8_t units = level(cell.level)[index];
  const double off = PlateSegment{center, middle_of(cell.column, cell.row, cell.level)}.length();
  const double least = units * kUnit - off - radius_mm;
  const double box = std::sqrt(2 * cell_mm_ * cell_mm_ + level_mm_ * level_mm_);
  // A cell with the greatest distance may be any distance away from the models.
  if (units * kUnit + beyond_mm_ > kGreatest_mm - 2 * kUnit) return {least, kGreatest_mm};
  return {least, (units + 1) * kUnit + beyond_mm_ - clearance_mm_ + off + box - radius_mm};
}

bool ClearanceField::has_room(const PlatePoint& center, double radius_mm) const {
  if (edge_distance(center) < radius_mm) return false;
  const Slack slack = slack_at(center, radius_mm);
  if (slack.least_mm >= 0) return true;
  if (slack.greatest_mm < 0) return false;
  return layers_.is_clear(center, radius_mm + clearance_mm_);
}

// Checks the layers at the points with the least room first: most segments that do not fit fail at once.
bool ClearanceField::has_room(const PlateSegment& segment, double radius_mm) const {
  if (edge_distance(segment.from) < radius_mm || edge_distance(segment.to) < radius_mm) return false;
  struct Look {
    double slack_mm;
    PlatePoint point;
  };
  std::vector<Look> unsure;
  const auto look_at = [&](const PlatePoint& point) {
    const Slack slack = slack_at(point, radius_mm);
    if (slack.least_mm < 0) unsure.push_back({slack.least_mm, point});
    return slack;
  };
  if (look_at(segment.from).greatest_mm < 0 || look_at(segment.to).greatest_mm < 0) return false;
  const double length = segment.length();
  for (double at = kLook_mm; at < length;) {
    const Slack slack = look_at(segment.at(at / length));
    if (slack.greatest_mm < 0) return false;
    at += std::max(slack.least_mm, kLook_mm);
  }
  std::ranges::sort(unsure, {}, &Look::slack_mm);
  return std::ranges::all_of(
      unsure, [&](const Look& look) { return layers_.is_clear(look.point, radius_mm + clearance_mm_); });
}

}  // namespace contourd
