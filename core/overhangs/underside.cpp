#include "core/overhangs/underside.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Neighbours by side come first.
constexpr std::array<SweepPixel, 8> kNeighbours{
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
constexpr double kFieldMm = 0.5;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Flood marks have this bit set, so that they differ from the indices of new pixels.
constexpr std::uint32_t kFlood = 0x80000000;

SweepPixel operator+(SweepPixel a, SweepPixel b) {
  return {a.column + b.column, a.row + b.row};
}

// Calls visit(first, end), from left to right, for the stretches of `run` that none of `others` covers;
// `others` are runs of the same row.
template <typename Visit>
void for_each_gap(const PixelRun& run, std::span<const PixelRun>& others, Visit&& visit) {
  while (!others.empty() && others.front().end <= run.first)
    others = others.subspan(1);
  std::int32_t at = run.first;
  for (const PixelRun& other : others) {
    if (other.first >= run.end) break;
    if (other.first > at) visit(at, other.first);
    at = std::max(at, other.end);
  }
  if (at < run.end) visit(at, run.end);
}

}  // namespace

Underside::Underside(const SweepGrid& grid)
    : grid_(grid),
      stride_(static_cast<std::size_t>(grid.display.width.count()) + 2),
      field_(std::max(1, static_cast<std::int32_t>(kFieldMm / grid.pixel_mm()))) {
  const std::size_t cells = stride_ * (static_cast<std::size_t>(grid.display.height.count()) + 2);
  levels_.resize(1);
  cells_.resize(cells);
  mark_.resize(cells);
}

double Underside::reach_of(SweepPixel pixel, const Cell& cell, std::int32_t layer) const {
  if (cell.holder_layer == 0) return kInfinite;
  const double distance = std::sqrt(squared_distance(pixel, {cell.column, cell.row})) * grid_.pixel_mm();
  const double grown = levels_[static_cast<std::size_t>(layer)] - levels_[cell.holder_layer];
  return distance - grown * grid_.step_mm();
}

bool Underside::hangs_alone(SweepPixel pixel) const {
  const auto hangs = [this](SweepPixel at) { return std::isinf(reach_mm(at)); };
  return is_lit(pixel) && hangs(pixel) && std::ranges::all_of(kNeighbours, [&](const SweepPixel& step) {
           return !is_lit(pixel + step) || hangs(pixel + step);
         });
}

// Counts lit pixels from `from` in a direction, not including `from`, up to `most`.
std::int32_t Underside::lit_pixels(SweepPixel from, SweepPixel step, std::int32_t most) const {
  std::int32_t pixels = 0;
  for (from = from + step; pixels < most && is_lit(from); from = from + step)
    ++pixels;
  return pixels;
}

SweepPixel Underside::centered(SweepPixel at, std::int32_t tip_pixels) const {
  // First along the row, then along the column, then along the row that this led to.
  for (const SweepPixel step : {SweepPixel{1, 0}, SweepPixel{0, 1}, SweepPixel{1, 0}}) {
    const std::int32_t forward = lit_pixels(at, step, 2 * tip_pixels);
    const std::int32_t backward = lit_pixels(at, {-step.column, -step.row}, 2 * tip_pixels);
    if (forward >= tip_pixels && backward >= tip_pixels) continue;
    std::int32_t shift = (forward - backward) / 2;
    if (forward >= tip_pixels) shift = std::min(shift, tip_pixels - backward);
    if (backward >= tip_pixels) shift = std::max(shift, forward - tip_pixels);
    at = {at.column + step.column * shift, at.row + step.row * shift};
  }
  return at;
}

// Returns the holder that a lit pixel of the layer beneath passes on to its neighbours: its own holder, or
// the pixel itself if it does not reach out.
Underside::Cell Underside::held_by(SweepPixel pixel, const Cell& cell) const {
  if (reach_of(pixel, cell, layer_ - 1) > 0) return cell;
  return {static_cast<std::int16_t>(pixel.column), static_cast<std::int16_t>(pixel.row),
          static_cast<std::uint16_t>(layer_ - 1), 0};
}

void Underside::add_layer(const Layer& layer, const Thresholds& thresholds) {
  ++layer_;
  expects(layer_ < std::numeric_limits<std::uint16_t>::max(), "layers have 16-bit numbers");
  levels_.push_back(static_cast<double>(layer.height.count()) / static_cast<double>(grid_.step.count()));
  new_.clear();
  any_uncarried_ = false;
  const std::span<const LayerPart> parts = layer.parts.parts();
  for (std::int32_t row = 0; row < layer.lit.rows(); ++row) {
    std::span<const PixelRun> beneath = layer.beneath.in_row(row);
    std::uint32_t number = layer.lit.first_in_row(row);
    for (const PixelRun& run : layer.lit.in_row(row)) {
      const std::uint32_t part = layer.parts.part_of_run()[number++];
      const Beginning beginning = layer.rests || layer_ == 1 ? Beginning::OnPlate
                                  : parts[part].carried == 0 ? Beginning::InIsland
                                                             : Beginning::BesideMaterial;
      for_each_gap(run, beneath, [&](std::int32_t first, std::int32_t end) {
        add_run({row, first, end, 0}, part, beginning);
      });
    }
  }
  if (any_uncarried_) bridge();
  darken(layer.lit, layer.beneath);
  collect(thresholds);
}

