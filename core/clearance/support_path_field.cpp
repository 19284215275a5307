#include "core/clearance/support_path_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace contourd {
namespace {

// Extra clearance at a cell's middle, so that the segment between two middles is clear too.
constexpr double kSpare_mm = 0.06;
// A foot on a model is between kLowestLanding_mm and kHighestLanding_mm high. Where it can stand, the room
// exceeds the branch's radius by at most kNearModel_mm.
constexpr double kLowestLanding_mm = 0.5, kHighestLanding_mm = 2.5, kNearModel_mm = 1;
// Greatest horizontal distance from a contact to its foot on a model.
constexpr double kAside_mm = 8;

// Does `into[i] = min(into[i], from[i] + more)`, where kNoPath stays kNoPath.
void lower_costs(std::uint16_t* into, const std::uint16_t* from, std::uint16_t more, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto sum = static_cast<std::uint16_t>(from[i] + more);
    const std::uint16_t bounded = sum < from[i] ? std::uint16_t{0xFFFF} : sum;
    into[i] = bounded < into[i] ? bounded : into[i];
  }
}

}  // namespace

SupportPathField::SupportPathField(const ClearanceField& field, const Settings& settings,
                                   const std::stop_token& stop)
    : field_(field), widths_(settings.widths), end_(settings.end) {
  const double h = field.cell_mm(), v = field.level_mm();
  const auto units_of = [](double mm) { return static_cast<Cost>(std::ceil(mm / kUnit_mm)); };
  straight_ = units_of(v);
  aside_ = units_of(std::sqrt(v * v + h * h));
  across_ = units_of(std::sqrt(v * v + 2 * h * h));
  costs_.assign(static_cast<std::size_t>(field.columns()) * static_cast<std::size_t>(field.rows()) *
                    static_cast<std::size_t>(field.levels()),
                kNoPath);
  for (std::int32_t level = 0; level < field.levels() && !stop.stop_requested(); ++level) {
    begin_level(level);
    if (level > 0) reach_level(level);
    if (end_ == End::Model) land_on_models(level, settings.from);
    keep_to_room(level);
  }
}

// Blocks cells that are too narrow for a path and adds the cost of another level to cells that are merely
// narrow.
void SupportPathField::keep_to_room(std::int32_t level) {
  const auto units = [](double mm) {
    return static_cast<std::uint8_t>(std::ceil((mm + kSpare_mm) / ClearanceField::kUnit_mm));
  };
  const std::uint8_t least = units(widths_.least_mm), usual = units(widths_.usual_mm);
  const std::span<const std::uint8_t> room = field_.level(level);
  Cost* const costs = costs_.data() + static_cast<std::size_t>(level) * room.size();
  for (std::size_t i = 0; i < room.size(); ++i) {
    const Cost cost = costs[i];
    const Cost narrow = cost >= kNoPath - straight_ ? kNoPath : static_cast<Cost>(cost + straight_);
    costs[i] = room[i] < least ? kNoPath : room[i] < usual ? narrow : cost;
  }
}

void SupportPathField::begin_level(std::int32_t level) {
  if (level > 0 || end_ != End::Plate) return;
  const auto cells = static_cast<std::ptrdiff_t>(field_.level(0).size());
  std::fill(costs_.begin(), costs_.begin() + cells, static_cast<Cost>(straight_ / 2));
}

void SupportPathField::reach_level(std::int32_t level) {
  const auto width = static_cast<std::size_t>(field_.columns());
  const std::size_t cells = field_.level(0).size();
  Cost* const here = costs_.data() + static_cast<std::size_t>(level) * cells;
  const Cost* const beneath = here - cells;
  const std::int32_t rows = field_.rows();
  for (std::int32_t row = 0; row < rows; ++row) {
    Cost* const into = here + static_cast<std::size_t>(row) * width;
    for (std::int32_t from = std::max(row - 1, 0); from <= std::min(row + 1, rows - 1); ++from) {
      const Cost* const other = beneath + static_cast<std::size_t>(from) * width;
      const Cost level_with = from == row ? straight_ : aside_, beside = from == row ? aside_ : across_;
      lower_costs(into, other, level_with, width);
      lower_costs(into + 1, other, beside, width - 1);
      lower_costs(into, other + 1, beside, width - 1);
    }
  }
}

