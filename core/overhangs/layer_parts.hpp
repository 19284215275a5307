// The connected parts of each layer of a sweep, and the bodies that they grow into. Parts that touch from
// layer to layer belong to the same body. A part with nothing under it begins a new body; where two bodies
// meet, they become one. Keeps its memory between layers: allocates only while they grow. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"

namespace contourd {

// A group of lit pixels that touch by sides. Groups that touch only by a corner are one part if one of them
// has few pixels: a pixel is lit here if its centre is covered, but resin cures from half the light on, so
// the gap may be just one more grey value.
struct LayerPart {
  std::uint32_t body = 0;
  std::int64_t pixels = 0;
  std::int64_t carried = 0;            // pixels that lie over lit pixels of the layer beneath
  std::int64_t columns = 0, rows = 0;  // sums over the pixels
  bool operator==(const LayerPart&) const = default;
};

class LayerParts {
 public:
  // Adds the next layer up, which lies over `beneath`, the layer before. REQUIRES: runs of masks of the same
  // size; `beneath` unchanged since its own call, or dark for the first layer.
  void add_layer(const MaskRuns& lit, const MaskRuns& beneath);

  // Returns the parts of the last layer, in the order of their topmost runs.
  [[nodiscard]] std::span<const LayerPart> parts() const { return parts_; }
  // Returns the part of a pixel of the last layer. REQUIRES: `lit` is the last layer, and the pixel is lit in
  // it.
  [[nodiscard]] const LayerPart& part_at(const MaskRuns& lit, std::int32_t row, std::int32_t column) const;
  // Returns, for each run of the last layer, the index of its part in parts().
  [[nodiscard]] std::span<const std::uint32_t> part_of_run() const { return part_of_run_; }

  // Two bodies that became one in the last layer; `body`, the higher of the two numbers, is no longer used.
  struct Meeting {
    std::uint32_t body, into;
  };
  [[nodiscard]] std::span<const Meeting> meetings() const { return meetings_; }

  // Returns the number of bodies so far; all body numbers are below it.
  [[nodiscard]] std::uint32_t bodies() const { return static_cast<std::uint32_t>(body_parent_.size()); }

 private:
  [[nodiscard]] std::uint32_t body_now(std::uint32_t body);
  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  // Numbers of two runs, in this row and in the row above.
  struct RunPair {
    std::uint32_t above, here;
  };
  void join_runs(const RunPair& pair);
  void join_by_sides(const MaskRuns& lit, std::int32_t row);
  void join_by_corners(const MaskRuns& lit);
  void number_parts(const MaskRuns& lit);
  void take_over_bodies(const MaskRuns& lit, const MaskRuns& beneath, std::int32_t row);
  void join_bodies(std::uint32_t& body, std::uint32_t other);

  std::vector<std::uint32_t> run_parent_;
  std::vector<RunPair> corners_;           // pairs of runs that touch only by a corner
  std::vector<std::int64_t> side_pixels_;  // by root: pixels of the group of runs that touch by sides
  std::vector<LayerPart> parts_;
  std::vector<LayerPart> parts_beneath_;
  std::vector<std::uint32_t> part_of_run_, part_of_run_beneath_;
  std::vector<Meeting> meetings_;
  std::vector<std::uint32_t> body_parent_;  // a body's root is its own parent, and has the lowest number
};

}  // namespace contourd