void Underside::add_run(const PixelRun& run, std::uint32_t part, Beginning beginning) {
  for (std::int32_t column = run.first; column < run.end; ++column)
    add_pixel({column, run.row}, part, beginning);
}

void Underside::add_pixel(SweepPixel pixel, std::uint32_t part, Beginning beginning) {
  Cell& here = cells_[index_of(pixel)];
  here = {static_cast<std::int16_t>(pixel.column), static_cast<std::int16_t>(pixel.row), 0,
          static_cast<std::uint16_t>(layer_)};
  if (beginning == Beginning::OnPlate) {
    here.holder_layer = here.born;
    return;
  }
  mark_[index_of(pixel)] = static_cast<std::uint32_t>(new_.size());
  new_.push_back({pixel, part, {-1, -1}});
  if (beginning == Beginning::InIsland) return;
  double least = kInfinite;
  for (const SweepPixel& step : kNeighbours) {
    const SweepPixel next = pixel + step;
    const Cell& there = cells_[index_of(next)];
    if (there.born == 0 || there.born == layer_) continue;
    if (new_.back().carrier.column < 0) new_.back().carrier = next;
    const Cell holder = held_by(next, there);
    const double reach = reach_of(pixel, holder, layer_);
    if (reach >= least) continue;
    least = reach;
    here.column = holder.column;
    here.row = holder.row;
    here.holder_layer = holder.holder_layer;
    if (reach <= grid_.pixel_mm()) return;
  }
  if (least == kInfinite) any_uncarried_ = true;
}

// Spreads carriers from the new pixels that have one beside them to the others, through connected new pixels;
// each gets the nearest carrier found.
void Underside::bridge() {
  queue_.clear();
  for (std::uint32_t i = 0; i < new_.size(); ++i) {
    if (new_[i].carrier.column >= 0) queue_.push_back(i);
  }
  for (std::size_t turn = 0; turn < queue_.size(); ++turn) {
    const NewPixel from = new_[queue_[turn]];
    for (const SweepPixel& step : kNeighbours) {
      const SweepPixel next = from.at + step;
      if (cells_[index_of(next)].born != layer_) continue;
      NewPixel& to = new_[mark_[index_of(next)]];
      if (to.part != from.part) continue;
      if (to.carrier.column >= 0 &&
          squared_distance(next, to.carrier) <= squared_distance(next, from.carrier))
        continue;
      to.carrier = from.carrier;
      const Cell holder = held_by(from.carrier, cell(from.carrier));
      Cell& here = cells_[index_of(next)];
      here.column = holder.column;
      here.row = holder.row;
      here.holder_layer = holder.holder_layer;
      queue_.push_back(mark_[index_of(next)]);
    }
  }
}

void Underside::darken(const MaskRuns& lit, const MaskRuns& beneath) {
  for (std::int32_t row = 0; row < lit.rows(); ++row) {
    std::span<const PixelRun> others = lit.in_row(row);
    for (const PixelRun& run : beneath.in_row(row)) {
      for_each_gap(run, others, [&](std::int32_t first, std::int32_t end) {
        for (std::int32_t column = first; column < end; ++column)
          cells_[index_of({column, row})].born = 0;
      });
    }
  }
}

void Underside::collect(const Thresholds& thresholds) {
  reaching_.clear();
  samples_.clear();
  for (const NewPixel& pixel : new_) {
    const double reach = reach_mm(pixel.at);
    const bool steep = reach <= 1.5 * grid_.pixel_mm();
    const std::int32_t field = steep ? 2 * field_ : field_;
    if (pixel.at.column % field == 0 && pixel.at.row % field == 0)
      samples_.push_back({pixel.at, pixel.part, steep});
    double bridge = 0;
    if (pixel.carrier.column < 0) {
      bridge = kInfinite;
    } else if (any_uncarried_) {
      bridge = std::sqrt(squared_distance(pixel.at, pixel.carrier)) * grid_.pixel_mm();
    }
    if (reach > thresholds.reach_mm || bridge > thresholds.bridge_mm)
      reaching_.push_back({pixel.at, pixel.part, reach, bridge});
  }
}

void Underside::hold(SweepPixel contact, double radius_mm) {
  expects(is_lit(contact), "the contact is lit");
  const Cell held{static_cast<std::int16_t>(contact.column), static_cast<std::int16_t>(contact.row),
                  cell(contact).born, 0};
  const double radius_pixels = radius_mm / grid_.pixel_mm();
  const std::uint32_t mark = kFlood | ++floods_;
  flood_.assign(1, contact);
  mark_[index_of(contact)] = mark;
  for (std::size_t turn = 0; turn < flood_.size(); ++turn) {
    const SweepPixel at = flood_[turn];
    Cell& here = cells_[index_of(at)];
    if (reach_of(at, held, layer_) < reach_of(at, here, layer_)) {
      here.column = held.column;
      here.row = held.row;
      here.holder_layer = held.holder_layer;
    }
    for (const SweepPixel& step : kNeighbours) {
      const SweepPixel next = at + step;
      if (cells_[index_of(next)].born == 0 || mark_[index_of(next)] == mark) continue;
      if (squared_distance(next, contact) > radius_pixels * radius_pixels) continue;
      mark_[index_of(next)] = mark;
      flood_.push_back(next);
    }
  }
}

}  // namespace contourd