// Starts paths in the cells below which a foot reaches a model.
void SupportPathField::land_on_models(std::int32_t level, std::span<const SupportContact> from) {
  const std::span<const std::uint8_t> room = field_.level(level);
  std::vector<std::uint8_t> near(room.size(), 0);
  for (const SupportContact& contact : from)
    mark_near(contact.place, level, near);
  Cost* const costs = costs_.data() + static_cast<std::size_t>(level) * room.size();
  const auto least = static_cast<std::uint8_t>(widths_.least_mm / ClearanceField::kUnit_mm);
  const auto most = static_cast<std::uint8_t>((widths_.usual_mm + kNearModel_mm) / ClearanceField::kUnit_mm);
  for (std::size_t i = 0; i < room.size(); ++i) {
    if (near[i] == 0 || room[i] < least || room[i] > most) continue;
    const auto cell = static_cast<std::int32_t>(i);
    const PlatePoint middle = field_.middle_of(cell % field_.columns(), cell / field_.columns(), level);
    if (const std::optional<PlatePoint> landing = landing_below(middle))
      costs[i] = std::min(costs[i], static_cast<Cost>((middle.z - landing->z) / kUnit_mm));
  }
}

// Marks the level's cells that a path from the place can reach within 45 degrees, at most kAside_mm aside.
void SupportPathField::mark_near(const PlatePoint& place, std::int32_t level,
                                 std::vector<std::uint8_t>& near) const {
  const ClearanceField::Cell at = field_.cell_of(place);
  const double below = place.z - level * field_.level_mm();
  if (below < 0) return;
  const auto reach = static_cast<std::int32_t>(std::min(below + 1, kAside_mm) / field_.cell_mm());
  const std::int32_t left = std::max(at.column - reach, 0);
  const std::int32_t right = std::min(at.column + reach, field_.columns() - 1);
  for (std::int32_t row = std::max(at.row - reach, 0); row <= std::min(at.row + reach, field_.rows() - 1);
       ++row) {
    const auto cells = near.begin() + std::ptrdiff_t{row} * field_.columns();
    if (left <= right) std::fill(cells + left, cells + right + 1, std::uint8_t{1});
  }
}

std::optional<PlatePoint> SupportPathField::landing_below(const PlatePoint& point) const {
  const LitLayers& layers = field_.layers();
  const std::optional<double> top = layers.top_below(point, kHighestLanding_mm);
  if (!top || point.z - *top < kLowestLanding_mm || point.z - *top > kHighestLanding_mm) return std::nullopt;
  constexpr std::array<std::array<double, 2>, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  for (const auto& [x, y] : kSides) {
    const PlatePoint aside{point.x + x * widths_.landing_mm, point.y + y * widths_.landing_mm, point.z};
    const std::optional<double> beside = layers.top_below(aside, 2 * kHighestLanding_mm);
    if (!beside || std::fabs(*beside - *top) > 1.5 * widths_.landing_mm) return std::nullopt;
  }
  const PlateSegment foot{{point.x, point.y, *top}, point};
  for (double up = ClearanceField::kAtSurface_mm; up < foot.length(); up += ClearanceField::kLook_mm) {
    const double part = up / foot.length();
    const double radius = widths_.landing_mm + (widths_.least_mm - widths_.landing_mm) * part;
    // The surface may rise beside the foot.
    if (!field_.is_free(foot.at(part), std::min(radius, up / 2 - ClearanceField::kAtSurface_mm / 4)))
      return std::nullopt;
  }
  return foot.from;
}

SupportPathField::Cost SupportPathField::cost_at(const ClearanceField::Cell& cell) const {
  if (cell.column < 0 || cell.column >= field_.columns() || cell.row < 0 || cell.row >= field_.rows() ||
      cell.level < 0 || cell.level >= field_.levels())
    return kNoPath;
  return costs_[(static_cast<std::size_t>(cell.level) * static_cast<std::size_t>(field_.rows()) +
                 static_cast<std::size_t>(cell.row)) *
                    static_cast<std::size_t>(field_.columns()) +
                static_cast<std::size_t>(cell.column)];
}

// Returns the cheapest cell whose middle lies within 45 degrees below the point, half a level to one and a
// half levels further down.
std::optional<SupportPathField::Step> SupportPathField::first_step(const PlatePoint& point) const {
  const auto level = static_cast<std::int32_t>(std::floor(std::min(point.z / field_.level_mm(), 1e6) - 1));
  if (level < 0) return std::nullopt;
  const ClearanceField::Cell here = field_.cell_of(point);
  const double drop = point.z - (level + 0.5) * field_.level_mm();
  const auto reach = static_cast<std::int32_t>(std::ceil(drop / field_.cell_mm()));
  std::optional<Step> best;
  for (std::int32_t row = here.row - reach; row <= here.row + reach; ++row) {
    for (std::int32_t column = here.column - reach; column <= here.column + reach; ++column) {
      const ClearanceField::Cell cell{column, row, level};
      const Cost cost = cost_at(cell);
      if (cost == kNoPath || (best && cost * kUnit_mm + drop >= best->cost_mm)) continue;
      const PlateSegment segment{point, field_.middle_of(column, row, level)};
      if (!segment.leads_down()) continue;
      const double all = cost * kUnit_mm + segment.length();
      if (!best || all < best->cost_mm) best = Step{cell, all};
    }
  }
  return best;
}

