#include "core/overhangs/layer_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFF;

// Two groups of pixels that touch only by a corner are joined if one of them has fewer pixels than this.
constexpr std::int64_t kFewestBesideCorner = 10;

}  // namespace

void LayerParts::add_layer(const MaskRuns& lit, const MaskRuns& beneath) {
  expects(lit.rows() == beneath.rows() && beneath.runs().size() == part_of_run_.size(),
          "the layer beneath is the previous one and has the same size");
  std::swap(parts_, parts_beneath_);
  std::swap(part_of_run_, part_of_run_beneath_);
  const auto runs = static_cast<std::uint32_t>(lit.runs().size());
  meetings_.clear();
  run_parent_.resize(runs);
  for (std::uint32_t run = 0; run < runs; ++run)
    run_parent_[run] = run;
  corners_.clear();
  for (std::int32_t row = 1; row < lit.rows(); ++row)
    join_by_sides(lit, row);
  if (!corners_.empty()) join_by_corners(lit);
  number_parts(lit);
  for (std::int32_t row = 0; row < lit.rows(); ++row)
    take_over_bodies(lit, beneath, row);
  for (LayerPart& part : parts_) {
    if (part.body == kNone) {
      part.body = bodies();
      body_parent_.push_back(part.body);
    }
  }
  for (LayerPart& part : parts_)
    part.body = body_now(part.body);
}

const LayerPart& LayerParts::part_at(const MaskRuns& lit, std::int32_t row, std::int32_t column) const {
  expects(lit.runs().size() == part_of_run_.size(), "the runs are the last layer's");
  const std::span<const PixelRun> runs = lit.in_row(row);
  const auto run = std::ranges::find_if(runs, [column](const PixelRun& each) { return column < each.end; });
  expects(run != runs.end() && run->first <= column, "the pixel is lit in the last layer");
  return parts_[part_of_run_[lit.first_in_row(row) + static_cast<std::size_t>(run - runs.begin())]];
}

std::uint32_t LayerParts::body_now(std::uint32_t body) {
  while (body_parent_[body] != body) {
    body_parent_[body] = body_parent_[body_parent_[body]];
    body = body_parent_[body];
  }
  return body;
}

std::uint32_t LayerParts::root_of(std::uint32_t run) {
  while (run_parent_[run] != run) {
    run_parent_[run] = run_parent_[run_parent_[run]];
    run = run_parent_[run];
  }
  return run;
}

void LayerParts::join_runs(const RunPair& pair) {
  const std::uint32_t a = root_of(pair.above), b = root_of(pair.here);
  run_parent_[std::max(a, b)] = std::min(a, b);
}

// Joins runs of this row and the row above that touch by a side, and notes the pairs that touch only by a
// corner.
void LayerParts::join_by_sides(const MaskRuns& lit, std::int32_t row) {
  const std::span<const PixelRun> above = lit.in_row(row - 1), here = lit.in_row(row);
  const std::uint32_t first_above = lit.first_in_row(row - 1), first_here = lit.first_in_row(row);
  // A reach of one column includes pixels that touch by a corner.
  for_each_meeting(above, here, 1, [&](std::size_t i, std::size_t j) {
    const RunPair pair{first_above + static_cast<std::uint32_t>(i),
                       first_here + static_cast<std::uint32_t>(j)};
    if (above[i].first < here[j].end && here[j].first < above[i].end) {
      join_runs(pair);
    } else {
      corners_.push_back(pair);
    }
  });
}

void LayerParts::join_by_corners(const MaskRuns& lit) {
  const auto runs = static_cast<std::uint32_t>(lit.runs().size());
  // Pixels of each group of runs that touch by sides, indexed by the group's first run.
  side_pixels_.assign(runs, 0);
  for (std::uint32_t run = 0; run < runs; ++run)
    side_pixels_[root_of(run)] += lit.runs()[run].end - lit.runs()[run].first;
  const auto hangs_on = [this](const RunPair& corner) {
    return std::min(side_pixels_[root_of(corner.above)], side_pixels_[root_of(corner.here)]) <
           kFewestBesideCorner;
  };
  // All pairs are judged before any is joined, so their order does not matter.
  std::erase_if(corners_, [&](const RunPair& corner) { return !hangs_on(corner); });
  for (const RunPair& corner : corners_)
    join_runs(corner);
}

void LayerParts::number_parts(const MaskRuns& lit) {
  parts_.clear();
  part_of_run_.resize(run_parent_.size());
  for (std::uint32_t run = 0; run < run_parent_.size(); ++run) {
    const std::uint32_t root = root_of(run);
    if (root == run) {
      part_of_run_[run] = static_cast<std::uint32_t>(parts_.size());
      parts_.push_back({.body = kNone});
    }
    part_of_run_[run] = part_of_run_[root];
    const PixelRun& pixels = lit.runs()[run];
    LayerPart& part = parts_[part_of_run_[run]];
    const std::int64_t length = pixels.end - pixels.first;
    part.pixels += length;
    part.columns += length * (pixels.first + pixels.end - 1) / 2;
    part.rows += length * pixels.row;
  }
}

void LayerParts::take_over_bodies(const MaskRuns& lit, const MaskRuns& beneath, std::int32_t row) {
  const std::span<const PixelRun> here = lit.in_row(row), under = beneath.in_row(row);
  const std::uint32_t first_here = lit.first_in_row(row), first_under = beneath.first_in_row(row);
  for_each_meeting(here, under, 0, [&](std::size_t i, std::size_t j) {
    LayerPart& part = parts_[part_of_run_[first_here + i]];
    part.carried += std::min(here[i].end, under[j].end) - std::max(here[i].first, under[j].first);
    join_bodies(part.body, parts_beneath_[part_of_run_beneath_[first_under + j]].body);
  });
}

void LayerParts::join_bodies(std::uint32_t& body, std::uint32_t other) {
  const std::uint32_t b = body_now(other);
  if (body == kNone) {
    body = b;
    return;
  }
  const std::uint32_t a = body_now(body);
  if (a == b) return;
  meetings_.push_back({std::max(a, b), std::min(a, b)});
  body_parent_[std::max(a, b)] = std::min(a, b);
  body = std::min(a, b);
}

}  // namespace contourd
