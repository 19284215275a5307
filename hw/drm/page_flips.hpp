// Which picture a CRTC shows, which one comes with the next refresh, and which was asked for meanwhile: black
// and masks by turns. Knows nothing of what is in them. Not thread-safe; allocates in the constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hw/clock.hpp"
#include "hw/drm/crtc.hpp"

namespace contourd {

// How long the kernel may take to say that a flip is done: its word comes within a refresh or two. Ten
// refreshes, and 250 ms at the least, for a machine that is busy.
[[nodiscard]] Duration flip_deadline(Duration frame);

class PageFlips {
 public:
  // Framebuffers' ids; two masks at the least. Black is on the screen.
  PageFlips(std::uint32_t black, std::vector<std::uint32_t> masks);

  // The mask, by its index, that may be written: neither on the screen nor about to be.
  [[nodiscard]] std::size_t mask_to_write() noexcept;

  // The picture for the next refresh, or for the one after a flip that is still waiting. Returns 0 or an
  // errno. show_written() shows the mask that mask_to_write() gave last.
  [[nodiscard]] int show_written(Crtc& crtc, TimePoint now) noexcept;
  [[nodiscard]] int show_black(Crtc& crtc, TimePoint now) noexcept;
  // Black and nothing else from now on. Neither blocks nor waits: a flip to a mask that is under way cannot
  // be called back, so that this mask is to be blackened where it is.
  struct Blackout {
    int error = 0;
    std::optional<std::size_t> mask_under_way;
  };
  [[nodiscard]] Blackout black_now(Crtc& crtc, TimePoint now) noexcept;

  // The kernel says that the flip with this serial is done. Nothing for one that is no longer of interest.
  struct Done {
    bool all = false;  // the picture asked for last is on the screen
    int error = 0;     // of the flip that waited for its turn
  };
  [[nodiscard]] std::optional<Done> finish(Crtc& crtc, std::uint64_t serial, TimePoint now) noexcept;

  // Black is on the screen by other means. An event that is still to come will bear an old serial.
  void reset() noexcept;

  // Since when the kernel owes its word.
  [[nodiscard]] std::optional<TimePoint> waiting_since() const noexcept;

 private:
  struct Flip {
    std::size_t picture = 0;
    std::uint64_t serial = 0;
    TimePoint since;
  };
  static constexpr std::size_t kBlack = 0;  // masks follow

  [[nodiscard]] bool is_free(std::size_t picture) const noexcept;
  [[nodiscard]] int show(Crtc& crtc, std::size_t picture, TimePoint now) noexcept;
  void now_on_screen(std::size_t picture) noexcept;

  std::vector<std::uint32_t> pictures_;
  std::size_t on_screen_ = kBlack;
  std::size_t before_ = kBlack;  // what was on the screen before that
  std::size_t written_ = 1;
  std::optional<std::size_t> next_;  // asked for while a flip was waiting
  std::optional<Flip> flip_;         // waiting for its refresh
  std::uint64_t serial_ = 0;
};

}  // namespace contourd