std::optional<double> SupportPathField::length_from(const PlatePoint& point) const {
  if (end_ == End::Plate && point.z < 1.5 * field_.level_mm()) {
    return point.z;
  }
  const std::optional<Step> step = first_step(point);
  if (!step) return std::nullopt;
  return step->cost_mm;
}

std::optional<ClearanceField::Cell> SupportPathField::next_step(const ClearanceField::Cell& cell) const {
  constexpr std::array<std::array<std::int32_t, 2>, 9> kMoves{
      {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
  std::optional<ClearanceField::Cell> best;
  std::uint32_t best_cost = kNoPath;
  for (const auto& [aside, along] : kMoves) {
    const ClearanceField::Cell next{cell.column + aside, cell.row + along, cell.level - 1};
    const Cost cost = cost_at(next);
    if (cost == kNoPath) continue;
    const Cost move = aside == 0 && along == 0 ? straight_ : aside == 0 || along == 0 ? aside_ : across_;
    if (std::uint32_t{cost} + move < best_cost) {
      best_cost = std::uint32_t{cost} + move;
      best = next;
    }
  }
  return best;
}

// True if a path ends in the cell: on the plate, or on a model if no cell beneath costs less than a foot
// here.
bool SupportPathField::ends_at(const ClearanceField::Cell& cell) const {
  if (end_ == End::Plate) return cell.level == 0;
  const std::optional<ClearanceField::Cell> next = next_step(cell);
  if (!next) return true;
  const PlatePoint middle = field_.middle_of(cell.column, cell.row, cell.level);
  const std::optional<PlatePoint> landing = landing_below(middle);
  return landing && (middle.z - landing->z) / kUnit_mm <= cost_at(*next) + straight_;
}

std::optional<std::vector<PlatePoint>> SupportPathField::steps_from(const PlatePoint& point) const {
  std::vector<PlatePoint> steps{point};
  const std::optional<Step> first = first_step(point);
  if (!first && (end_ == End::Model || !length_from(point))) return std::nullopt;
  if (first) {
    ClearanceField::Cell cell = first->cell;
    steps.push_back(field_.middle_of(cell.column, cell.row, cell.level));
    while (!ends_at(cell)) {
      const std::optional<ClearanceField::Cell> next = next_step(cell);
      if (!next) return std::nullopt;
      cell = *next;
      steps.push_back(field_.middle_of(cell.column, cell.row, cell.level));
    }
  }
  if (end_ == End::Plate) steps.push_back({steps.back().x, steps.back().y, 0});
  return steps;
}

// Returns the radius that has room along the segment; 0 if even the least one does not fit.
double SupportPathField::room_along(const PlateSegment& segment) const {
  if (field_.has_room(segment, widths_.usual_mm)) return widths_.usual_mm;
  const double between = (widths_.usual_mm + widths_.least_mm) / 2;
  if (!field_.has_room(segment, widths_.least_mm)) return 0;
  return field_.has_room(segment, between) ? between : widths_.least_mm;
}

std::optional<SupportPath> SupportPathField::path_from(const PlatePoint& point) const {
  const PlatePoint below{point.x, point.y, 0};
  SupportPath path;
  if (end_ == End::Plate && field_.has_room({point, below}, widths_.usual_mm)) {
    path.stretches.push_back({below, widths_.usual_mm});
    path.length_mm = point.z;
    return path;
  }
  const std::optional<std::vector<PlatePoint>> steps = steps_from(point);
  if (!steps) return std::nullopt;
  for (std::size_t at = 0; at + 1 < steps->size();) {
    std::size_t reached = 0;
    const SupportPath::Stretch stretch = longest_stretch(std::span(*steps).subspan(at), reached);
    if (stretch.radius_mm == 0) return std::nullopt;
    path.stretches.push_back(stretch);
    path.length_mm += PlateSegment{(*steps)[at], stretch.end}.length();
    at += reached;
  }
  if (end_ == End::Model) {
    path.landing = landing_below(steps->back());
    if (!path.landing) return std::nullopt;
  }
  return path;
}

// Returns the longest straight stretch that has room, found by bisection; most paths are straight to their
// end.
SupportPath::Stretch SupportPathField::longest_stretch(std::span<const PlatePoint> steps,
                                                       std::size_t& reached) const {
  const PlatePoint from = steps.front();
  reached = 1;
  double radius = room_along({from, steps[reached]});
  std::size_t look = steps.size() - 1, end = steps.size();
  while (radius > 0 && reached + 1 < end) {
    const PlateSegment segment{from, steps[look]};
    const double room = segment.leads_down() ? room_along(segment) : 0;
    if (room >= radius) {
      reached = look;
      radius = room;
    } else {
      end = look;
    }
    look = reached + (end - reached) / 2;
  }
  return {steps[reached], radius};
}

}  // namespace contourd
