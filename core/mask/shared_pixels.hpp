// Finds the pixels of a band of rows that more than one outline passes, and how much of each is filled.
//
// In a pixel that a single outline passes, the mean winding number gives the filled part, however many
// polygons overlap there: the others cover all of the pixel or nothing of it. Only pixels that several
// outlines share need the sides themselves. Every side therefore counts how often it crosses the edges of the
// pixels that it passes: an outline that passes a pixel crosses two. The sides of shared pixels, which are
// few, are collected afterwards (PixelFill).
//
// The ends of sides are rounded to units of 1 / 2^kWindingBits pixel, so that two sides that meet are cut
// alike at every edge. A pixel contains its left and its upper edge. Not thread-safe; allocates only while
// the number of sides grows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/mask/pixel_fill.hpp"

namespace contourd {

// A directed side whose ends are whole units.
struct UnitSide {
  std::int32_t from_x, from_y, to_x, to_y;
};

class SharedPixels {
 public:
  // `width`: the display's columns. `stride`: the cells of a row in the band.
  SharedPixels(std::int32_t width, std::size_t stride, std::int32_t rows);

  // A side's piece within one row of the band, from the column of its upper end to that of its lower end.
  struct SidePiece {
    std::uint32_t side;  // number for collect()
    std::int32_t row, top, bottom;
    bool crosses_above, crosses_below;  // the row's upper edge, and its lower edge
    bool runs_down;
  };
  void count(const SidePiece& piece) {
    std::uint32_t* const counts = counts_of(piece.row);
    counts[piece.top] += piece.crosses_above ? kEdge : 0;
    counts[piece.bottom] += piece.crosses_below ? kEdge : 0;
    count_columns(piece.side, piece.row, std::min(piece.top, piece.bottom), std::max(piece.top, piece.bottom),
                  piece.runs_down ? kDown : kUp);
  }
  // Counts a level side within a row, in columns `first` to `last`.
  void count_level(std::uint32_t side, std::int32_t row, std::int32_t first, std::int32_t last) {
    count_columns(side, row, first, last, 0);
  }

  // Notes the shared pixels of a block, and forgets what was counted in it. `cells`: the block's cells before
  // they are painted. `winding`: the winding number left of the block, in units.
  void look_at_block(std::int32_t row, std::size_t first_column, const std::uint32_t* cells,
                     std::uint32_t winding);

  struct Pixel {
    std::int32_t row, column;  // in the band
    std::uint32_t winding;     // mean winding number, in units
    std::uint32_t sides = 0, crossings = 0;
    std::uint32_t last_side = kNone, last_crossing = kNone;
  };
  [[nodiscard]] std::span<const Pixel> pixels() const { return pixels_; }

  // Collects the sides of the shared pixels, until one pixel is too dense. `first_row`: the band's first row
  // in the mask. `side_of`: returns the UnitSide of a number.
  template <typename SideOf>
  void collect(std::int32_t first_row, SideOf&& side_of) {
    if (!pixels_.empty()) {
      for (const Piece& piece : pieces_) {
        if (too_dense_) break;
        if (is_near_shared(piece)) cut(side_of(piece.side), piece.row, piece.row + first_row);
      }
    }
    pieces_.clear();
  }
  // True if a pixel has more than PixelFill::kMostSides sides.
  [[nodiscard]] bool too_dense() const { return too_dense_; }
  // Returns the filled part of a pixel, 0 to 1; nothing if its mean winding number gives it. REQUIRES: not
  // too_dense().
  [[nodiscard]] std::optional<double> filled(const Pixel& pixel);
  // Forgets the band.
  void clear();

 private:
  // Fields of a pixel's counts: crossings of its edges, pieces of sides, and two flags for pieces that run
  // down, or up.
  static constexpr std::uint32_t kEdge = 1, kPiece = 1U << 16U, kDown = 1U << 30U, kUp = 1U << 31U;
  static constexpr std::uint32_t kEdges = kPiece - kEdge, kPieces = kDown - kPiece;
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  struct Piece {
    std::uint32_t side;
    std::int32_t row, first, last;  // columns
  };
  template <typename Item>
  struct Listed {
    Item item;
    std::uint32_t next;
  };

  [[nodiscard]] std::uint32_t* counts_of(std::int32_t row) {
    return counts_.data() + static_cast<std::size_t>(row) * stride_;
  }
  void count_columns(std::uint32_t side, std::int32_t row, std::int32_t first, std::int32_t last,
                     std::uint32_t direction) {
    std::uint32_t* const counts = counts_of(row);
    for (std::int32_t column = first; column <= last; ++column)
      counts[column] =
          (counts[column] + kPiece + (column > first ? kEdge : 0) + (column < last ? kEdge : 0)) | direction;
    pieces_.push_back({side, row, first, last});
  }
  // Returns the number of pieces in a pixel, times kPiece; 0 if none runs up, or none runs down.
  [[nodiscard]] static std::uint32_t turning_pieces(std::uint32_t counts) {
    return counts >= (kUp | kDown) ? counts & kPieces : 0;
  }
  [[nodiscard]] bool is_near_shared(const Piece& piece) const;
  void cut(const UnitSide& side, std::int32_t row, std::int32_t mask_row);
  void cut_level(const UnitSide& side, std::int32_t row, std::int32_t mask_row);
  void add_side(std::int32_t row, std::int32_t column, const PixelSide& side);
  void add_crossing(std::int32_t row, std::int32_t column, const EdgeCrossing& crossing);

  std::int32_t width_;
  std::size_t stride_;
  // The counts of each pixel of the band; after look_at_block() 0, or a shared pixel's number in pixels_ plus
  // 1.
  std::vector<std::uint32_t> counts_;
  std::vector<Piece> pieces_;
  std::vector<Pixel> pixels_;
  std::vector<Listed<PixelSide>> sides_;
  std::vector<Listed<EdgeCrossing>> crossings_;
  bool too_dense_ = false;
  PixelFill fill_;
};

}  // namespace contourd
