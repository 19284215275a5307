// The state of a CRTC's page flips: the picture on the screen, the one that the next refresh brings, and the
// one that was requested meanwhile. Pictures are black and two or three masks; their content does not matter
// here. Not thread-safe; allocates in the constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hw/clock.hpp"
#include "hw/drm/crtc.hpp"

namespace contourd {

// Returns how long the kernel may take to confirm a flip. It normally does so within two refreshes; the
// deadline is ten refreshes, but at least 250 ms, to allow for a busy machine.
[[nodiscard]] Duration flip_deadline(Duration frame);

class PageFlips {
 public:
  // Takes framebuffers' ids, with at least two masks. Black must be on the screen.
  PageFlips(std::uint32_t black, std::vector<std::uint32_t> masks);

  // Returns the index of a mask that may be written because it is neither on the screen nor about to be.
  [[nodiscard]] std::size_t mask_to_write() noexcept;

  // Both request a picture for the next refresh, or for the refresh after a flip that is still pending.
  // show_written() requests the mask that mask_to_write() returned last. They return 0 or an errno.
  [[nodiscard]] int show_written(Crtc& crtc, TimePoint now) noexcept { return show(crtc, written_, now); }
  [[nodiscard]] int show_black(Crtc& crtc, TimePoint now) noexcept { return show(crtc, kBlack, now); }
  // Requests black and drops any other request. Does not block. A pending flip to a mask cannot be cancelled;
  // the caller must blacken this mask (mask_under_way) in its memory.
  struct Blackout {
    int error = 0;
    std::optional<std::size_t> mask_under_way;
  };
  [[nodiscard]] Blackout black_now(Crtc& crtc, TimePoint now) noexcept;

  // Handles the kernel's event that the flip with this serial is done. Returns nullopt if the serial is not
  // that of the pending flip.
  struct Done {
    bool all = false;  // the picture requested last is on the screen
    int error = 0;     // the errno of a queued flip that was started now
  };
  [[nodiscard]] std::optional<Done> finish(Crtc& crtc, std::uint64_t serial, TimePoint now) noexcept;

  // Records that black is on the screen by other means. An event that still comes has an old serial.
  void reset() noexcept { now_on_screen(kBlack); }

  // Returns since when the pending flip has not been confirmed, or nullopt if none is pending.
  [[nodiscard]] std::optional<TimePoint> waiting_since() const noexcept;

 private:
  struct Flip {
    std::size_t picture = 0;
    std::uint64_t serial = 0;
    TimePoint since;
  };
  static constexpr std::size_t kBlack = 0;  // the masks follow in pictures_

  [[nodiscard]] bool is_free(std::size_t picture) const noexcept;
  [[nodiscard]] int show(Crtc& crtc, std::size_t picture, TimePoint now) noexcept;
  void now_on_screen(std::size_t picture) noexcept;

  std::vector<std::uint32_t> pictures_;
  std::size_t on_screen_ = kBlack;
  std::size_t before_ = kBlack;  // the picture that was on the screen before on_screen_
  std::size_t written_ = 1;
  std::optional<std::size_t> next_;  // requested while a flip was pending
  std::optional<Flip> flip_;         // pending until its refresh
  std::uint64_t serial_ = 0;
};

}  // namespace contourd
