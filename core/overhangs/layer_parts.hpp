// A sweep's layers as connected parts, and the bodies that these grow into: parts that touch from layer to
// layer are one body. What begins with nothing under it is a new one; where two meet they are one from then
// on. Keeps its memory between layers: allocates only while they grow. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"

namespace contourd {

// Its pixels touch by sides. By a corner hangs only what has few pixels, since one more grey value may be the
// gap: a pixel is lit here where its centre is, and cures from half the light on.
struct LayerPart {
  std::uint32_t body = 0;
  std::int64_t pixels = 0;
  std::int64_t carried = 0;  // of them, over lit ones of the layer beneath
  bool operator==(const LayerPart&) const = default;
};

class LayerParts {
 public:
  // The next layer up, over `beneath`, the one before. REQUIRES: runs of masks of the same size; `beneath` as
  // it was then, or dark for the first.
  void add_layer(const MaskRuns& lit, const MaskRuns& beneath);

  // Of the layer that was added last, in the order of their topmost runs.
  [[nodiscard]] std::span<const LayerPart> parts() const { return parts_; }
  // That of a pixel. REQUIRES: `lit` is that layer's, and lit there.
  [[nodiscard]] const LayerPart& part_at(const MaskRuns& lit, std::int32_t row, std::int32_t column) const;
  // Index in parts(), by run of that layer.
  [[nodiscard]] std::span<const std::uint32_t> part_of_run() const { return part_of_run_; }

  // Bodies that have become one in that layer: of each two the higher number is no body's any more.
  struct Meeting {
    std::uint32_t body, into;
  };
  [[nodiscard]] std::span<const Meeting> meetings() const { return meetings_; }

  // Bodies have the numbers below this.
  [[nodiscard]] std::uint32_t bodies() const { return static_cast<std::uint32_t>(body_parent_.size()); }

 private:
  [[nodiscard]] std::uint32_t body_now(std::uint32_t body);
  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  // By their numbers; of rows that follow each other.
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
  std::vector<RunPair> corners_;           // that touch by a corner alone
  std::vector<std::int64_t> side_pixels_;  // by root, of what touches by sides
  std::vector<LayerPart> parts_;
  std::vector<LayerPart> parts_beneath_;
  std::vector<std::uint32_t> part_of_run_, part_of_run_beneath_;
  std::vector<Meeting> meetings_;
  std::vector<std::uint32_t> body_parent_;  // a body's root is its own parent, and has the lowest number
};

}  // namespace contourd
